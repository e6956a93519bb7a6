// The manual's parameter table with what the machine has: search by number, name or meaning, edit the value.
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { current } from "../../i18n";
import { Button } from "../../ui/parts";
import { parseCell, shown, type Edits } from "./grid";
import type { Parameter } from "./types";

const atOnce = 150;

export function Parameters({ parameters, edits, text, onlySet, locked, onEdit }: {
  parameters: Parameter[]; edits: Edits; text: string; onlySet: boolean; locked: boolean; onEdit: (what: string, after: number | null) => void;
}) {
  const { t } = useTranslation();
  const [most, setMost] = useState(atOnce);
  const found = useMemo(() => {
    const wanted = text.trim().toLowerCase();
    return parameters.filter((one) => {
      if (onlySet && one.value === null && !one.axes && ![...edits.keys()].some((what) => what.startsWith(`parameter/${one.number}`))) return false;
      return wanted === "" || one.number.toLowerCase().startsWith(wanted) || `${one.symbol} ${one.name_zh} ${one.meaning}`.toLowerCase().includes(wanted);
    });
  }, [parameters, text, onlySet, edits]);
  const chinese = current() === "zh";
  return (
    <div className="table-box">
      <table className="table parameters"><thead><tr><th>{t("data.parameter")}</th><th>{t("data.meaning")}</th><th>{t("data.unit_range")}</th><th>{t("data.default")}</th><th>{t("data.effective")}</th><th className="right">{t("data.value")}</th></tr></thead>
        <tbody>{found.slice(0, most).map((one) => (
          <tr key={one.number} data-parameter={one.number}>
            <th scope="row" className="mono">{one.number}{one.symbol && <small>{one.symbol}</small>}</th>
            <td className="meaning">{chinese && one.name_zh ? <><b>{one.name_zh}</b><small>{one.meaning}</small></> : one.meaning || one.name_zh}</td>
            <td>{[one.unit === "bit" ? "" : one.unit, one.range].filter(Boolean).join(" · ")}</td><td className="num">{one.default}</td><td className="effective">{one.effective}</td>
            <td className="right">{one.axes
              ? Object.entries(one.axes).map(([axis, value]) => <ParameterCell key={axis} what={`parameter/${one.number}/${axis}`} label={axis} value={value} edits={edits} locked={locked} onEdit={onEdit} />)
              : <ParameterCell what={`parameter/${one.number}`} value={one.value} edits={edits} locked={locked} onEdit={onEdit} />}</td>
          </tr>))}</tbody></table>
      {found.length > most && <div className="empty small"><Button onClick={() => setMost(most + 300)}>{t("data.show_more", { count: found.length - most })}</Button></div>}
      {found.length === 0 && <div className="empty small">{t("data.nothing_found")}</div>}
    </div>
  );
}

function ParameterCell({ what, label, value, edits, locked, onEdit }: {
  what: string; label?: string; value: number | null; edits: Edits; locked: boolean; onEdit: (what: string, after: number | null) => void;
}) {
  const edit = edits.get(what);
  const now = edit ? edit.after : value;
  const [typed, setTyped] = useState<string | null>(null);
  const wrong = typed !== null && parseCell(typed, value, what) === undefined;
  const done = (keep: boolean) => {
    const after = keep && typed !== null ? parseCell(typed, value, what) : undefined;
    if (after !== undefined) onEdit(what, after);
    setTyped(null);
  };
  return (
    <label className={`parameter-cell${edit ? " edited" : ""}`}>{label && <span>{label}</span>}
      <input className="num right" aria-label={what} inputMode="decimal" disabled={locked} aria-invalid={wrong} value={typed ?? shown(now)} placeholder="–"
        onChange={(event) => setTyped(event.target.value)} onBlur={() => { if (typed !== null) done(!wrong); }}
        onKeyDown={(event) => { if (event.key === "Enter" && !wrong) done(true); if (event.key === "Escape") done(false); }} /></label>
  );
}
