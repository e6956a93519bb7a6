// Which lines a listing shows, for programs of any length. A browser cannot scroll further than some ten million
// pixels, so above that the scroll bar stands for the program in proportion, and wheel and keys move by lines.

export const rowPx = 22;
export const longestPx = 8_000_000;

export interface Extent { total: number; viewPx: number }

export const rowsIn = (viewPx: number) => Math.max(1, Math.floor(viewPx / rowPx));
export const heightPx = ({ total }: Extent) => Math.min(total * rowPx, longestPx);
export const lastFirst = ({ total, viewPx }: Extent) => Math.max(0, total - viewPx / rowPx);

/// First line shown (0-based, may lie between lines) for a scroll position, and back.
export function firstAt(scrollPx: number, extent: Extent): number {
  const most = heightPx(extent) - extent.viewPx;
  return most <= 0 ? 0 : Math.min(1, Math.max(0, scrollPx / most)) * lastFirst(extent);
}
export function scrollAt(first: number, extent: Extent): number {
  const most = heightPx(extent) - extent.viewPx;
  const last = lastFirst(extent);
  return last <= 0 ? 0 : (first / last) * Math.max(0, most);
}

export const isScaled = ({ total }: Extent) => total * rowPx > longestPx;
export const clampFirst = (first: number, extent: Extent) => Math.min(lastFirst(extent), Math.max(0, first));

export const chunkLines = 200;
export const chunksOf = (first: number, rows: number, total: number): number[] => {
  const from = Math.floor(Math.max(0, first) / chunkLines);
  const to = Math.floor(Math.min(total - 1, first + rows) / chunkLines);
  return Array.from({ length: Math.max(0, to - from + 1) }, (_, i) => from + i);
};
