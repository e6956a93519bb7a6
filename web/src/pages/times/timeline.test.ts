import { describe, expect, it } from "vitest";
import { daysOf, targetParts } from "./timeline";

const at = (day: number, hour: number) => new Date(2026, 2, day, hour).getTime();
const iso = (day: number, hour: number) => new Date(at(day, hour)).toISOString();

describe("the timeline", () => {
  it("cuts a state at midnight and at the edges of what was asked", () => {
    const days = daysOf([{ state: "running", from: iso(1, 0), to: iso(4, 0) }], at(2, 6), at(3, 12));
    expect(days.map((day) => day.pieces.map((piece) => [piece.from, piece.to]))).toEqual([[[at(2, 6), at(3, 0)]], [[at(3, 0), at(3, 12)]]]);
    expect(days[0]!.pieces[0]!.left).toBeCloseTo(0.25);
    expect(days[1]!.pieces[0]!.width).toBeCloseTo(0.5);
  });
  it("lets an open state reach to now and leaves the future empty", () => {
    const [day] = daysOf([{ state: "idle", from: iso(2, 0), to: null }], at(2, 0), at(2, 9));
    expect(day!.pieces).toHaveLength(1);
    expect(day!.pieces[0]!.to).toBe(at(2, 9));
  });
  it("keeps a hole a hole", () => {
    const [day] = daysOf([{ state: "running", from: iso(2, 1), to: iso(2, 2) }, { state: "running", from: iso(2, 3), to: iso(2, 4) }], at(2, 0), at(2, 9));
    expect(day!.pieces).toHaveLength(2);
  });
  it("fills the whole of every day, also one of 23 or 25 hours", () => {
    for (const day of daysOf([{ state: "off", from: iso(1, 0), to: iso(31, 23) }], at(27, 0), at(31, 0)))
      expect(day.pieces.reduce((sum, piece) => sum + piece.width, 0)).toBeCloseTo(1);
  });
});

describe("the target", () => {
  it("is the planned time at the predicted time a part", () => {
    expect(targetParts({ parts: 40, parts_without_ideal: 0, ideal_s: 4_000, planned_s: 6_050 })).toBe(60);
    expect(targetParts({ parts: 40, parts_without_ideal: 20, ideal_s: 2_000, planned_s: 6_000 })).toBe(60);
  });
  it("is unknown where nobody predicted a time", () => {
    expect(targetParts({ parts: 0, parts_without_ideal: 0, ideal_s: 0, planned_s: 6_000 })).toBeNull();
    expect(targetParts({ parts: 5, parts_without_ideal: 5, ideal_s: 0, planned_s: 6_000 })).toBeNull();
  });
});
