// A program's text, a window of it at a time: never more than a few thousand lines are in the browser.
import { useCallback, useEffect, useLayoutEffect, useRef, useState, type KeyboardEvent } from "react";
import { lines as loadLines } from "../api/client";
import { Code } from "./Code";
import { sameBlock } from "./tokens";
import { chunkLines, chunksOf, clampFirst, firstAt, heightPx, isScaled, rowPx, rowsIn, scrollAt } from "./window";

const keptChunks = 40;

interface Props {
  program: number; revision: number; total: number;
  line?: number | null;                       // the running or chosen line, 1-based
  block?: string | null;                      // what runs there, if known
  onElsewhere?: (elsewhere: boolean) => void; // that line holds another text: a sub-program runs
  follow?: boolean; onUnfollow?: () => void;
  findings?: ReadonlyMap<number, string>;
  label: string;
}

export function Listing({ program, revision, total, line, block, onElsewhere, follow, onUnfollow, findings, label }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const chunks = useRef(new Map<number, string[] | "loading" | "failed">());
  const [viewPx, setViewPx] = useState(400);
  const [first, setFirst] = useState(0);
  const [, redraw] = useState(0);
  const placed = useRef(-1);                  // scroll position this code set itself
  const extent = { total, viewPx };

  useEffect(() => { chunks.current = new Map(); setFirst(0); redraw((n) => n + 1); }, [program, revision]);
  useLayoutEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const observer = new ResizeObserver(() => setViewPx(element.clientHeight));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);

  const place = useCallback((wanted: number) => {
    const to = clampFirst(wanted, { total, viewPx });
    setFirst(to);
    if (box.current) {
      box.current.scrollTop = scrollAt(to, { total, viewPx });
      placed.current = box.current.scrollTop;
    }
  }, [total, viewPx]);

  useEffect(() => {
    if (!follow || !line) return;
    place(line - 1 - rowsIn(viewPx) * 0.4);
  }, [follow, line, place, viewPx]);

  const rows = rowsIn(viewPx) + 2;
  const from = Math.floor(first);
  useEffect(() => {
    // Wait a moment: someone who drags the scroll bar through five million lines does not want them all.
    const timer = setTimeout(() => {
      for (const index of chunksOf(from, rows, total)) {
        const have = chunks.current.get(index);
        if (have !== undefined && have !== "failed") continue;
        const into = chunks.current;
        into.set(index, "loading");
        loadLines(program, revision, index * chunkLines + 1, chunkLines).then(
          (text) => { into.set(index, text); redraw((n) => n + 1); },
          () => { into.set(index, "failed"); redraw((n) => n + 1); });
        for (const old of into.keys()) {
          if (into.size <= keptChunks) break;
          if (Math.abs(old - index) > 4) into.delete(old);
        }
      }
    }, 60);
    return () => clearTimeout(timer);
  }, [program, revision, from, rows, total]);

  // Not through React: its wheel listener is passive and may not stop the browser's own scrolling.
  useEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const wheel = (event: WheelEvent) => {
      if (Math.abs(event.deltaY) > Math.abs(event.deltaX)) onUnfollow?.();
      if (!isScaled({ total, viewPx })) return;
      event.preventDefault();
      place(first + event.deltaY / rowPx);
    };
    element.addEventListener("wheel", wheel, { passive: false });
    return () => element.removeEventListener("wheel", wheel);
  }, [first, onUnfollow, place, total, viewPx]);

  const onScroll = () => {
    const at = box.current?.scrollTop ?? 0;
    if (Math.abs(at - placed.current) < 1) return;
    placed.current = -1;
    setFirst(firstAt(at, extent));
  };
  const onKeyDown = (event: KeyboardEvent) => {
    const page = rowsIn(viewPx) - 1;
    const steps: Record<string, number> = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -total, End: total };
    const step = steps[event.key];
    if (step === undefined) return;
    event.preventDefault();
    onUnfollow?.();
    place(first + step);
  };

  // The machine reports the line of the program that runs, which may be a called one. A line is marked as running only
  // if it holds the block that runs.
  const there = line ? chunks.current.get(Math.floor((line - 1) / chunkLines)) : undefined;
  const elsewhere = Boolean(block) && Array.isArray(there) && line ? !sameBlock(there[(line - 1) % chunkLines] ?? "", block ?? "") : false;
  useEffect(() => { onElsewhere?.(elsewhere); }, [elsewhere, onElsewhere]);

  const digits = Math.max(3, String(total).length);
  const shown = [];
  for (let index = from; index < Math.min(total, from + rows); index += 1) {
    const chunk = chunks.current.get(Math.floor(index / chunkLines));
    const text = Array.isArray(chunk) ? chunk[index % chunkLines] ?? "" : null;
    const number = index + 1;
    const finding = findings?.get(number);
    shown.push(
      <div key={number} className={`row${number === line && !elsewhere ? " current" : ""}${finding ? " finding" : ""}`} data-line={number} title={finding}
        aria-current={number === line && !elsewhere ? "step" : undefined}>
        <span className="row-number" style={{ width: `${digits + 1}ch` }}>{number}</span>
        <code>{text === null ? <i className="dim">…</i> : <Code text={text} />}</code>
      </div>);
  }
  return (
    <div className="listing mono" ref={box} tabIndex={0} role="region" aria-label={label} onScroll={onScroll} onKeyDown={onKeyDown} data-first={from + 1}>
      <div style={{ height: heightPx(extent) }} className="listing-height">
        <div className="listing-window" style={{ height: viewPx }}>
          <div style={{ transform: `translateY(${-(first - from) * rowPx}px)` }}>{shown}</div>
        </div>
      </div>
    </div>
  );
}
