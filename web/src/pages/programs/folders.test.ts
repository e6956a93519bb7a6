import { expect, it } from "vitest";
import { foldersOf } from "./folders";

it("folders stand below their parents, numbers in order, parents are added", () => {
  expect(foldersOf(["/b/10", "/b/9", "/a b/c", "/b"]).map((one) => `${one.depth}${one.path}`)).toEqual(["1/a b", "2/a b/c", "1/b", "2/b/9", "2/b/10"]);
});
