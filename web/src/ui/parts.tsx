// The few building blocks every page is made of.
import { useEffect, useRef, useState, useSyncExternalStore, type ReactNode, type ButtonHTMLAttributes } from "react";
import { useTranslation } from "react-i18next";
import type { MachineState } from "../api/types";
import { ageOf } from "../format/time";
import { percent } from "../format/number";
import { errorText } from "../i18n";
import { Icon, StateIcon, type IconName } from "./icons";

export function StateBadge({ state, large }: { state: MachineState; large?: boolean }) {
  const { t } = useTranslation();
  return (
    <span className={`state-badge state-${state}${large ? " large" : ""}`} data-state={state}>
      <StateIcon state={state} size={large ? 18 : 14} />{t(`state.${state}`)}
    </span>
  );
}

export function AgeText({ ms, prefix }: { ms: number | null; prefix?: boolean }) {
  const { t } = useTranslation();
  if (ms === null) return <span className="age never">{t("age.never")}</span>;
  const age = ageOf(ms);
  const fresh = ms < 2_000;
  const text = fresh ? t("age.now") : t(`age.${age.unit}`, { value: age.value });
  return <span className={`age ${fresh ? "fresh" : ms > 6_000 ? "old" : ""}`} title={t("age.title")}>{prefix && !fresh ? t("age.prefix", { age: text }) : text}</span>;
}

export function Progress({ part, label, state }: { part: number | null | undefined; label?: string; state?: string }) {
  const known = typeof part === "number" && part >= 0;
  return (
    <div className={`progress ${state ?? ""} ${known ? "" : "unknown"}`} role="progressbar" aria-label={label}
      aria-valuemin={0} aria-valuemax={100} {...(known ? { "aria-valuenow": Math.floor(part * 100), "aria-valuetext": percent(part) } : {})}>
      <div className="progress-fill" style={{ transform: `scaleX(${known ? Math.min(1, part) : 0})` }} />
    </div>
  );
}

interface ButtonProps extends ButtonHTMLAttributes<HTMLButtonElement> {
  icon?: IconName; kind?: "primary" | "danger" | "plain" | "go" | "hold" | "quiet"; small?: boolean; busy?: boolean;
}
export function Button({ icon, kind = "plain", small, busy, children, className, disabled, ...rest }: ButtonProps) {
  return (
    <button type="button" {...rest} disabled={disabled || busy}
      className={`button ${kind}${small ? " small" : ""}${children === undefined ? " bare" : ""} ${className ?? ""}`}>
      {icon && <Icon name={icon} />}{children}
    </button>
  );
}

/// A modal question. Escape and the backdrop mean no; the focus starts on the safe answer.
export function Dialog({ title, children, onClose, actions, wide, name }: {
  title: string; children: ReactNode; onClose: () => void; actions: ReactNode; wide?: boolean; name?: string;
}) {
  const { t } = useTranslation();
  const box = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const dialog = box.current;
    if (dialog && !dialog.open) dialog.showModal();
    return () => dialog?.close();
  }, []);
  return (
    <dialog ref={box} className={`dialog${wide ? " wide" : ""}`} data-dialog={name} aria-label={title}
      onCancel={(event) => { event.preventDefault(); onClose(); }}
      onMouseDown={(event) => { if (event.target === box.current) onClose(); }}>
      <div className="dialog-body">
        <header><h2>{title}</h2><Button kind="quiet" icon="close" aria-label={t("common.close")} onClick={onClose} /></header>
        <div className="dialog-content">{children}</div>
        <footer>{actions}</footer>
      </div>
    </dialog>
  );
}

export function ErrorNote({ error }: { error: unknown }) {
  if (!error) return null;
  return <div className="note error" role="alert"><StateIcon state="alarm" /><span>{errorText(error)}</span></div>;
}

/// The same list as a table for a spreadsheet; all of it, not only what the page shows.
export function CsvLink({ path }: { path: string }) {
  const { t } = useTranslation();
  return <a className="button plain csv" href={`/api/v1${path}${path.includes("?") ? "&" : "?"}format=csv`} download title={t("common.csv_title")}><Icon name="download" />CSV</a>;
}

export function Note({ kind = "info", children }: { kind?: "info" | "good" | "warn" | "error"; children: ReactNode }) {
  return <div className={`note ${kind}`} role={kind === "error" ? "alert" : "status"}><span>{children}</span></div>;
}

export function Field({ label, children, hint }: { label: string; children: ReactNode; hint?: string }) {
  return <label className="field"><span className="field-label">{label}</span>{children}{hint && <small>{hint}</small>}</label>;
}

export function Panel({ title, extra, children, className, name }: {
  title?: ReactNode; extra?: ReactNode; children: ReactNode; className?: string; name?: string;
}) {
  return (
    <section className={`panel ${className ?? ""}`} data-panel={name}>
      {(title || extra) && <header className="panel-head"><h2>{title}</h2>{extra && <div className="panel-extra">{extra}</div>}</header>}
      {children}
    </section>
  );
}

export function Tabs<T extends string>({ value, options, onChange, label }: {
  value: T; options: { value: T; text: ReactNode; count?: number }[]; onChange: (value: T) => void; label: string;
}) {
  const step = (by: number) => {
    const at = options.findIndex((option) => option.value === value);
    const next = options[(at + by + options.length) % options.length];
    if (next) onChange(next.value);
  };
  return (
    <div className="tabs" role="tablist" aria-label={label}
      onKeyDown={(event) => { if (event.key === "ArrowRight") step(1); if (event.key === "ArrowLeft") step(-1); }}>
      {options.map((option) => (
        <button key={option.value} type="button" role="tab" aria-selected={option.value === value} data-tab={option.value}
          tabIndex={option.value === value ? 0 : -1} onClick={() => onChange(option.value)}>
          {option.text}{option.count !== undefined && <span className="count">{option.count}</span>}
        </button>
      ))}
    </div>
  );
}

// ---- short messages after an action, read aloud by screen readers
interface Toast { id: number; kind: "good" | "error"; text: string }
let toasts: Toast[] = [];
let nextToast = 1;
const toastListeners = new Set<() => void>();
const tellToasts = () => { for (const listener of toastListeners) listener(); };

export function toast(kind: Toast["kind"], text: string): void {
  const made = { id: nextToast++, kind, text };
  toasts = [...toasts.slice(-3), made];
  tellToasts();
  // A refusal stays until it has surely been read.
  setTimeout(() => dismiss(made.id), kind === "error" ? 12_000 : 5_000);
}
function dismiss(id: number): void {
  toasts = toasts.filter((one) => one.id !== id);
  tellToasts();
}

export function Toasts() {
  const { t } = useTranslation();
  const shown = useSyncExternalStore((listener) => { toastListeners.add(listener); return () => toastListeners.delete(listener); }, () => toasts);
  return (
    <div className="toasts" aria-live="assertive">
      {shown.map((one) => (
        <div key={one.id} className={`toast ${one.kind}`} data-toast={one.kind}>
          <span>{one.text}</span><Button kind="quiet" small icon="close" aria-label={t("common.close")} onClick={() => dismiss(one.id)} />
        </div>
      ))}
    </div>
  );
}

/// Runs an action, shows its failure, tells whether it is still running.
export function useAction(): { busy: boolean; run: (action: () => Promise<void>) => void } {
  const [busy, setBusy] = useState(false);
  const run = (action: () => Promise<void>) => {
    setBusy(true);
    action().catch((error: unknown) => toast("error", errorText(error))).finally(() => setBusy(false));
  };
  return { busy, run };
}
