import { useEffect, useState, useSyncExternalStore } from "react";
import type { Live, MachineState, Transfer } from "../api/types";
import { link } from "./socket";
import { ageMs, shownState, type Shop } from "./store";

export function useShop<T>(select: (shop: Shop) => T): T {
  return useSyncExternalStore(link.subscribe, () => select(link.state));
}

export interface Seen { live: Live | undefined; age: number | null; state: MachineState; current: boolean }

/// A machine as it may be shown now. Re-renders at least every second, so that ages grow when nothing comes.
export function useMachine(id: number): Seen {
  const live = useShop((shop) => shop.machines.get(id));
  const clock = useShop((shop) => shop.clock);
  const now = useMonotonic(1000);
  // `now` is up to a second old; a message that came since is younger than it.
  const age = ageMs(live, clock, Math.max(now, clock?.monotonicMs ?? 0));
  const state = shownState(live, age);
  return { live, age, state, current: state !== "unknown" };
}

export function useWantMachine(id: number): void {
  useEffect(() => link.want(`machine:${id}`), [id]);
}

export function useTransfers(): ReadonlyMap<number, Transfer> {
  return useShop((shop) => shop.transfers);
}

// One timer for all cards.
const tickers = new Map<number, { value: number; listeners: Set<() => void> }>();
function ticker(periodMs: number) {
  let found = tickers.get(periodMs);
  if (!found) {
    const made = { value: performance.now(), listeners: new Set<() => void>() };
    setInterval(() => {
      made.value = performance.now();
      for (const listener of made.listeners) listener();
    }, periodMs);
    tickers.set(periodMs, made);
    found = made;
  }
  return found;
}

export function useMonotonic(periodMs: number): number {
  const source = ticker(periodMs);
  return useSyncExternalStore(
    (listener) => {
      source.listeners.add(listener);
      return () => source.listeners.delete(listener);
    },
    () => source.value,
  );
}

/// Loads, and loads again when a key changes. The last good answer stays visible while a new one is on its way.
export function useLoad<T>(load: (signal: AbortSignal) => Promise<T>, keys: readonly unknown[]) {
  const [value, setValue] = useState<T | undefined>(undefined);
  const [error, setError] = useState<unknown>(null);
  const [again, setAgain] = useState(0);
  useEffect(() => {
    const abort = new AbortController();
    load(abort.signal).then(
      (loaded) => {
        if (abort.signal.aborted) return;
        setValue(loaded);
        setError(null);
      },
      (problem: unknown) => {
        if (!abort.signal.aborted) setError(problem);
      },
    );
    return () => abort.abort();
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [...keys, again]);
  return { value, error, reload: () => setAgain((n) => n + 1), setValue };
}
