// What waits for a second person: the values before and after, and the two answers.
import { useTranslation } from "react-i18next";
import { post } from "../../api/client";
import { moment } from "../../format/time";
import { errorText } from "../../i18n";
import { useMay, useSession } from "../../shell/session";
import { Button, Panel, toast, useAction } from "../../ui/parts";
import { shown } from "./grid";
import type { ValueRequest } from "./types";

export function Requests({ requests, names, onChanged }: { requests: ValueRequest[]; names: Map<number, string>; onChanged: () => void }) {
  const { t } = useTranslation();
  const me = useSession().user;
  const setter = useMay("setter");
  const { busy, run } = useAction();
  const answer = (one: ValueRequest, what: "agree" | "withdraw") => run(async () => {
    try {
      const made = await post<ValueRequest>(`/value-requests/${one.id}/${what}`);
      toast("good", t(`data.state_${made.state}`));
    } catch (problem) { toast("error", errorText(problem)); }
    onChanged();
  });
  if (requests.length === 0) return null;
  return (
    <Panel name="value-requests" title={t("data.waiting_title", { count: requests.length })} className="waiting-requests">
      {requests.map((one) => (
        <div key={one.id} className="request" data-request={one.id}>
          <div><b>{names.get(one.machine) ?? one.machine}</b> · {t("data.asked_by", { user: one.by, at: moment(one.at) })}{one.why && <> · {one.why}</>}
            <ul>{one.values.slice(0, 8).map((item) => <li key={item.what} className={`mono${item.what === one.needs_second ? " wants" : ""}`}>{item.what}: {shown(item.before) || "–"} → {shown(item.after) || "–"}</li>)}
              {one.values.length > 8 && <li>{t("data.and_more", { count: one.values.length - 8 })}</li>}</ul></div>
          {setter && <div className="row-actions">
            <Button busy={busy} data-action="withdraw" onClick={() => answer(one, "withdraw")}>{t("data.withdraw")}</Button>
            <Button kind="primary" busy={busy} disabled={one.by === me} title={one.by === me ? t("data.not_yourself") : undefined} data-action="agree" onClick={() => answer(one, "agree")}>{t("data.agree")}</Button></div>}
        </div>))}
    </Panel>
  );
}
