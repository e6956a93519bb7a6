// node embed.mjs DIST OUT: packs the built application into OUT/assets.S (the bytes) and OUT/assets_table.{hpp,cpp}.
import { createHash } from "node:crypto";
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { extname, join } from "node:path";
import { gzipSync } from "node:zlib";

const [dist, out] = process.argv.slice(2);
const mimes = {
  ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".css": "text/css; charset=utf-8",
  ".svg": "image/svg+xml", ".png": "image/png", ".ico": "image/x-icon", ".json": "application/json", ".woff2": "font/woff2",
};

const files = readdirSync(dist, { recursive: true, withFileTypes: true })
  .filter((entry) => entry.isFile())
  .map((entry) => join(entry.parentPath ?? entry.path, entry.name))
  .map((file) => ({ file, path: file.slice(dist.length).replaceAll("\\", "/") }))
  // By bytes, as std::string_view compares: find() searches by halves.
  .sort((a, b) => Buffer.compare(Buffer.from(a.path), Buffer.from(b.path)));

const packed = join(out, "packed");
rmSync(packed, { recursive: true, force: true });
mkdirSync(packed, { recursive: true });
const assembly = [".section .note.GNU-stack,\"\",%progbits", ".section .rodata"];
const rows = [];
for (const [i, { file, path }] of files.entries()) {
  const mime = mimes[extname(path)];
  if (!mime) throw new Error(`${path}: no MIME type known for this kind of file`);
  const plain = readFileSync(file);
  const small = gzipSync(plain, { level: 9 });
  const gzip = small.length < plain.length * 0.95;
  const bytes = gzip ? small : plain;
  const hash = createHash("sha256").update(plain).digest("hex");
  const kept = join(packed, String(i));
  writeFileSync(kept, bytes);
  // The hash in a comment makes this file change with the content: the build does not look inside .incbin.
  assembly.push(`# ${path} ${hash}`, ".balign 16", `.global headstock_asset_${i}`, `headstock_asset_${i}: .incbin "${kept}"`);
  rows.push({ i, path, size: bytes.length, mime, etag: `\\"${hash.slice(0, 20)}\\"`, gzip, immutable: path.startsWith("/assets/") });
}

const externs = rows.map((r) => `extern "C" const char headstock_asset_${r.i}[];`).join("\n");
const table = rows.map((r) =>
  `    {"${r.path}", {headstock_asset_${r.i}, ${r.size}}, "${r.mime}", "${r.etag}", ${r.gzip}, ${r.immutable}},`).join("\n");
writeFileSync(join(out, "assets.S"), assembly.join("\n") + "\n");
writeFileSync(join(out, "assets_table.cpp"), `// Made by web/embed.mjs.
#include "web/assets_table.hpp"

${externs}

namespace headstock::web {

const std::size_t kAssetCount = ${rows.length};
const Asset kAssets[] = {
${table}
};

}  // namespace headstock::web
`);
