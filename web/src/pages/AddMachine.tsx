// A new machine: its name and controller, then the one-time token its agent enrols with.
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { list, post } from "../api/client";
import type { Machine, Profile } from "../api/types";
import { inLanguage } from "../i18n";
import { useLoad } from "../live/hooks";
import { Button, Dialog, Field, Note, useAction } from "../ui/parts";

export const profileId = (profile: Profile | string) => (typeof profile === "string" ? profile : profile.profile ?? profile.id ?? "");

export function AddMachine({ onClose }: { onClose: () => void }) {
  const { t } = useTranslation();
  const { value: profiles } = useLoad((signal) => list<Profile>("/profiles", signal), []);
  const [name, setName] = useState("");
  const [profile, setProfile] = useState("");
  const [made, setMade] = useState<Machine | null>(null);
  const { busy, run } = useAction();
  const chosen = profile || (profiles?.[0] ? profileId(profiles[0]) : "");
  if (made) return <TokenDialog name={made.name} token={made.enrolment_token ?? ""} onClose={onClose} />;
  return (
    <Dialog title={t("floor.add")} name="add-machine" onClose={onClose} actions={<>
      <Button onClick={onClose}>{t("common.cancel")}</Button>
      <Button kind="primary" busy={busy} disabled={name.trim() === ""}
        onClick={() => run(async () => setMade(await post<Machine>("/machines", { name: name.trim(), profile: chosen })))}>{t("common.create")}</Button>
    </>}>
      <Field label={t("machine.name")}><input value={name} onChange={(event) => setName(event.target.value)} autoFocus maxLength={60} /></Field>
      <Field label={t("machine.profile")}>
        <select value={chosen} onChange={(event) => setProfile(event.target.value)}>
          {(profiles ?? []).map((one) => {
            const id = profileId(one);
            const shown = typeof one === "string" ? "" : inLanguage(one.name);
            return <option key={id} value={id}>{shown && shown !== id ? `${shown} (${id})` : id}</option>;
          })}
        </select>
      </Field>
    </Dialog>
  );
}

export function TokenDialog({ name, token, onClose }: { name: string; token: string; onClose: () => void }) {
  const { t } = useTranslation();
  const [copied, setCopied] = useState(false);
  return (
    <Dialog title={t("enrol.title", { name })} name="token" onClose={onClose} actions={<Button kind="primary" onClick={onClose}>{t("common.done")}</Button>}>
      <p>{t("enrol.explained")}</p>
      <pre className="token mono" data-field="token">{token}</pre>
      <Button small onClick={() => { void navigator.clipboard?.writeText(token).then(() => setCopied(true)); }}>{t(copied ? "common.copied" : "common.copy")}</Button>
      <Note>{t("enrol.once")}</Note>
    </Dialog>
  );
}
