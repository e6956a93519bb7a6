import { createContext, useContext } from "react";
import { roles, type Role, type Session } from "../api/types";

export const SessionContext = createContext<Session | null>(null);

export function useSession(): Session {
  const session = useContext(SessionContext);
  if (!session) throw new Error("no session");
  return session;
}

export const atLeast = (session: Session, role: Role) => roles.indexOf(session.role) >= roles.indexOf(role);
/// The session as it is on one machine: a role granted there counts as long as the page is about it.
export function onMachine(session: Session, machine: number): Session {
  const granted = session.machine_roles?.[String(machine)];
  return granted && roles.indexOf(granted) > roles.indexOf(session.role) ? { ...session, role: granted } : session;
}

/// What the page offers; the server decides on its own.
export const useMay = (role: Role): boolean => atLeast(useSession(), role);
