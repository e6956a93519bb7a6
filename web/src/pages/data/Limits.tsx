// The largest change one person may make alone, by kind of value; an empty field of a machine means the shop's limit.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { get, patch } from "../../api/client";
import { useLoad } from "../../live/hooks";
import { Button, Dialog, ErrorNote, Field, useAction } from "../../ui/parts";

const kinds = ["wear", "geometry", "radius", "work", "tool_life", "variable", "parameter"] as const;
type Limits = Record<(typeof kinds)[number], number | null>;

export function LimitsDialog({ machine, onClose }: { machine: number | null; onClose: () => void }) {
  const { t } = useTranslation();
  const path = machine === null ? "/value-limits" : `/machines/${machine}/value-limits`;
  const { value, error } = useLoad((signal) => get<Limits>(path, signal), [path]);
  const [typed, setTyped] = useState<Partial<Record<string, string>>>({});
  const { busy, run } = useAction();
  const save = () => run(async () => {
    const changes: Record<string, number | null> = {};
    for (const [kind, text] of Object.entries(typed)) changes[kind] = text === undefined || text.trim() === "" ? null : Number(text.replace(",", "."));
    if (Object.keys(changes).length > 0) await patch(path, changes);
    onClose();
  });
  return (
    <Dialog title={t("data.limits")} name="limits" onClose={onClose} actions={<><Button onClick={onClose}>{t("common.cancel")}</Button><Button kind="primary" type="submit" form="limits-form" busy={busy}>{t("common.save")}</Button></>}>
      <p>{t(machine === null ? "data.limits_shop" : "data.limits_machine")}</p>
      <ErrorNote error={error} />
      <form id="limits-form" className="limits" onSubmit={(event) => { event.preventDefault(); save(); }}>
        {kinds.map((kind) => <Field key={kind} label={t(`data.limit_${kind}`)}><input inputMode="decimal" name={kind} pattern="[0-9]*[.,]?[0-9]*" placeholder={t("data.no_limit")} value={typed[kind] ?? (value?.[kind] ?? "").toString()} onChange={(event) => setTyped({ ...typed, [kind]: event.target.value })} /></Field>)}
      </form>
    </Dialog>
  );
}
