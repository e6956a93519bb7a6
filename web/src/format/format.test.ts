import { describe, expect, it } from "vitest";
import { bytes, fixed, percent, position } from "./number";
import { ageOf, duration, moment } from "./time";

describe("numbers", () => {
  it.each([[12.3456, "12.346"], [-5, "−5.000"], [-0.0004, "0.000"], [null, "—"], [undefined, "—"], [NaN, "—"]])("position %s is %s", (value, text) => {
    expect(position(value)).toBe(text);
  });
  it("keeps the digits asked for", () => expect(fixed(180, 1)).toBe("180.0"));
  it.each([[0.9997, 0, "99 %"], [0.99995, 1, "99.9 %"], [1, 0, "100 %"], [0.5, 1, "50.0 %"], [-1, 0, "—"], [null, 0, "—"]])("part %s is %s", (part, digits, text) => {
    expect(percent(part, digits)).toBe(text);
  });
  it.each([[0, "0 B"], [1023, "1023 B"], [1536, "1.50 KB"], [104857600, "100 MB"]])("%s bytes are %s", (count, text) => expect(bytes(count)).toBe(text));
});

describe("times", () => {
  it.each([[0, "0:00"], [75.9, "1:15"], [3725, "1:02:05"], [-1, "—"], [null, "—"]])("%s s are %s", (s, text) => expect(duration(s)).toBe(text));
  it.each([[140, "ms", 100], [5999, "s", 5], [61_000, "min", 1], [7_200_000, "h", 2], [172_800_000, "d", 2]])("%s ms are %s %s", (ms, unit, value) => {
    expect(ageOf(ms)).toEqual({ unit, value });
  });
  it("of day are local and sortable", () => expect(moment("2026-01-31T14:05:09")).toBe("2026-01-31 14:05:09"));
  it("that cannot be read are unknown", () => expect(moment("yesterday")).toBe("—"));
});
