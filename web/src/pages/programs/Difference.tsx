// Two revisions side by side; every change says what kind it is, because a comment and a tool path are not the same.
import { useMemo, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import { get, query, settled } from "../../api/client";
import type { Diff, DiffClass, DiffRow, Revision } from "../../api/types";
import { Code } from "../../gcode/Code";
import { useLoad } from "../../live/hooks";
import { address, swap, useRoute } from "../../shell/router";
import { Button, ErrorNote, Note, Panel } from "../../ui/parts";

export const classTone: Record<DiffClass, string> = { comment: "", feed_speed: "info", offset: "warn", geometry: "bad", structure: "bad" };

export function DiffTab({ program, revisions, chosen }: { program: number; revisions: Revision[]; chosen: number }) {
  const { t } = useTranslation();
  const route = useRoute();
  const to = Number(route.search.get("to")) || chosen;
  const from = Number(route.search.get("from")) || revisions.find((one) => one.number < to)?.number || 0;
  const { value: diff, error } = useLoad<Diff | null>(async (signal) => (from > 0 && from !== to ? settled(await get<Diff>(`/programs/${program}/diff${query({ from, to, context: 4 })}`, signal), signal) : null), [program, from, to]);
  const body = useRef<HTMLDivElement>(null);
  const [at, setAt] = useState(-1);
  const changes = useMemo(() => (diff?.rows ?? []).flatMap((row, i) => (isChange(row) && !isChange(diff?.rows[i - 1]) ? [i] : [])), [diff]);
  const choose = (change: Record<string, number>) => swap(address(["programs", program], { tab: "diff", rev: route.search.get("rev"), from, to, ...change }));
  const jump = (by: number) => {
    const next = Math.min(changes.length - 1, Math.max(0, at + by));
    setAt(next);
    body.current?.querySelector(`[data-row="${changes[next]}"]`)?.scrollIntoView({ block: "center" });
  };
  if (revisions.length < 2) return <div className="empty">{t("programs.diff_one")}</div>;
  const count = diff ? diff.changed + diff.added + diff.removed : 0;
  const choice = (name: "from" | "to", value: number) => (
    <label className="row"><span className="dim">{t(`programs.compare_${name}`)}</span><select name={name} value={value} onChange={(event) => choose({ [name]: Number(event.target.value) })}>
      {revisions.map((one) => <option key={one.number} value={one.number}>{t("programs.revision_n", { number: one.number })} · {one.by}</option>)}</select></label>);
  return (
    <Panel className="diff-tab" name="diff">
      <div className="records-bar wrap">{choice("from", from)}{choice("to", to)}
        {diff && <span className="num">{t("programs.diff_changes", { count: Number.isFinite(count) ? count : diff.rows.filter(isChange).length })}</span>}
        {diff?.classes.map((one) => <span key={one} className={`chip ${classTone[one] ?? ""}`} data-class={one}>{t(`class.${one}`)}</span>)}
        <span className="end"><Button small disabled={changes.length === 0} onClick={() => jump(-1)}>{t("programs.diff_previous")}</Button><Button small disabled={changes.length === 0} onClick={() => jump(1)}>{t("programs.diff_next")}</Button></span></div>
      <ErrorNote error={error} />
      {diff && diff.classes.length === 0 && <Note kind="good">{t("programs.diff_same")}</Note>}
      {diff && diff.classes.length > 0 && (
        <div className="diff mono" ref={body} tabIndex={0} role="region" aria-label={t("programs.tab_diff")}>
          <table><tbody>{diff.rows.slice(0, 5000).map((row, i) => row.kind === "skipped"
            ? <tr key={i} className="skipped"><td colSpan={5}>{t("programs.diff_skipped", { count: row.skipped ?? 0 })}</td></tr>
            : <tr key={i} className={`${row.kind}${changes[at] === i ? " at" : ""}`} data-row={i}>
              <td className="row-number">{row.left_line}</td><td className="left">{row.left !== null && <Code text={row.left} />}</td>
              <td className="row-number">{row.right_line}</td><td className="right-side">{row.right !== null && <Code text={row.right} />}</td>
              <td className="class">{row.class && <span className={`chip ${classTone[row.class]}`}>{t(`class.${row.class}`)}</span>}</td></tr>)}</tbody></table>
        </div>)}
    </Panel>);
}

const isChange = (row: DiffRow | undefined) => row !== undefined && row.kind !== "same" && row.kind !== "skipped";
