// What each machine would say to this program, before it has it: findings, predicted time, path.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, post, settled } from "../../api/client";
import type { CheckResult, Machine, Revision } from "../../api/types";
import { fixed, unknownText } from "../../format/number";
import { duration } from "../../format/time";
import { errorText, inLanguage } from "../../i18n";
import { useLoad } from "../../live/hooks";
import { loadBackplot } from "../../path/plot";
import { PathView } from "../../path/PathView";
import { useMay } from "../../shell/session";
import { Button, ErrorNote, Panel } from "../../ui/parts";

type Outcome = CheckResult | "running" | { error: unknown };
const isResult = (one: Outcome | undefined): one is CheckResult => typeof one === "object" && "ok" in one;

export function CheckTab({ program, revision, onLine }: { program: number; revision: Revision; onLine: (line: number) => void }) {
  const { t } = useTranslation();
  const programmer = useMay("programmer");
  const { value: machines } = useLoad((signal) => list<Machine>("/machines", signal), []);
  const { value: known } = useLoad((signal) => list<CheckResult>(`/programs/${program}/revisions/${revision.number}/checks`, signal).catch(() => []), [program, revision.number]);
  const [outcomes, setOutcomes] = useState<ReadonlyMap<string, Outcome>>(new Map());
  const [chosen, setChosen] = useState<number | null>(null);
  const passed = known?.find((one) => one.ok)?.machine;
  const machine = machines?.find((one) => one.id === (chosen ?? passed)) ?? machines?.[0];
  const { value: plot, error: plotError } = useLoad(async (signal) => (machine ? loadBackplot(program, revision.number, machine.id, signal) : null), [program, revision.number, machine?.id]);
  const key = (id: number) => `${revision.number}:${id}`;
  const outcome = (id: number): Outcome | undefined => outcomes.get(key(id)) ?? known?.find((one) => one.machine === id);
  const check = async (id: number) => {
    const set = (value: Outcome) => setOutcomes((all) => new Map(all).set(key(id), value));
    set("running");
    try {
      set(await settled(await post<CheckResult>(`/programs/${program}/revisions/${revision.number}/check`, { machine: id })));
    } catch (error) {
      set({ error });
    }
  };
  const result = machine ? outcome(machine.id) : undefined;
  if (machines?.length === 0) return <div className="empty">{t("programs.check_no_machine")}</div>;
  return (
    <div className="check-tab">
      <Panel className="flush check-machines" name="checks">
        <div className="records-bar padded">{programmer && <Button kind="primary" icon="check" data-action="check-all" onClick={() => { void (async () => { for (const one of machines ?? []) await check(one.id); })(); }}>{t("programs.check_all")}</Button>}</div>
        <table className="table"><thead><tr><th>{t("programs.check_machine")}</th><th>{t("programs.check_findings")}</th><th className="right">{t("programs.check_time")}</th><th /></tr></thead>
          <tbody>{(machines ?? []).map((one) => {
            const found = outcome(one.id);
            return (
              <tr key={one.id} className="clickable" aria-selected={one.id === machine?.id} data-check={one.name} data-result={isResult(found) ? (found.ok ? "ok" : "bad") : "none"} onClick={() => setChosen(one.id)}>
                <td><b>{one.name}</b><small className="dim block">{one.profile}</small></td>
                <td>{found === "running" ? <span className="dim">{t("programs.check_running")}</span> : isResult(found) ? (found.ok ? <span className="chip good">{t("programs.check_ok")}</span> : <span className="chip bad">{t("programs.check_failed", { count: found.findings.length })}</span>)
                  : found ? <span className="chip bad">{errorText(found.error)}</span> : <span className="dim">{t("programs.check_none")}</span>}</td>
                <td className="num right">{isResult(found) ? duration(found.time_s) : unknownText}</td>
                <td className="row-actions">{programmer && <Button small busy={found === "running"} data-action="check" onClick={(event) => { event.stopPropagation(); setChosen(one.id); void check(one.id); }}>{t("programs.check_run")}</Button>}</td></tr>);
          })}</tbody></table>
      </Panel>
      <div className="check-side">
        {isResult(result) && (
          <Panel title={machine?.name} name="check-result">
            <dl className="facts times"><dt>{t("programs.check_time")}</dt><dd className="num">{duration(result.time_s)}</dd><dt>{t("programs.check_cutting")}</dt><dd className="num">{duration(result.cutting_s)}</dd>
              <dt>{t("programs.check_length")}</dt><dd className="num">{result.length_mm === null ? unknownText : `${fixed(result.length_mm, 1)} mm`}</dd><dt>{t("programs.check_tools")}</dt><dd className="num">{result.tools?.map((tool) => `T${tool}`).join(" ") || unknownText}</dd></dl>
            {result.findings.length > 0 && <ul className="findings">{result.findings.map((one, i) => (
              <li key={i}><button type="button" data-finding={one.code} onClick={() => onLine(one.line)}><span className="num dim">{t("programs.check_line", { line: one.line })}:{one.column}</span><b className="mono">{one.code}</b><span>{inLanguage(one.text)}</span></button></li>))}</ul>}
          </Panel>)}
        <Panel title={`${t("machine.path")}${machine ? ` · ${machine.name}` : ""}`} className="check-path" name="backplot">
          <ErrorNote error={plotError} />
          {plot && (plot.moves.length > 1 ? <PathView axes={plot.axes} plot={plot} /> : <div className="empty">{t("machine.path_empty")}</div>)}
        </Panel>
      </div>
    </div>);
}
