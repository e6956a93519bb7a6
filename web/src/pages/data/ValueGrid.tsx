// A page of values to be read and edited with the keyboard: arrows move, typing or Enter edits, Enter goes down, Tab to the
// right, Escape leaves, Delete takes an edit back; a paste is shown before anything is taken over.
import { memo, useEffect, useMemo, useRef, useState, type KeyboardEvent } from "react";
import { useTranslation } from "react-i18next";
import { toast } from "../../ui/parts";
import { conflicts, parseCell, shown, valueOf, type Edits, type Row, type Sheet } from "./grid";
import type { MachineValues } from "./types";

interface Place { row: number; column: number }

export function ValueGrid({ sheet, rows, values, edits, locked, onEdit, onPaste }: {
  sheet: Sheet; rows: Row[]; values: MachineValues["values"]; edits: Edits; locked: boolean;
  onEdit: (what: string, after: number | null) => void; onPaste: (text: string, row: number, column: number) => void;
}) {
  const { t } = useTranslation();
  const [at, setAt] = useState<Place>({ row: 0, column: 0 });
  const [typing, setTyping] = useState<string | null>(null);
  const box = useRef<HTMLDivElement>(null);
  const place = { row: Math.min(at.row, Math.max(0, rows.length - 1)), column: Math.min(at.column, sheet.columns.length - 1) };

  useEffect(() => { box.current?.querySelector("[aria-selected=true]")?.scrollIntoView({ block: "nearest", inline: "nearest" }); }, [place.row, place.column]);

  const move = (row: number, column: number) => {
    setAt({ row: Math.max(0, Math.min(rows.length - 1, place.row + row)), column: Math.max(0, Math.min(sheet.columns.length - 1, place.column + column)) });
  };
  const leave = () => { setTyping(null); box.current?.focus(); };
  /// @return false when what was typed is no number: it stays to be corrected.
  const commit = (text: string): boolean => {
    const what = rows[place.row]?.cells[place.column];
    if (!what) return true;
    const after = parseCell(text, valueOf(values, what), what);
    if (after === undefined) { toast("error", t("data.no_number", { text })); return false; }
    onEdit(what, after);
    leave();
    return true;
  };
  const onKey = (event: KeyboardEvent) => {
    if (typing !== null || rows.length === 0) return;
    const moves: Record<string, [number, number]> = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1], PageUp: [-15, 0], PageDown: [15, 0] };
    const step = moves[event.key];
    const what = rows[place.row]?.cells[place.column] ?? "";
    if (step) { move(...step); event.preventDefault(); return; }
    if (event.key === "Home" || event.key === "End") { setAt({ ...place, row: event.key === "Home" ? 0 : rows.length - 1 }); event.preventDefault(); return; }
    if (locked || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Enter" || event.key === "F2") { setTyping(shown(edits.has(what) ? edits.get(what)?.after ?? null : valueOf(values, what))); event.preventDefault(); return; }
    if (event.key === "Delete" || event.key === "Backspace") { onEdit(what, edits.get(what)?.before ?? valueOf(values, what)); event.preventDefault(); return; }
    if (/^[-+.,\d]$/.test(event.key)) { setTyping(event.key); event.preventDefault(); }
  };

  return (
    <div className="grid-box" ref={box} tabIndex={0} role="grid" aria-label={t("data.grid")} aria-rowcount={rows.length} onKeyDown={onKey}
      onPaste={(event) => { if (locked || typing !== null) return; event.preventDefault(); onPaste(event.clipboardData.getData("text"), place.row, place.column); }}>
      <table className="table grid">
        <thead><tr><th>{t(`data.head_${sheet.corner}`)}</th>{sheet.columns.map((column) => <th key={column.head} className={`right${column.wear ? " wear" : ""}`}>{headText(column.head, t)}</th>)}</tr></thead>
        <tbody>
          {rows.map((row, index) => (
            <GridRow key={row.label} row={row} index={index} values={values} edits={edits} selected={index === place.row ? place.column : -1} typing={index === place.row ? typing : null}
              onPick={(column, twice) => {
                setAt({ row: index, column });
                const what = row.cells[column] ?? "";
                if (twice && !locked) setTyping(shown(edits.has(what) ? edits.get(what)?.after ?? null : valueOf(values, what)));
              }}
              onType={setTyping}
              onDone={(text, key) => {
                if (key === "Escape") leave();
                else if (commit(text)) { if (key === "Enter") move(1, 0); if (key === "Tab") move(0, 1); }
              }} />))}
        </tbody>
      </table>
      {rows.length === 0 && <div className="empty small">{t("data.nothing_found")}</div>}
    </div>
  );
}

function headText(head: string, t: (key: string) => string): string {
  const [name = "", wear] = head.split(" ");
  const spoken = name.length > 1 ? t(`data.column_${name}`) : name;
  return wear ? `${spoken} ${t("data.wear")}` : spoken;
}

interface RowProps {
  row: Row; index: number; values: MachineValues["values"]; edits: Edits; selected: number; typing: string | null;
  onPick: (column: number, twice: boolean) => void; onType: (text: string) => void; onDone: (text: string, key: string) => void;
}
const GridRow = memo(function GridRow({ row, values, edits, selected, typing, onPick, onType, onDone }: RowProps) {
  return (
    <tr data-row={row.label}>
      <th scope="row" title={row.about}>{row.label}{row.about && <small>{row.about}</small>}</th>
      {row.cells.map((what, column) => {
        const edit = edits.get(what);
        const value = valueOf(values, what);
        const here = column === selected;
        const clash = edit !== undefined && conflicts(edit, values, what);
        return (
          <td key={what} data-what={what} aria-selected={here} className={`num right${edit ? " edited" : ""}${clash ? " clash" : ""}${value === 0 || value === null ? " nought" : ""}`}
            onClick={() => onPick(column, here)} onDoubleClick={() => onPick(column, true)}>
            {here && typing !== null
              ? <input autoFocus value={typing} inputMode="decimal" aria-label={what} onChange={(event) => onType(event.target.value)} onFocus={(event) => { if (typing.length > 1) event.target.select(); }}
                onBlur={() => onDone(typing, "Blur")}
                onKeyDown={(event) => { event.stopPropagation(); if (["Enter", "Tab", "Escape"].includes(event.key)) { event.preventDefault(); onDone(typing, event.key); } }} />
              : <>{edit && <s>{shown(value)}</s>}{shown(edit ? edit.after : value) || "–"}</>}
          </td>);
      })}
    </tr>
  );
}, (before, after) => before.row === after.row && before.index === after.index && before.selected === after.selected && before.typing === after.typing && before.values === after.values
  && (before.edits === after.edits || before.row.cells.every((what) => before.edits.get(what) === after.edits.get(what))) && after.selected === -1);

export const useSheet = (make: () => Sheet, keys: readonly unknown[]) => useMemo(make, keys); // eslint-disable-line react-hooks/exhaustive-deps
