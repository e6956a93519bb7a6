import { useState, type FormEvent } from "react";
import { useTranslation } from "react-i18next";
import { ApiError, post } from "../api/client";
import type { Session } from "../api/types";
import { go } from "../shell/router";
import { useSession } from "../shell/session";
import { LanguageSwitch, ThemeSwitch } from "../shell/Header";
import { Button, ErrorNote, Field, Note, Panel, toast } from "../ui/parts";

export function Account({ forced, onChanged }: { forced?: boolean; onChanged: (changed: Partial<Session>) => void }) {
  const { t } = useTranslation();
  const session = useSession();
  const [error, setError] = useState<unknown>(null);
  const [mismatch, setMismatch] = useState(false);
  const [busy, setBusy] = useState(false);
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const form = event.currentTarget;
    const data = new FormData(form);
    setError(null);
    const different = data.get("new") !== data.get("again");
    setMismatch(different);
    if (different) return;
    setBusy(true);
    post("/session/password", { old: data.get("old"), new: data.get("new") }).then(() => {
      form.reset();
      toast("good", t("account.changed"));
      onChanged({ must_change_password: false });
      if (forced) go("#/floor");
    }, (problem: unknown) => setError(problem instanceof ApiError && problem.status === 401 && !problem.text
      ? new ApiError(401, "wrong_password", null, null, null) : problem)).finally(() => setBusy(false));
  };
  return (
    <div className="page narrow" data-page="account">
      <h1>{t("nav.account")}</h1>
      {forced && <Note kind="warn">{t("account.must_change")}</Note>}
      <Panel title={t("account.person")}>
        <dl className="facts">
          <dt>{t("signin.user")}</dt><dd>{session.user}</dd>
          <dt>{t("users.name")}</dt><dd>{session.name || "—"}</dd>
          <dt>{t("users.role")}</dt><dd>{t(`role.${session.role}`)}</dd>
          <dt>{t("nav.language")}</dt><dd><LanguageSwitch /></dd>
          <dt>{t("account.theme")}</dt><dd><ThemeSwitch /></dd>
        </dl>
      </Panel>
      <Panel title={t("account.password")}>
        <form onSubmit={submit} className="form">
          <Field label={t("account.old")}><input name="old" type="password" autoComplete="current-password" required /></Field>
          <Field label={t("account.new")} hint={t("account.rule")}><input name="new" type="password" autoComplete="new-password" minLength={8} required /></Field>
          <Field label={t("account.again")}><input name="again" type="password" autoComplete="new-password" minLength={8} required /></Field>
          {mismatch && <Note kind="error">{t("account.mismatch")}</Note>}
          <ErrorNote error={error} />
          <div><Button kind="primary" type="submit" busy={busy}>{t("account.change")}</Button></div>
        </form>
      </Panel>
    </div>
  );
}
