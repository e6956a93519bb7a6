import { useContext, useEffect, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import { patch } from "../api/client";
import { current, setLanguage, type Language } from "../i18n";
import { useMonotonic, useShop } from "../live/hooks";
import { link } from "../live/socket";
import { Icon, Logo, type IconName } from "../ui/icons";
import { Button } from "../ui/parts";
import { address } from "./router";
import { SessionContext, useMay, useSession } from "./session";
import { chosenTheme, setTheme } from "./theme";

export function LanguageSwitch() {
  const { t } = useTranslation();
  const signedIn = useContext(SessionContext) !== null;
  const chosen = current();
  const choose = (language: Language) => {
    setLanguage(language);
    // Kept with the person too, for the next computer; this page does not wait for it.
    if (signedIn) patch("/session", { language }).catch(() => undefined);
  };
  return (
    <div className="language" role="group" aria-label={t("nav.language")}>
      <button type="button" lang="zh-CN" aria-pressed={chosen === "zh"} onClick={() => choose("zh")}>中文</button>
      <button type="button" lang="en" aria-pressed={chosen === "en"} onClick={() => choose("en")}>English</button>
    </div>
  );
}

export function ThemeSwitch() {
  const { t } = useTranslation();
  const [theme, change] = useState(chosenTheme());
  const other = theme === "dark" ? "light" : "dark";
  return <Button kind="quiet" icon={theme === "dark" ? "sun" : "moon"} aria-label={t(`nav.theme_${other}`)} title={t(`nav.theme_${other}`)}
    onClick={() => { setTheme(other); change(other); }} />;
}

export function Header({ page, onSignOut }: { page: string; onSignOut: () => void }) {
  const { t } = useTranslation();
  const administrator = useMay("administrator");
  const alarms = useShop((shop) => {
    let count = 0;
    for (const live of shop.machines.values()) count += live.alarms?.length ?? 0;
    return count;
  });
  const items: { page: string; icon: IconName; count?: number }[] = [
    { page: "floor", icon: "floor" }, { page: "programs", icon: "programs" }, { page: "data", icon: "data" }, { page: "dnc", icon: "link" }, { page: "alarms", icon: "alarms", count: alarms },
    { page: "times", icon: "times" },
    ...(administrator ? [{ page: "users", icon: "users" } as const] : []),
  ];
  const here = page === "machines" ? "floor" : page;
  return (
    <header className="header">
      <a className="brand" href={address(["floor"])}><Logo /><span>Headstock</span></a>
      <nav aria-label={t("nav.main")}>
        {items.map((item) => (
          <a key={item.page} href={address([item.page])} aria-current={here === item.page ? "page" : undefined} data-nav={item.page}>
            <Icon name={item.icon} /><span>{t(`nav.${item.page}`)}</span>{item.count ? <span className="count alert">{item.count}</span> : null}
          </a>
        ))}
      </nav>
      <div className="header-end">
        <LinkDot /><ThemeSwitch /><LanguageSwitch /><PersonMenu onSignOut={onSignOut} />
      </div>
    </header>
  );
}

function LinkDot() {
  const { t } = useTranslation();
  const state = useShop((shop) => shop.link);
  return <span className={`link-dot ${state}`} data-link={state} title={t(`link.${state}`)}><i />{t(`link.short_${state}`)}</span>;
}

/// Loud, because values on the page are no longer true.
export function LinkBanner() {
  const { t } = useTranslation();
  const state = useShop((shop) => shop.link);
  const since = useShop((shop) => shop.lostSince);
  const now = useMonotonic(1000);
  if (state !== "lost" || since === null) return null;
  const seconds = Math.max(0, Math.floor((now - since) / 1000));
  return (
    <div className="link-banner" role="alert">
      <Icon name="alarms" size={20} /><strong>{t("link.lost")}</strong><span>{t("link.lost_explained", { seconds })}</span>
      <Button small onClick={() => link.retryNow()}>{t("link.retry")}</Button>
    </div>
  );
}

function PersonMenu({ onSignOut }: { onSignOut: () => void }) {
  const { t } = useTranslation();
  const session = useSession();
  const [open, setOpen] = useState(false);
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!open) return undefined;
    const outside = (event: MouseEvent) => { if (!box.current?.contains(event.target as Node)) setOpen(false); };
    const escape = (event: KeyboardEvent) => { if (event.key === "Escape") setOpen(false); };
    addEventListener("mousedown", outside);
    addEventListener("keydown", escape);
    return () => { removeEventListener("mousedown", outside); removeEventListener("keydown", escape); };
  }, [open]);
  return (
    <div className="person" ref={box}>
      <button type="button" className="person-button" aria-expanded={open} aria-haspopup="menu" onClick={() => setOpen(!open)}>
        <span className="initial" aria-hidden="true">{(session.name || session.user).slice(0, 1).toUpperCase()}</span>
        <span className="person-name">{session.name || session.user}</span><Icon name="down" size={12} />
      </button>
      {open && (
        <div className="menu" role="menu">
          <div className="menu-head"><b>{session.user}</b><span>{t(`role.${session.role}`)}</span></div>
          <a role="menuitem" href={address(["account"])} onClick={() => setOpen(false)}>{t("nav.account")}</a>
          <button type="button" role="menuitem" data-action="sign-out" onClick={onSignOut}>{t("nav.sign_out")}</button>
        </div>
      )}
    </div>
  );
}
