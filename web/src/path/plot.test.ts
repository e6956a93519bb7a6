import { describe, expect, it } from "vitest";
import { bounds, expand, inDiameters, isLathe, niceStep, Trail } from "./plot";

describe("a plot", () => {
  it("has a move for every chord of an arc", () => {
    const plot = expand({ axes: ["X", "Z"], truncated: false, moves: [{ k: "r", l: 1, p: [50, 2] }, { k: "a", l: 2, p: [50, 1, 48, 0, 46, -2] }] });
    expect(plot.moves.map((move) => move.p)).toEqual([[50, 2], [50, 1], [48, 0], [46, -2]]);
    expect(plot.moves.map((move) => move.l)).toEqual([1, 2, 2, 2]);
  });
  it("of a lathe comes in radii and is shown in diameters, of a mill stays as it is", () => {
    const lathe = { axes: ["X", "Z"], truncated: false, start: [65, 150], moves: [{ k: "a" as const, l: 2, p: [20, 1, 19, 0] }] };
    expect(inDiameters(lathe).moves[0]?.p).toEqual([40, 1, 38, 0]);
    expect(expand(inDiameters(lathe)).moves.map((move) => move.p)).toEqual([[130, 150], [40, 1], [38, 0]]);
    const mill = { axes: ["X", "Y", "Z"], truncated: false, moves: [{ k: "f" as const, l: 1, p: [1, 2, 3] }] };
    expect(inDiameters(mill)).toBe(mill);
  });
  it("is fitted to what cuts, not to the reference point", () => {
    const plot = { axes: ["X", "Z"], truncated: false, moves: [{ k: "r" as const, l: 1, p: [400, 300] }, { k: "r" as const, l: 2, p: [50, 2] }, { k: "f" as const, l: 3, p: [50, -60] }] };
    expect(bounds(plot, [1, 0], true)).toEqual({ min: [-60, 50], max: [2, 50] });
  });
  it("of nothing has no bounds", () => expect(bounds({ axes: ["X", "Z"], truncated: false, moves: [] }, [1, 0], true)).toBeNull());
  it("knows a lathe by its axes", () => expect([isLathe(["X", "Z"]), isLathe(["X", "Y", "Z"]), isLathe([])]).toEqual([true, false, false]));
});

describe("the trail", () => {
  it("starts anew with a new cycle and keeps its length bounded", () => {
    const trail = new Trail();
    trail.add([[1, 1], [1, 1], [2, 2]], 5);
    expect(trail.points.length).toBe(2);
    trail.add([[0, 0]], 0.1);
    expect(trail.points).toEqual([[0, 0]]);
    for (let i = 0; i < 50_000; i += 1) trail.add([[i, i]], 1 + i);
    expect(trail.points.length).toBeLessThanOrEqual(20_000);
  });
});

it("steps are 1, 2 or 5", () => expect([niceStep(100, 10), niceStep(130, 10), niceStep(0.4, 10), niceStep(430, 10)]).toEqual([10, 20, 0.05, 50]));
