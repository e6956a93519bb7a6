export interface Folder { path: string; text: string; depth: number }

/// All folders in the order of a tree, with those in between that only a longer path names.
export function foldersOf(paths: readonly string[]): Folder[] {
  const all = new Set<string>();
  for (const path of paths) {
    const parts = path.split("/").filter(Boolean);
    for (let n = 1; n <= parts.length; n += 1) all.add(`/${parts.slice(0, n).join("/")}`);
  }
  const key = (path: string) => path.split("/");
  return [...all]
    .sort((a, b) => {
      const left = key(a), right = key(b);
      for (let i = 0; i < Math.min(left.length, right.length); i += 1) {
        const order = (left[i] ?? "").localeCompare(right[i] ?? "", undefined, { numeric: true });
        if (order !== 0) return order;
      }
      return left.length - right.length;
    })
    .map((path) => ({ path, text: path.slice(path.lastIndexOf("/") + 1), depth: path.split("/").length - 1 }));
}
