// Addresses behind "#": they work from any server, and from a bookmark on a wall screen.
import { useSyncExternalStore } from "react";

export interface Route { parts: string[]; search: URLSearchParams }

let text = "";
let parsed: Route = { parts: [], search: new URLSearchParams() };

function currentRoute(): Route {
  if (location.hash !== text) {
    text = location.hash;
    const [path = "", search = ""] = text.replace(/^#\/?/, "").split("?");
    parsed = { parts: path.split("/").filter(Boolean).map(decodeURIComponent), search: new URLSearchParams(search) };
  }
  return parsed;
}

export function useRoute(): Route {
  return useSyncExternalStore((listener) => {
    addEventListener("hashchange", listener);
    return () => removeEventListener("hashchange", listener);
  }, currentRoute);
}

export function address(parts: (string | number)[], search?: Record<string, string | number | null | undefined>): string {
  const query = new URLSearchParams();
  for (const [key, value] of Object.entries(search ?? {})) {
    if (value !== null && value !== undefined && value !== "") query.set(key, String(value));
  }
  const tail = query.toString();
  return `#/${parts.map((part) => encodeURIComponent(part)).join("/")}${tail ? `?${tail}` : ""}`;
}

export const go = (to: string): void => { location.hash = to; };
/// Changes the address without a step in the history (filters, tabs).
export function swap(to: string): void {
  history.replaceState(null, "", to);
  dispatchEvent(new HashChangeEvent("hashchange"));
}
