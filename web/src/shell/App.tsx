import { lazy, Suspense, useEffect, useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiError, get, post, remove, whenSignedOut } from "../api/client";
import type { Session } from "../api/types";
import { chosenLanguage, setLanguage } from "../i18n";
import { link } from "../live/socket";
import { Account } from "../pages/Account";
import { AlarmHistory } from "../pages/AlarmHistory";
import { Floor } from "../pages/Floor";
import { SignIn } from "../pages/SignIn";
import { Times } from "../pages/times/Times";
import { Toasts } from "../ui/parts";
import { Header, LinkBanner } from "./Header";
import { address, go, useRoute } from "./router";
import { atLeast, onMachine, SessionContext } from "./session";

// The 3-D view and the editor are large: they come when a page needs them.
const MachinePage = lazy(() => import("../pages/machine/MachinePage").then((m) => ({ default: m.MachinePage })));
const Admin = lazy(() => import("../pages/admin/Admin").then((m) => ({ default: m.Admin })));
const Dnc = lazy(() => import("../pages/dnc/Dnc").then((m) => ({ default: m.Dnc })));
const Data = lazy(() => import("../pages/data/Data").then((m) => ({ default: m.Data })));
const Programs = lazy(() => import("../pages/programs/Programs").then((m) => ({ default: m.Programs })));

export function App() {
  const { t } = useTranslation();
  const [session, setSession] = useState<Session | null | undefined>(undefined);
  const [unreachable, setUnreachable] = useState(false);

  useEffect(() => {
    whenSignedOut(() => setSession(null));
    const ask = () => {
      get<Session>("/session").then(
        (found) => { setUnreachable(false); setSession(found); },
        (error: unknown) => {
          if (error instanceof ApiError && error.status === 401) { setUnreachable(false); setSession(null); }
          else { setUnreachable(true); timer = setTimeout(ask, 2_000); }
        });
    };
    let timer: ReturnType<typeof setTimeout> | undefined;
    // A wall screen's address carries its secret once; from then on the browser keeps it out of reach of scripts.
    const screen = /^#\/screen\/([0-9a-f]{64})$/.exec(location.hash)?.[1];
    if (screen) void post("/session/screen", { token: screen }).catch(() => undefined).then(() => { location.replace("#/floor?wall=1"); ask(); });
    else ask();
    return () => clearTimeout(timer);
  }, []);

  const signedIn = session !== null && session !== undefined;
  useEffect(() => {
    if (!signedIn) return undefined;
    link.start();
    return () => link.stop();
  }, [signedIn]);

  if (session === undefined) return <div className="waiting" role="status">{t(unreachable ? "error.unreachable" : "common.loading")}</div>;
  if (session === null) {
    return <><SignIn onSignedIn={(made) => {
      if (!chosenLanguage() && (made.language === "zh" || made.language === "en")) setLanguage(made.language);
      setSession(made);
    }} /><Toasts /></>;
  }
  const signOut = () => { void remove("/session").catch(() => undefined).then(() => { go("#/floor"); setSession(null); }); };
  return (
    <SessionContext.Provider value={session}>
      <Frame session={session} onSignOut={signOut} onChanged={(changed) => setSession({ ...session, ...changed })} />
    </SessionContext.Provider>
  );
}

function Frame({ session, onSignOut, onChanged }: {
  session: Session; onSignOut: () => void; onChanged: (changed: Partial<Session>) => void;
}) {
  const { t } = useTranslation();
  const route = useRoute();
  const [page = "floor", id] = route.parts;
  const wall = page === "floor" && route.search.get("wall") === "1";
  useEffect(() => {
    if (route.parts.length === 0) go(address(["floor"]));
  }, [route]);

  let content: JSX.Element;
  if (session.must_change_password) content = <Account forced onChanged={onChanged} />;
  else if (page === "machines" && id) content = <SessionContext.Provider value={onMachine(session, Number(id))}><MachinePage key={id} id={Number(id)} /></SessionContext.Provider>;
  else if (page === "programs") content = <Programs program={id ? Number(id) : null} />;
  else if (page === "data") content = <Data />;
  else if (page === "dnc") content = <Dnc />;
  else if (page === "alarms") content = <AlarmHistory />;
  else if (page === "times") content = <Times />;
  else if (page === "users" && atLeast(session, "administrator")) content = <Admin />;
  else if (page === "account") content = <Account onChanged={onChanged} />;
  else content = <Floor wall={wall} />;

  return (
    <div className={`frame${wall ? " wall" : ""}`}>
      <a className="skip" href="#main" onClick={(event) => { event.preventDefault(); document.getElementById("main")?.focus(); }}>{t("nav.skip")}</a>
      {!wall && <Header page={page} onSignOut={onSignOut} />}
      <LinkBanner />
      <main id="main" tabIndex={-1}>
        <Suspense fallback={<div className="waiting" role="status">{t("common.loading")}</div>}>{content}</Suspense>
      </main>
      <Toasts />
    </div>
  );
}
