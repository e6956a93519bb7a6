import { describe, expect, it } from "vitest";
import { conflicts, findRows, itemsOf, parseCell, pasteAt, toolSheet, variableSheet, withEdit, workSheet } from "./grid";
import type { OffsetPage } from "./types";

const lathe: OffsetPage = { axes: ["X", "Z"], numbers: 400, lathe: true, memory: "C", wear: true, largest_mm: 9999.999, largest_wear_mm: 9999.999, tips: 9, work_systems: 6, extra_systems: 0, variables: [[100, 199], [500, 999]] };
const mill: OffsetPage = { ...lathe, lathe: false, axes: ["X", "Y", "Z"], extra_systems: 48 };

describe("a page of values", () => {
  it("has the controller's columns and numbers", () => {
    expect(toolSheet(lathe).columns.map((one) => one.head)).toEqual(["X", "X wear", "Z", "Z wear", "R", "R wear", "tip"]);
    expect(toolSheet(lathe).rows).toHaveLength(400);
    expect(toolSheet(mill).rows[2]?.cells).toEqual(["tool/3/geometry/Z", "tool/3/wear/Z", "tool/3/radius", "tool/3/radius_wear"]);
    expect(toolSheet({ ...mill, memory: "A", wear: false }).columns).toHaveLength(1);
    expect(workSheet(mill).rows).toHaveLength(55);
    expect(workSheet(lathe).rows[1]?.cells).toEqual(["work/shift/X", "work/shift/Z"]);
    expect(variableSheet(lathe).rows).toHaveLength(600);
    expect(variableSheet({ ...lathe, variables: [[200, 229], [200, 209]] }).rows).toHaveLength(30);
  });
  it("reads what is typed as the controller does", () => {
    const wear = "tool/1/wear/X";
    expect(parseCell("0.02", 0.01, wear)).toBe(0.02);
    expect(parseCell("+0.02", 0.01, wear)).toBe(0.03);
    expect(parseCell("-0,5", 1, wear)).toBe(-0.5);
    expect(parseCell("−1", 1, wear)).toBe(-1);
    expect(parseCell("", 1, wear)).toBe(0);
    expect(parseCell("", 1, "variable/500")).toBeNull();
    for (const bad of ["x", "1.2.3", "=A1", "1 2", "--1", "1e", "."]) expect(parseCell(bad, 1, wear)).toBeUndefined();
  });
  it("remembers what the person saw, and sees when it is no longer so", () => {
    let edits = withEdit(new Map(), { "tool/1/wear/X": 0.01 }, "tool/1/wear/X", 0.02);
    edits = withEdit(edits, { "tool/1/wear/X": 0.5 }, "tool/1/wear/X", 0.03);
    expect(itemsOf(edits)).toEqual([{ what: "tool/1/wear/X", before: 0.01, after: 0.03 }]);
    expect(conflicts({ before: 0.01, after: 0.03 }, { "tool/1/wear/X": 0.5 }, "tool/1/wear/X")).toBe(true);
    expect(withEdit(edits, {}, "tool/1/wear/X", 0.01).size).toBe(0);
  });
  it("finds numbers, spans and what is set", () => {
    const { rows } = toolSheet(lathe);
    expect(findRows(rows, "12-14", {}).map((row) => row.label)).toEqual(["12", "13", "14"]);
    expect(findRows(rows, "*", { "tool/7/tip": 3 }).map((row) => row.label)).toEqual(["7"]);
    expect(findRows(rows, "399", {}).map((row) => row.label)).toEqual(["399"]);
    expect(findRows(rows, "-112", { "tool/9/geometry/X": -112.5 }).map((row) => row.label)).toEqual(["9"]);
  });
  it("sets a paste down where the cursor is", () => {
    const sheet = toolSheet(lathe);
    expect(pasteAt("0.1\t2\r\n0.2\t3\r\n", sheet, sheet.rows, 4, 1)).toBe("number\tX wear\tZ\n5\t0.1\t2\n6\t0.2\t3");
    const variables = variableSheet(lathe);
    expect(pasteAt("7", variables, variables.rows, 100, 0)).toBe("what\tvalue\nvariable/500\t7");
    expect(pasteAt("1\n2\n3", sheet, sheet.rows, 398, 6)).toBe("number\ttip\n399\t1\n400\t2");
  });
});
