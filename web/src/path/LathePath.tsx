// The path of a turning program: Z to the right, X up as on the drawing, both at one scale. X is drawn as a radius and
// lettered as a diameter, because that is what the program and the position page say.
import { useEffect, useRef, useState, type PointerEvent } from "react";
import type { Backplot } from "../api/types";
import { fixed } from "../format/number";
import { bounds, columns, cssColour, niceStep, type Trail } from "./plot";

interface View { z: number; r: number; scale: number }     // work coordinates at the centre; pixels a mm
interface Props { plot: Backplot | null; trail?: Trail; trailVersion?: number; tool?: number[] | null; toolAxes?: string[]; line?: number | null; theme: string; fitted: number }

export function LathePath({ plot, trail, trailVersion, tool, toolAxes, line, theme, fitted }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [size, setSize] = useState({ w: 0, h: 0 });
  const [view, setView] = useState<View | null>(null);
  const drag = useRef<{ x: number; y: number; view: View } | null>(null);

  useEffect(() => {
    const element = box.current;
    if (!element) return undefined;
    const observer = new ResizeObserver(() => setSize({ w: element.clientWidth, h: element.clientHeight }));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);

  useEffect(() => {
    if (size.w === 0) return;
    const box = plot ? bounds(plot, columns(plot.axes, ["Z", "X"]), true) : null;
    const zMin = box?.min[0] ?? -100, zMax = box?.max[0] ?? 20, xMin = Math.min(0, box?.min[1] ?? 0), xMax = box?.max[1] ?? 60;
    const scale = Math.min((size.w - 96) / Math.max(1, zMax - zMin), (size.h - 84) / Math.max(1, (xMax - xMin) / 2));
    setView({ z: (zMin + zMax) / 2, r: (xMin + xMax) / 4, scale });
  }, [plot, size, fitted]);

  useEffect(() => {
    const element = canvas.current;
    const pen = element?.getContext("2d");
    if (!element || !pen || !view || size.w === 0) return;
    const ratio = window.devicePixelRatio || 1;
    element.width = size.w * ratio;
    element.height = size.h * ratio;
    pen.scale(ratio, ratio);
    pen.fillStyle = cssColour("sunken");
    pen.fillRect(0, 0, size.w, size.h);
    const px = (z: number) => size.w / 2 + 18 + (z - view.z) * view.scale;
    const py = (x: number) => size.h / 2 - 10 - (x / 2 - view.r) * view.scale;

    drawGrid(pen, size, view, px, py);
    if (plot) {
      const [z = -1, x = -1] = columns(plot.axes, ["Z", "X"]);
      const strokes: [string[], string, number, number[]][] = [[["r"], cssColour("text-3"), 1, [5, 4]], [["f", "a", "t"], cssColour("accent"), 1.6, []]];
      for (const [moveKinds, colour, width, dash] of strokes) {
        pen.beginPath();
        plot.moves.forEach((move, i) => {
          const before = plot.moves[i - 1];
          if (!before || !moveKinds.includes(move.k)) return;
          pen.moveTo(px(before.p[z] ?? 0), py(before.p[x] ?? 0));
          pen.lineTo(px(move.p[z] ?? 0), py(move.p[x] ?? 0));
        });
        pen.strokeStyle = colour; pen.lineWidth = width; pen.setLineDash(dash); pen.globalAlpha = moveKinds[0] === "r" ? 0.7 : 0.9; pen.stroke();
      }
      pen.setLineDash([]); pen.globalAlpha = 1;
      if (line) {
        pen.beginPath();
        plot.moves.forEach((move, i) => {
          const before = plot.moves[i - 1];
          if (!before || move.l !== line) return;
          pen.moveTo(px(before.p[z] ?? 0), py(before.p[x] ?? 0));
          pen.lineTo(px(move.p[z] ?? 0), py(move.p[x] ?? 0));
        });
        pen.strokeStyle = cssColour("hold"); pen.lineWidth = 3; pen.stroke();
      }
    }
    const [tz = -1, tx = -1] = columns(toolAxes ?? [], ["Z", "X"]);
    if (trail && trail.points.length > 1 && tz >= 0) {
      pen.beginPath();
      trail.points.forEach((point, i) => (i === 0 ? pen.moveTo(px(point[tz] ?? 0), py(point[tx] ?? 0)) : pen.lineTo(px(point[tz] ?? 0), py(point[tx] ?? 0))));
      pen.strokeStyle = cssColour("running"); pen.lineWidth = 2.2; pen.stroke();
    }
    if (tool && tz >= 0) {
      const x0 = px(tool[tz] ?? 0), y0 = py(tool[tx] ?? 0);
      // An insert that points at the work from behind the centre line.
      pen.beginPath(); pen.moveTo(x0, y0); pen.lineTo(x0 + 7, y0 - 18); pen.lineTo(x0 + 18, y0 - 9); pen.closePath();
      pen.fillStyle = cssColour("hold"); pen.fill();
      pen.beginPath(); pen.arc(x0, y0, 3.2, 0, 7); pen.fillStyle = cssColour("text"); pen.fill();
    }
  }, [plot, view, size, tool, toolAxes, trail, trailVersion, line, theme]);

  useEffect(() => {
    const element = canvas.current;
    if (!element) return undefined;
    const wheel = (event: WheelEvent) => {
      event.preventDefault();
      const factor = Math.exp(-event.deltaY / 500);
      setView((v) => {
        if (!v) return v;
        const place = element.getBoundingClientRect();
        const dz = (event.clientX - place.left - size.w / 2 - 18) / v.scale, dr = -(event.clientY - place.top - size.h / 2 + 10) / v.scale;
        return { scale: Math.min(2000, Math.max(0.02, v.scale * factor)), z: v.z + dz * (1 - 1 / factor), r: v.r + dr * (1 - 1 / factor) };
      });
    };
    element.addEventListener("wheel", wheel, { passive: false });
    return () => element.removeEventListener("wheel", wheel);
  }, [size]);

  const down = (event: PointerEvent) => { if (view) { drag.current = { x: event.clientX, y: event.clientY, view }; (event.target as Element).setPointerCapture(event.pointerId); } };
  const move = (event: PointerEvent) => {
    const from = drag.current;
    if (from) setView({ ...from.view, z: from.view.z - (event.clientX - from.x) / from.view.scale, r: from.view.r + (event.clientY - from.y) / from.view.scale });
  };
  return (
    <div className="path-canvas" ref={box} data-path="lathe">
      <canvas ref={canvas} style={{ width: size.w, height: size.h }} onPointerDown={down} onPointerMove={move} onPointerUp={() => { drag.current = null; }} />
    </div>
  );
}

function drawGrid(pen: CanvasRenderingContext2D, size: { w: number; h: number }, view: View, px: (z: number) => number, py: (x: number) => number) {
  const step = niceStep(size.w / view.scale, size.w / 90);
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  pen.font = "11px " + cssColour("sans");
  pen.lineWidth = 1;
  pen.strokeStyle = cssColour("line");
  pen.fillStyle = cssColour("text-3");
  pen.textAlign = "center";
  const half = size.w / 2 / view.scale + 20 / view.scale;
  for (let z = Math.ceil((view.z - half) / step) * step; z <= view.z + half; z += step) {
    const x = Math.round(px(z)) + 0.5;
    pen.beginPath(); pen.moveTo(x, 0); pen.lineTo(x, size.h - 20); pen.stroke();
    pen.fillText(fixed(z, digits), x, size.h - 7);
  }
  pen.textAlign = "right";
  const halfR = size.h / 2 / view.scale;
  for (let r = Math.ceil((view.r - halfR - 20) / (step / 2)) * (step / 2); r <= view.r + halfR; r += step / 2) {
    const y = Math.round(py(r * 2)) + 0.5;
    if (y > size.h - 20) continue;
    pen.beginPath(); pen.moveTo(42, y); pen.lineTo(size.w, y); pen.stroke();
    pen.fillText(`⌀${fixed(Math.abs(r * 2), digits)}`, 38, y + 4);
  }
  const centre = Math.round(py(0)) + 0.5;
  pen.beginPath(); pen.setLineDash([14, 4, 3, 4]); pen.moveTo(42, centre); pen.lineTo(size.w, centre);
  pen.strokeStyle = cssColour("text-3"); pen.stroke(); pen.setLineDash([]);
  pen.textAlign = "left";
  pen.fillStyle = cssColour("text-2");
  pen.fillText("Z →", size.w - 28, centre - 6);
  pen.fillText("X ↑", 46, 14);
}
