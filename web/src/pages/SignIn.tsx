import { useEffect, useState, type FormEvent } from "react";
import { useTranslation } from "react-i18next";
import { get, post } from "../api/client";
import type { Session } from "../api/types";
import { LanguageSwitch, ThemeSwitch } from "../shell/Header";
import { Logo } from "../ui/icons";
import { Button, ErrorNote, Field } from "../ui/parts";

export function SignIn({ onSignedIn }: { onSignedIn: (session: Session) => void }) {
  const { t } = useTranslation();
  const [error, setError] = useState<unknown>(null);
  const [busy, setBusy] = useState(false);
  // Where people can sign in elsewhere; without an answer there is no button.
  const [provider, setProvider] = useState<string | null>(null);
  useEffect(() => {
    get<{ enabled: boolean; label: string }>("/sign-in-provider").then((found) => setProvider(found.enabled ? found.label : null), () => undefined);
  }, []);
  const submit = (event: FormEvent<HTMLFormElement>) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget);
    setBusy(true);
    setError(null);
    post<Session>("/session", { user: form.get("user"), password: form.get("password") })
      .then(onSignedIn, (problem: unknown) => { setError(problem); setBusy(false); });
  };
  return (
    <div className="sign-in">
      <div className="sign-in-corner"><ThemeSwitch /><LanguageSwitch /></div>
      <form onSubmit={submit} className="sign-in-card">
        <div className="sign-in-brand"><Logo size={40} /><div><h1>Headstock</h1><p>{t("signin.tagline")}</p></div></div>
        <Field label={t("signin.user")}><input name="user" autoComplete="username" autoFocus required spellCheck={false} autoCapitalize="none" /></Field>
        <Field label={t("signin.password")}><input name="password" type="password" autoComplete="current-password" required /></Field>
        <ErrorNote error={error} />
        <Button kind="primary" type="submit" busy={busy}>{t("signin.submit")}</Button>
        {provider !== null && <a className="button plain" data-provider href="/api/v1/session/provider">{provider || t("signin.provider")}</a>}
      </form>
    </div>
  );
}
