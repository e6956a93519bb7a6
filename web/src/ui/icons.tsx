// Small line icons, drawn for this application. State icons differ in shape, not only in colour.
import type { MachineState } from "../api/types";

const stateShapes: Record<MachineState, JSX.Element> = {
  running: <path d="M5 3.2v9.6L13 8z" fill="currentColor" />,
  hold: <path d="M4 3h3v10H4zM9 3h3v10H9z" fill="currentColor" />,
  stopped: <path d="M4 4h8v8H4z" fill="currentColor" />,
  idle: <circle cx="8" cy="8" r="4.6" fill="none" stroke="currentColor" strokeWidth="2" />,
  alarm: <path d="M8 1.6 15 14H1zM7.1 6v4h1.8V6zm0 5v1.7h1.8V11z" fill="currentColor" fillRule="evenodd" />,
  emergency_stop: <path d="M5.2 1.5h5.6l3.7 3.7v5.6l-3.7 3.7H5.2L1.5 10.8V5.2zM4.5 7v2h7V7z" fill="currentColor" fillRule="evenodd" />,
  setup: <path d="M10.6 2.2a4 4 0 0 0-4.7 5.2L2 11.3 4.7 14l3.9-3.9a4 4 0 0 0 5.2-4.7l-2.5 2.5-2.4-.8-.8-2.4z" fill="currentColor" />,
  off: <path d="M7.1 1.5h1.8V8H7.1zM5 3.9v2.2a4 4 0 1 0 6 0V3.9a5.8 5.8 0 1 1-6 0z" fill="currentColor" />,
  unknown: <path d="M7.1 10h1.8v-.8c0-.6.4-1 1-1.5.9-.7 1.6-1.4 1.6-2.7C11.5 3 10 2 8 2S4.6 3.1 4.5 5.2h1.9C6.5 4.2 7.1 3.7 8 3.7s1.5.5 1.5 1.4c0 .6-.3.9-1 1.5-.8.6-1.4 1.2-1.4 2.4zm0 1.6h1.8v1.9H7.1z" fill="currentColor" />,
};

export function StateIcon({ state, size = 16 }: { state: MachineState; size?: number }) {
  return <svg width={size} height={size} viewBox="0 0 16 16" aria-hidden="true">{stateShapes[state] ?? stateShapes.unknown}</svg>;
}

const shapes = {
  floor: "M2 2h5v5H2zM9 2h5v5H9zM2 9h5v5H2zM9 9h5v5H9z",
  programs: "M3.5 1.5h6l3 3v10h-9zM9.5 1.5v3h3M5.5 8h5M5.5 10.5h5",
  alarms: "M8 2 14.5 13.5h-13zM8 6.5v3.5M8 11.6v.6",
  data: "M2 3h12v10H2zM2 6.3h12M2 9.7h12M6.5 3v10",
  times: "M2 13.5h12M3.5 13V8.5M7 13V3.5M10.5 13V6.5M14 13v-3",
  users: "M8 7.5a2.7 2.7 0 1 0 0-5.4 2.7 2.7 0 0 0 0 5.4zM2.5 14c.4-3 2.5-4.5 5.5-4.5s5.1 1.5 5.5 4.5",
  folder: "M1.5 3.5h5l1.5 2h6.5v8h-13z",
  file: "M3.5 1.5h6l3 3v10h-9zM9.5 1.5v3h3",
  back: "M10 3 5 8l5 5",
  right: "M6 3l5 5-5 5",
  down: "M3 6l5 5 5-5",
  upload: "M8 10.5V2.5M4.5 6 8 2.5 11.5 6M2.5 10v3.5h11V10",
  close: "M3.5 3.5l9 9M12.5 3.5l-9 9",
  sun: "M8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6zM8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1",
  moon: "M13.5 9.5A6 6 0 0 1 6.5 2.5a6 6 0 1 0 7 7z",
  wall: "M1.5 3h13v8.5h-13zM5.5 14h5",
  search: "M7 2.5a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9zM10.3 10.3 14 14",
  send: "M2 8h10M8.5 4 12.5 8l-4 4",
  check: "M2.5 8.5 6 12l7.5-8",
  plus: "M8 2.5v11M2.5 8h11",
  edit: "M2.5 13.5l.8-3.3 7.5-7.5 2.5 2.5-7.5 7.5z",
  lock: "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 5 0v2.5",
  unlock: "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 4.8-1",
  link: "M6.5 9.5 9.5 6.5M7 5l1.5-1.5a2.8 2.8 0 0 1 4 4L11 9M9 11l-1.5 1.5a2.8 2.8 0 0 1-4-4L5 7",
  download: "M8 2.5v8M4.5 7 8 10.5 11.5 7M2.5 10v3.5h11V10",
  trash: "M3 4.5h10M6 4.5v-2h4v2M4.5 4.5l.5 9h6l.5-9",
} as const;
export type IconName = keyof typeof shapes;

export function Icon({ name, size = 16 }: { name: IconName; size?: number }) {
  return (
    <svg width={size} height={size} viewBox="0 0 16 16" fill="none" stroke="currentColor" strokeWidth="1.5"
      strokeLinecap="round" strokeLinejoin="round" aria-hidden="true">
      <path d={shapes[name]} />
    </svg>
  );
}

export function Logo({ size = 24 }: { size?: number }) {
  return (
    <svg width={size} height={size} viewBox="0 0 32 32" aria-hidden="true" className="logo">
      <g fill="none" stroke="currentColor" strokeWidth="2.6">
        <circle cx="13" cy="16" r="8.5" /><path d="M13 3v6M13 23v6M0.5 16h6" />
      </g>
      <path d="M20 13.6h11v4.8H20z" className="logo-bar" />
    </svg>
  );
}
