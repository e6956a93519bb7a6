import { describe, expect, it } from "vitest";
import { sameBlock, tokens } from "./tokens";
import { chunksOf, firstAt, heightPx, isScaled, lastFirst, longestPx, scrollAt } from "./window";

const kinds = (line: string) => tokens(line).filter((token) => token.text.trim() !== "").map((token) => [token.kind, token.text.trim()]);

describe("colours of a block", () => {
  it("tells words apart", () => {
    expect(kinds("N10 G01X-20.5 F0.2 M08 (FACE)")).toEqual([["sequence", "N10"], ["g", "G01"], ["axis", "X-20.5"], ["fst", "F0.2"], ["m", "M08"], ["comment", "(FACE)"]]);
  });
  it("knows macro words", () => expect(kinds("IF[#1GT5]GOTO100").map(([kind]) => kind)).toContain("macro"));
  it("loses no character", () => {
    for (const line of ["%", "O1001 (X", "#100=#5041+[3*SIN[30]]", ";中文 注释", "G0X1;end", ""]) expect(tokens(line).map((t) => t.text).join("")).toBe(line);
  });
  it("cuts what nobody can read", () => expect(tokens("X1".repeat(1_000_000)).map((t) => t.text).join("").length).toBeLessThan(600));
});

describe("a listing's window", () => {
  it("reaches the last line of five million", () => {
    const extent = { total: 5_000_000, viewPx: 440 };
    expect(isScaled(extent)).toBe(true);
    expect(heightPx(extent)).toBe(longestPx);
    expect(firstAt(longestPx - 440, extent)).toBeCloseTo(lastFirst(extent));
    expect(lastFirst(extent)).toBe(5_000_000 - 20);
  });
  it("goes there and back", () => {
    const extent = { total: 300_000_0, viewPx: 440 };
    expect(firstAt(scrollAt(1_234_567, extent), extent)).toBeCloseTo(1_234_567, 3);
  });
  it("does not scroll what fits", () => expect(firstAt(0, { total: 5, viewPx: 440 })).toBe(0));
  it("asks for the pieces it shows", () => {
    expect(chunksOf(190, 30, 1000)).toEqual([0, 1]);
    expect(chunksOf(0, 30, 10)).toEqual([0]);
    expect(chunksOf(0, 30, 0)).toEqual([]);
  });
});

describe("the running block", () => {
  it("is found again without blanks and comments", () => expect(sameBlock("N140 G01 Z-54.8 (ROUGH)", "N140G01Z-54.8")).toBe(true));
  it("of a sub-program is not mistaken for the same line of the main program", () => expect(sameBlock("N110 G02 X10. Y88. R18.", "N110 X-20.")).toBe(false));
});
