import react from "@vitejs/plugin-react";
import { defineConfig } from "vite";

declare const process: { env: Record<string, string | undefined> };

// `npm run dev` talks to a server (real or tests/browser/mock) on this port.
const server = process.env["HEADSTOCK_SERVER"] ?? "http://127.0.0.1:8080";

export default defineConfig({
  plugins: [react()],
  // Old tablets hang on the machines: keep to what a three-year-old browser understands.
  build: { target: "es2021", sourcemap: false, assetsInlineLimit: 0, chunkSizeWarningLimit: 800 },
  server: { port: 5173, proxy: { "/api": { target: server, ws: true } } },
});
