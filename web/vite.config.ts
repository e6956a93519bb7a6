import { existsSync } from "node:fs";
import { fileURLToPath } from "node:url";
import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

// The build copies what the application shares with server and machines beside it; in the source tree it is read there.
const at = (path: string) => fileURLToPath(new URL(path, import.meta.url));
const shared = existsSync(at("shared")) ? at("shared") : at("../protocol/wire");

// `npm run dev` talks to a server (real or tests/browser/mock) on this port.
const server = process.env["HEADSTOCK_SERVER"] ?? "http://127.0.0.1:8080";

export default defineConfig({
  plugins: [react()],
  resolve: { alias: { "@shared": shared } },
  // Old tablets hang on the machines: keep to what a three-year-old browser understands.
  build: { target: "es2021", sourcemap: false, assetsInlineLimit: 0, chunkSizeWarningLimit: 800 },
  server: { port: 5173, proxy: { "/api": { target: server, ws: true } } },
});
