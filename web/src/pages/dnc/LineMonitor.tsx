// Every byte both ways, control characters by name, handshake lines, errors. Bounded: the newest few hundred entries.
import { useEffect, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import { get } from "../../api/client";
import { clockTime } from "../../format/time";
import { reasonText } from "../../i18n";
import { Button } from "../../ui/parts";
import type { MonitorEntry, Port, Signals } from "./types";

const kept = 400;

function Lamps({ signals }: { signals: Signals | null }) {
  const { t } = useTranslation();
  if (!signals) return <span className="dim">{t("dnc.no_signals")}</span>;
  return <span className="lamps">{(["rts", "dtr", "cts", "dsr", "dcd", "ring"] as const).map((name) => <span key={name} className={`lamp ${signals[name] ? "on" : ""}`}>{name.toUpperCase()}</span>)}</span>;
}

/// Control characters stand out: a wrong cable shows in them first.
function Bytes({ text }: { text: string }) {
  return <>{text.split(/(<[^<>]{2,3}>)/).map((piece, i) => (/^<[^<>]{2,3}>$/.test(piece) ? <i key={i} className="control">{piece.slice(1, -1)}</i> : piece))}</>;
}

/// All that the server still has of the line, for whoever looks at it later.
async function keep(port: Port): Promise<void> {
  const piece = await get<{ items: MonitorEntry[] }>(`/ports/${port.id}/monitor?limit=1000`);
  const text = piece.items.map((one) => [one.at, one.kind, one.text, one.hex ?? ""].join("\t")).join("\r\n");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "text/plain" }));
  link.download = `${port.name}-line.txt`;
  link.click();
  URL.revokeObjectURL(link.href);
}

export function LineMonitor({ port }: { port: Port }) {
  const { t } = useTranslation();
  const [entries, setEntries] = useState<MonitorEntry[]>([]);
  const [hex, setHex] = useState(false);
  const [still, setStill] = useState(false);
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (still) return undefined;
    let over = false, last = 0;
    let timer: ReturnType<typeof setTimeout> | undefined;
    const ask = async () => {
      try {
        // From the last but one: the newest entry may have grown.
        const piece = await get<{ items: MonitorEntry[]; last: number }>(`/ports/${port.id}/monitor?limit=1000&after=${Math.max(0, last - 1)}`);
        if (over) return;
        if (piece.last < last) { last = 0; setEntries([]); }
        const first = piece.items[0]?.sequence ?? Infinity;
        last = piece.items.at(-1)?.sequence ?? last;
        if (piece.items.length > 0) setEntries((before) => [...before.filter((one) => one.sequence < first), ...piece.items].slice(-kept));
      } catch { /* the page says that the server cannot be reached */ }
      if (!over) timer = setTimeout(ask, 400);
    };
    void ask();
    return () => { over = true; clearTimeout(timer); };
  }, [port.id, still]);
  useEffect(() => { if (!still && box.current) box.current.scrollTop = box.current.scrollHeight; }, [entries, still]);
  return (
    <div className="line-monitor" data-monitor={port.id}>
      <div className="records-bar"><Lamps signals={port.signals} />
        <span className="end"><Button small kind="quiet" icon="download" data-action="keep-monitor" onClick={() => void keep(port)}>{t("dnc.export")}</Button><label className="check"><input type="checkbox" checked={hex} onChange={(event) => setHex(event.target.checked)} />{t("dnc.hex")}</label>
          <label className="check"><input type="checkbox" checked={still} onChange={(event) => setStill(event.target.checked)} />{t("dnc.still")}</label></span></div>
      <div className="monitor-lines mono" ref={box} tabIndex={0} role="log" aria-label={t("dnc.monitor")}>
        {entries.length === 0 && <div className="dim">{t("dnc.monitor_empty")}</div>}
        {entries.map((entry) => (
          <div key={entry.sequence} className={`monitor-line ${entry.kind}`} data-kind={entry.kind}>
            <span className="dim">{clockTime(entry.at)}</span><span className="direction">{t(`dnc.dir_${entry.kind}`)}</span>
            <span className="bytes">{hex && entry.hex ? entry.hex : entry.hex ? <Bytes text={entry.text} /> : entry.kind === "fault" ? reasonText(entry.text) : entry.text}</span></div>))}
      </div>
    </div>
  );
}
