// The shapes of server/api/README.md, "Machine data".
export interface OffsetPage {
  axes: string[]; numbers: number; lathe: boolean; memory: string; wear: boolean; largest_mm: number; largest_wear_mm: number;
  tips: number; work_systems: number; extra_systems: number; variables: [number, number][];
}
export interface MachineValues {
  machine: number; profile: string; values: Record<string, number>; page: OffsetPage; version: number; reported: string | null;
  parameter_write: boolean;
}
export interface ValueItem { what: string; before: number | null; after: number | null; read_back?: number | null }
export interface SheetRow extends ValueItem { line: number; problem: string | null; text: string }
export interface ValueRequest {
  id: number; machine: number; by: string; at: string; origin: string; why: string; needs_second: string | null; second: string | null;
  state: "waiting" | "sending" | "unknown" | "done" | "refused" | "failed" | "withdrawn"; reason: string | null; where: string | null; values: ValueItem[];
}
export interface ValueChange { id: number; at: string; what: string; before: number | null; after: number | null; origin: string; by: string | null }
export interface Snapshot { id: number; name: string; by: string; at: string; values: number }
export interface Parameter {
  number: string; symbol: string; name_zh: string; meaning: string; unit: string; range: string; default: string; effective: string;
  value: number | null; axes: Record<string, number> | null;
}
export interface LifeTool { tool: number; offset: number; h: number; d: number; used: number; mark: string }
export interface LifeGroup {
  machine: number; machine_name: string; group: number; unit: "uses" | "seconds"; life: number; current: number; left_current: number; left_total: number;
  change_due: boolean; notice: boolean; per_part: number | null; parts_left: number | null; next_change_s: number | null; tools: LifeTool[];
}
