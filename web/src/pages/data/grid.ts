// The model of a page of values: which cells it has, what has been typed, what would be written. No React in it.
import type { MachineValues, OffsetPage, ValueItem } from "./types";

export interface Column { head: string; wear?: boolean }
export interface Row { label: string; cells: string[]; about?: string }
export interface Sheet { corner: string; columns: Column[]; rows: Row[] }
/// What was typed over a value: what the person saw, and what it shall be. null: not set.
export interface Edit { before: number | null; after: number | null }
export type Edits = ReadonlyMap<string, Edit>;

/// Columns of the tool offset page as [head, rest of the value's name].
export function toolColumns(page: OffsetPage): [string, string][] {
  const columns: [string, string][] = [];
  const add = (head: string, geometry: string, wear: string) => { columns.push([head, geometry]); if (page.wear) columns.push([`${head} wear`, wear]); };
  if (page.lathe) {
    for (const axis of page.axes) add(axis, `geometry/${axis}`, `wear/${axis}`);
    add("R", "radius", "radius_wear");
    columns.push(["tip", "tip"]);
  } else {
    add("length", "geometry/Z", "wear/Z");
    if (page.memory === "C") add("radius", "radius", "radius_wear");
  }
  return columns;
}

export function toolSheet(page: OffsetPage): Sheet {
  const columns = toolColumns(page);
  return {
    corner: "number", columns: columns.map(([head]) => ({ head, wear: head.endsWith(" wear") })),
    rows: Array.from({ length: page.numbers }, (_, i) => ({ label: String(i + 1), cells: columns.map(([, field]) => `tool/${i + 1}/${field}`) })),
  };
}

export function workSheet(page: OffsetPage): Sheet {
  const systems = ["EXT", ...(page.lathe ? ["shift"] : []), ...Array.from({ length: page.work_systems }, (_, i) => `G${54 + i}`),
    ...Array.from({ length: page.extra_systems }, (_, i) => `G54.1P${i + 1}`)];
  return { corner: "system", columns: page.axes.map((head) => ({ head })), rows: systems.map((label) => ({ label, cells: page.axes.map((axis) => `work/${label}/${axis}`) })) };
}

export function variableSheet(page: OffsetPage): Sheet {
  const numbers = [...new Set(page.variables.flatMap(([from, to]) => Array.from({ length: Math.max(0, to - from + 1) }, (_, i) => from + i)))];
  return { corner: "what", columns: [{ head: "value" }], rows: numbers.map((n) => ({ label: `#${n}`, cells: [`variable/${n}`] })) };
}

const zeroWhenAbsent = (what: string) => what.startsWith("tool/") || what.startsWith("work/");
export function valueOf(values: MachineValues["values"], what: string): number | null {
  return values[what] ?? (zeroWhenAbsent(what) ? 0 : null);
}

/// "0.02" sets, "+0.02" adds as the controller's +INPUT does, "" erases where that is possible. undefined: no number.
export function parseCell(text: string, before: number | null, what: string): number | null | undefined {
  const typed = text.trim().replace("−", "-").replace(",", ".");
  if (typed === "") return zeroWhenAbsent(what) ? 0 : null;
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(typed)) return undefined;
  const number = Number(typed);
  const made = typed.startsWith("+") ? (before ?? 0) + number : number;
  return Math.round(made * 1e9) / 1e9;
}

export const sameValue = (a: number | null, b: number | null) => (a === null || b === null ? a === b : Math.abs(a - b) <= 5e-7);

export function withEdit(edits: Edits, values: MachineValues["values"], what: string, after: number | null): Map<string, Edit> {
  const next = new Map(edits);
  const before = next.get(what)?.before ?? valueOf(values, what);
  if (sameValue(before, after)) next.delete(what);
  else next.set(what, { before, after });
  return next;
}

/// The machine's value is no longer the one that was typed over.
export const conflicts = (edit: Edit, values: MachineValues["values"], what: string) => !sameValue(edit.before, valueOf(values, what));

export function itemsOf(edits: Edits): ValueItem[] {
  return [...edits].map(([what, edit]) => ({ what, before: edit.before, after: edit.after }));
}

/// Rows whose label, values or edits hold what is searched; "5-12" and ">100" are numbers.
export function findRows(rows: Row[], text: string, values: MachineValues["values"]): Row[] {
  const wanted = text.trim().toLowerCase();
  if (wanted === "") return rows;
  const span = /^(\d+)\s*-\s*(\d+)$/.exec(wanted);
  if (span) return rows.filter((row) => { const n = Number(row.label.replace(/\D/g, "")); return n >= Number(span[1]) && n <= Number(span[2]); });
  if (wanted === "*") return rows.filter((row) => row.cells.some((what) => (valueOf(values, what) ?? 0) !== 0));
  return rows.filter((row) => row.label.toLowerCase() === wanted || row.label.toLowerCase().startsWith(wanted) || (row.about ?? "").toLowerCase().includes(wanted)
    || row.cells.some((what) => String(valueOf(values, what) ?? "").startsWith(wanted)));
}

/// What was copied in a spreadsheet, set down at a cell: with the heads of its columns, as the server reads tables.
export function pasteAt(text: string, sheet: Sheet, rows: Row[], row: number, column: number): string {
  const lines = text.replace(/\r/g, "").replace(/\n+$/, "").split("\n").map((line) => line.split("\t"));
  const width = Math.max(...lines.map((line) => line.length));
  const heads = sheet.columns.slice(column, column + width).map((one) => one.head);
  const first = sheet.corner === "what" ? "what" : sheet.corner;
  const out = [[first, ...heads].join("\t")];
  lines.forEach((cells, i) => {
    const at = rows[row + i];
    if (at) out.push([sheet.corner === "what" ? at.cells[0] ?? "" : at.label, ...cells.slice(0, heads.length)].join("\t"));
  });
  return out.join("\n");
}

export function shown(value: number | null, wear?: boolean): string {
  if (value === null) return "";
  if (value === 0 && wear) return "0";
  return String(Math.round(value * 1e6) / 1e6);
}
