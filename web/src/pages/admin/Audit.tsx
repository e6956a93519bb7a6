import { useEffect, useState } from "react";
import { useTranslation } from "react-i18next";
import { get, page, query } from "../../api/client";
import { moment } from "../../format/time";
import { useLoad } from "../../live/hooks";
import { Button, CsvLink, ErrorNote, Note, Panel, useAction } from "../../ui/parts";

interface AuditRow { id: number; at: string; user: string; address: string; action: string; subject: string; detail: Record<string, unknown> | string }
interface Verdict { whole: boolean; broken: number | null; what: string; rows: number; hash: string }

const shown = (detail: AuditRow["detail"]) =>
  typeof detail === "string" ? detail : Object.entries(detail).map(([key, value]) => `${key}: ${String(value)}`).join(" · ");

export function Audit() {
  const { t } = useTranslation();
  const [filter, setFilter] = useState({ user: "", action: "", subject: "" });
  const [asked, setAsked] = useState(filter);
  const path = (cursor?: string) => `/audit${query({ ...asked, cursor, limit: 200 })}`;
  const { value: first, error } = useLoad((signal) => page<AuditRow>(path(), signal), [asked]);
  const [more, setMore] = useState<AuditRow[]>([]);
  const [next, setNext] = useState<string | null>(null);
  useEffect(() => { setMore([]); setNext(first?.next ?? null); }, [first]);
  const [verdict, setVerdict] = useState<Verdict | null>(null);
  const { busy, run } = useAction();
  return (
    <>
      <form className="filters" onSubmit={(event) => { event.preventDefault(); setAsked(filter); }}>
        {(["user", "action", "subject"] as const).map((name) => (
          <label key={name}><span>{t(`audit.${name}`)}</span><input name={name} value={filter[name]} onChange={(event) => setFilter({ ...filter, [name]: event.target.value })} onBlur={() => setAsked(filter)} /></label>
        ))}
        <button type="submit" className="visually-hidden">{t("common.apply")}</button>
        <Button icon="check" busy={busy} onClick={() => run(async () => { setVerdict(await get<Verdict>("/audit/verification")); })}>{t("audit.verify")}</Button>
        <CsvLink path={`/audit${query(asked)}`} />
      </form>
      {verdict && <Note kind={verdict.whole ? "good" : "error"}>
        {verdict.whole ? t("audit.whole", { rows: verdict.rows, hash: verdict.hash.slice(0, 16) }) : t("audit.broken", { row: verdict.broken ?? 0, what: t(`audit.${verdict.what}`, verdict.what) })}</Note>}
      <ErrorNote error={error} />
      <Panel className="flush">
        <table className="table audit">
          <thead><tr><th>{t("audit.id")}</th><th>{t("audit.at")}</th><th>{t("audit.user")}</th><th>{t("audit.address")}</th><th>{t("audit.action")}</th><th>{t("audit.subject")}</th><th>{t("audit.detail")}</th></tr></thead>
          <tbody>{[...(first?.items ?? []), ...more].map((row) => (
            <tr key={row.id} data-audit={row.id}><td className="num">{row.id}</td><td className="num">{moment(row.at)}</td><td>{row.user}</td><td className="mono">{row.address}</td>
              <td className="mono">{row.action}</td><td className="mono">{row.subject}</td><td className="grow">{shown(row.detail)}</td></tr>
          ))}</tbody>
        </table>
      </Panel>
      {next && <Button onClick={() => { void page<AuditRow>(path(next)).then((got) => { setMore([...more, ...got.items]); setNext(got.next); }); }}>{t("common.more")}</Button>}
    </>
  );
}
