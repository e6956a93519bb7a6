// The path of a milling program in space. Drawn only when something changes: a tablet at a machine must stay cool.
import { useEffect, useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import {
  AmbientLight, BufferAttribute, BufferGeometry, Color, ConeGeometry, DirectionalLight, GridHelper, Group, Line, LineBasicMaterial,
  LineSegments, Mesh, MeshLambertMaterial, PerspectiveCamera, Scene, Vector3, WebGLRenderer, AxesHelper, LineDashedMaterial,
} from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import type { Backplot } from "../api/types";
import { bounds, columns, cssColour, niceStep, type Trail } from "./plot";

export type Look = "iso" | "top" | "front";
interface Props { plot: Backplot | null; trail?: Trail; trailVersion?: number; tool?: number[] | null; toolAxes?: string[]; line?: number | null; theme: string; fitted: number; look: Look }

interface Stage {
  renderer: WebGLRenderer; scene: Scene; camera: PerspectiveCamera; controls: OrbitControls;
  fixedParts: Group; trail: Line; tool: Mesh; current: LineSegments; draw: () => void; size: number; centre: Vector3;
}

function makeStage(host: HTMLElement): Stage {
  const renderer = new WebGLRenderer({ antialias: true });
  renderer.setPixelRatio(Math.min(2, window.devicePixelRatio));
  host.appendChild(renderer.domElement);
  const scene = new Scene();
  const camera = new PerspectiveCamera(35, 1, 0.1, 20_000);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, renderer.domElement);
  const sun = new DirectionalLight(0xffffff, 2);
  sun.position.set(1, -2, 3);
  scene.add(sun, new AmbientLight(0xffffff, 1.2));
  const fixedParts = new Group();
  const trail = new Line(new BufferGeometry(), new LineBasicMaterial());
  const current = new LineSegments(new BufferGeometry(), new LineBasicMaterial());
  trail.frustumCulled = false;
  current.frustumCulled = false;
  const cone = new ConeGeometry(0.35, 1, 20);
  cone.translate(0, -0.5, 0);
  cone.rotateX(-Math.PI / 2);                  // its tip at the origin, its body along +Z
  const tool = new Mesh(cone, new MeshLambertMaterial());
  scene.add(fixedParts, trail, current, tool);
  let waiting = false;
  const draw = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; renderer.render(scene, camera); });
  };
  controls.addEventListener("change", draw);
  return { renderer, scene, camera, controls, fixedParts, trail, tool, current, draw, size: 100, centre: new Vector3() };
}

const directions: Record<Look, Vector3> = { iso: new Vector3(0.8, -1.25, 0.95), top: new Vector3(0, -0.001, 1), front: new Vector3(0, -1, 0.001) };

export function MillPath({ plot, trail, trailVersion, tool, toolAxes, line, theme, fitted, look }: Props) {
  const { t } = useTranslation();
  const host = useRef<HTMLDivElement>(null);
  const stage = useRef<Stage | null>(null);
  const [broken, setBroken] = useState(false);
  const [ready, setReady] = useState(0);

  useEffect(() => {
    const element = host.current;
    if (!element) return undefined;
    let made: Stage;
    try {
      made = makeStage(element);
    } catch {
      setBroken(true);
      return undefined;
    }
    stage.current = made;
    const observer = new ResizeObserver(() => {
      const { clientWidth: w, clientHeight: h } = element;
      if (w === 0 || h === 0) return;
      made.renderer.setSize(w, h);
      made.camera.aspect = w / h;
      made.camera.updateProjectionMatrix();
      made.draw();
    });
    observer.observe(element);
    setReady((n) => n + 1);
    return () => {
      observer.disconnect();
      made.controls.dispose();
      made.renderer.dispose();
      made.renderer.domElement.remove();
      stage.current = null;
    };
  }, []);

  useEffect(() => {
    const s = stage.current;
    if (!s) return;
    s.scene.background = new Color(cssColour("sunken"));
    for (const child of [...s.fixedParts.children]) {
      s.fixedParts.remove(child);
      if (child instanceof LineSegments) { child.geometry.dispose(); }
    }
    const place = plot ? columns(plot.axes, ["X", "Y", "Z"]) : [];
    const box = plot ? bounds(plot, place, true) : null;
    const min = new Vector3(...(box?.min ?? [-50, -50, -20])), max = new Vector3(...(box?.max ?? [50, 50, 20]));
    s.centre = min.clone().add(max).multiplyScalar(0.5);
    s.size = Math.max(10, max.distanceTo(min));
    if (plot) {
      for (const [kinds, colour, opacity] of [["r", "text-3", 0.55], ["fat", "accent", 1]] as const) {
        const points: number[] = [];
        plot.moves.forEach((move, i) => {
          const before = plot.moves[i - 1];
          if (before && kinds.includes(move.k)) for (const p of [before.p, move.p]) for (const c of place) points.push(p[c] ?? 0);
        });
        const geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
        const settings = { color: new Color(cssColour(colour)), transparent: opacity < 1, opacity };
        const drawn = new LineSegments(geometry, kinds === "r" ? new LineDashedMaterial({ ...settings, dashSize: s.size / 60, gapSize: s.size / 90 }) : new LineBasicMaterial(settings));
        if (kinds === "r") drawn.computeLineDistances();
        s.fixedParts.add(drawn);
      }
    }
    const step = niceStep(s.size, 12);
    const cells = Math.ceil((s.size * 1.5) / step / 2) * 2;
    const grid = new GridHelper(cells * step, cells, new Color(cssColour("line-strong")), new Color(cssColour("line")));
    grid.rotateX(Math.PI / 2);
    grid.position.set(Math.round(s.centre.x / step) * step, Math.round(s.centre.y / step) * step, Math.min(0, min.z));
    const axes = new AxesHelper(s.size / 6);
    s.fixedParts.add(grid, axes);
    s.tool.scale.setScalar(s.size / 12);
    (s.tool.material as MeshLambertMaterial).color.set(cssColour("hold"));
    (s.trail.material as LineBasicMaterial).color.set(cssColour("running"));
    (s.current.material as LineBasicMaterial).color.set(cssColour("hold"));
    s.draw();
  }, [plot, theme, ready]);

  useEffect(() => {
    const s = stage.current;
    if (!s) return;
    s.controls.target.copy(s.centre);
    s.camera.position.copy(directions[look].clone().normalize().multiplyScalar(s.size * 1.85)).add(s.centre);
    s.camera.near = s.size / 200;
    s.camera.far = s.size * 40;
    s.camera.updateProjectionMatrix();
    s.controls.update();
    s.draw();
  }, [plot, fitted, look, ready]);

  useEffect(() => {
    const s = stage.current;
    if (!s || !plot) return;
    const place = columns(plot.axes, ["X", "Y", "Z"]);
    const points: number[] = [];
    if (line) {
      plot.moves.forEach((move, i) => {
        const before = plot.moves[i - 1];
        if (before && move.l === line) for (const p of [before.p, move.p]) for (const c of place) points.push(p[c] ?? 0);
      });
    }
    s.current.geometry.dispose();
    s.current.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    s.draw();
  }, [plot, line, ready]);

  useEffect(() => {
    const s = stage.current;
    if (!s) return;
    const place = columns(toolAxes ?? [], ["X", "Y", "Z"]);
    s.tool.visible = tool !== null && tool !== undefined;
    if (tool) s.tool.position.set(tool[place[0] ?? 0] ?? 0, tool[place[1] ?? 1] ?? 0, tool[place[2] ?? 2] ?? 0);
    if (trail) {
      const points = new Float32Array(trail.points.flatMap((point) => place.map((c) => point[c] ?? 0)));
      s.trail.geometry.dispose();
      s.trail.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(points, 3));
    }
    s.draw();
  }, [tool, toolAxes, trail, trailVersion, ready]);

  if (broken) return <div className="empty">{t("machine.path_no_webgl")}</div>;
  return <div className="path-canvas" ref={host} data-path="mill" />;
}
