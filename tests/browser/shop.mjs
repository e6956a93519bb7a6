// A real shop for a test: server and agents on free ports with a data folder of their own, all ended at the end.
import { execFile, spawn } from "node:child_process";
import { createWriteStream, existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { promisify } from "node:util";
import { root } from "./paths.mjs";

const run = promisify(execFile);
const bin = process.env.HEADSTOCK_BIN ?? join(root, "build/release/bin");
export const binary = (name) => join(bin, name);
export const built = () => existsSync(binary("headstock-server")) && existsSync(binary("headstock-agent"));

async function freePort() {
  const probe = createServer();
  await new Promise((resolve) => probe.listen(0, "127.0.0.1", resolve));
  const { port } = probe.address();
  await new Promise((resolve) => probe.close(resolve));
  return port;
}

/// Asks until the answer is good. The condition decides, the limit only ends a test that will never pass.
export async function until(what, ask, limitMs = 120_000) {
  const end = Date.now() + limitMs;
  let last;
  while (Date.now() < end) {
    try {
      last = await ask();
      if (last) return last;
    } catch (error) {
      last = error;
    }
    await new Promise((resolve) => setTimeout(resolve, 100));
  }
  throw new Error(`waited ${limitMs / 1000} s for: ${what} (last: ${last instanceof Error ? last.message : JSON.stringify(last)})`);
}

export class Shop {
  processes = [];
  agents = new Map();

  /// `keepFirst`: leaves the first sign-in as it is, with which the server allows nothing but choosing a password.
  static async start({ keepFirst = false } = {}) {
    const shop = new Shop();
    shop.data = mkdtempSync(join(tmpdir(), "headstock-shop-"));
    shop.port = await freePort();
    shop.agentPort = await freePort();
    shop.url = `http://127.0.0.1:${shop.port}`;
    await shop.startServer();
    const first = readFileSync(join(shop.data, "server/first-sign-in"), "utf8");
    shop.user = /^user: *(.*)$/m.exec(first)[1];
    shop.password = /^password: *(.*)$/m.exec(first)[1];
    await shop.signIn();
    if (!keepFirst) {
      await shop.call("POST", "/session/password", { old: shop.password, new: "a good Passw0rd" });
      shop.password = "a good Passw0rd";
    }
    return shop;
  }

  spawn(name, args, log) {
    const child = spawn(binary(name), args, { stdio: ["ignore", "pipe", "pipe"] });
    const file = createWriteStream(join(this.data, log), { flags: "a" });
    child.stdout.pipe(file);
    child.stderr.pipe(file);
    // A process that ends by itself is told at once: what fails afterwards only follows from it.
    child.on("exit", (code, signal) => { if (!child.wanted) console.log(`${name} ended: ${signal ?? code}; end of ${log}:\n${readFileSync(join(this.data, log), "utf8").slice(-2000)}`); });
    this.processes.push(child);
    return child;
  }

  async startServer() {
    this.server = this.spawn("headstock-server", ["--data", join(this.data, "server"), "--port", String(this.port), "--agent-port", String(this.agentPort)], "server.log");
    await until("the server's health", async () => {
      if (this.server.exitCode !== null) throw new Error(readFileSync(join(this.data, "server.log"), "utf8"));
      return (await fetch(`${this.url}/api/v1/health`)).ok;
    });
  }

  async end(child, signal = "SIGTERM") {
    child.wanted = true;
    if (child.exitCode !== null || child.signalCode !== null) return;
    const ended = new Promise((resolve) => child.once("exit", resolve));
    child.kill(signal);
    const timer = setTimeout(() => child.kill("SIGKILL"), 10_000);
    await ended;
    clearTimeout(timer);
  }

  async signIn() {
    const { token } = await this.call("POST", "/session", { user: this.user, password: this.password }, null);
    this.token = token;
  }

  /// The API beside the browser: to prepare a shop, and to ask the store whether what the page shows is true.
  async call(method, path, body, token = this.token) {
    const response = await fetch(`${this.url}/api/v1${path}`, {
      method, body: body === undefined ? undefined : JSON.stringify(body),
      headers: { "Content-Type": "application/json", "X-Headstock": "1", ...(token ? { Authorization: `Bearer ${token}` } : {}) },
    });
    const text = await response.text();
    if (!response.ok) throw new Error(`${method} ${path}: ${response.status} ${text}`);
    return text === "" ? null : JSON.parse(text);
  }
  list = async (path) => { const answer = await this.call("GET", path); return Array.isArray(answer) ? answer : answer.items; };

  /// @param file of deploy/machines; @param token from the page, or nothing to make the machine here.
  async addMachine(name, profile, file, token) {
    const made = token ? null : await this.call("POST", "/machines", { name, profile });
    const folder = join(this.data, name.replaceAll(" ", "-").toLowerCase());
    const agent = { name, folder, args: ["--data", folder, "--machine", join(root, "deploy/machines", file), "--server", `127.0.0.1:${this.agentPort}`] };
    this.agents.set(name, agent);
    agent.process = this.spawn("headstock-agent", [...agent.args, "--enrol", token ?? made.enrolment_token], `${name}.log`);
    await until(`${name} connected`, async () => {
      if (agent.process.exitCode !== null) throw new Error(readFileSync(join(this.data, `${name}.log`), "utf8"));
      return (await this.list("/machines")).find((one) => one.name === name)?.live?.connected;
    });
    return (await this.list("/machines")).find((one) => one.name === name).id;
  }

  restartAgent(name) {
    const agent = this.agents.get(name);
    agent.process = this.spawn("headstock-agent", agent.args, `${name}.log`);
  }

  /// What a person does at the machine's own panel.
  async panel(name, ...command) {
    return (await run(binary("headstock-agent"), ["panel", "--data", this.agents.get(name).folder, ...command])).stdout;
  }

  async stop() {
    for (const child of [...this.processes].reverse()) await this.end(child);
    if (process.env.HEADSTOCK_KEEP) console.log(`kept: ${this.data}`);
    else rmSync(this.data, { recursive: true, force: true });
  }
}
