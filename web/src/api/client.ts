// Requests to the server. Every refusal becomes an ApiError that can be shown in the person's language.
import type { List, Localised } from "./types";

export class ApiError extends Error {
  constructor(
    readonly status: number,
    readonly code: string,
    readonly text: Localised | null,
    readonly where: string | null,
    readonly reason: string | null,
  ) {
    super(`${status} ${code}`);
  }
}

const base = "/api/v1";
let onSignedOut: () => void = () => {};

/// Called when the server no longer knows this session.
export function whenSignedOut(handler: () => void): void {
  onSignedOut = handler;
}

function failure(status: number, body: string): ApiError {
  try {
    const parsed = JSON.parse(body) as { error?: { code?: string; message?: Localised; where?: string }; reason?: string };
    return new ApiError(status, parsed.error?.code ?? "http", parsed.error?.message ?? null, parsed.error?.where ?? null,
      parsed.reason ?? null);
  } catch {
    return new ApiError(status, "http", null, null, null);
  }
}

async function send(method: string, path: string, body?: unknown, signal?: AbortSignal): Promise<Response> {
  const headers: Record<string, string> = {};
  if (method !== "GET") headers["X-Headstock"] = "1";
  if (body !== undefined) headers["Content-Type"] = "application/json";
  let response: Response;
  try {
    response = await fetch(base + path, {
      method, headers, credentials: "same-origin", signal: signal ?? null,
      body: body === undefined ? null : JSON.stringify(body),
    });
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    throw new ApiError(0, "unreachable", null, null, null);
  }
  if (!response.ok) {
    const problem = failure(response.status, await response.text());
    if (response.status === 401 && path !== "/session") onSignedOut();
    throw problem;
  }
  return response;
}

async function json<T>(method: string, path: string, body?: unknown, signal?: AbortSignal): Promise<T> {
  const response = await send(method, path, body, signal);
  const text = await response.text();
  return (text === "" ? null : JSON.parse(text)) as T;
}

export const get = <T>(path: string, signal?: AbortSignal) => json<T>("GET", path, undefined, signal);
export const post = <T>(path: string, body?: unknown) => json<T>("POST", path, body ?? {});
export const patch = <T>(path: string, body: unknown) => json<T>("PATCH", path, body);
export const remove = <T>(path: string, body?: unknown) => json<T>("DELETE", path, body);

/// Lists come bare or as `{items,next}`.
export async function list<T>(path: string, signal?: AbortSignal): Promise<T[]> {
  return (await page<T>(path, signal)).items;
}

export async function page<T>(path: string, signal?: AbortSignal): Promise<List<T>> {
  const answer = await get<T[] | List<T>>(path, signal);
  return Array.isArray(answer) ? { items: answer, next: null } : answer;
}

export function query(values: Record<string, string | number | boolean | null | undefined>): string {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(values)) {
    if (value !== null && value !== undefined && value !== "") search.set(name, String(value));
  }
  const text = search.toString();
  return text === "" ? "" : `?${text}`;
}

/// Sends a file's bytes as they are. XMLHttpRequest because fetch cannot tell how far an upload has come.
export function upload<T>(path: string, file: Blob, progress: (part: number) => void): Promise<T> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("POST", base + path);
    request.setRequestHeader("X-Headstock", "1");
    request.setRequestHeader("Content-Type", "application/octet-stream");
    request.upload.onprogress = (event) => progress(event.total > 0 ? event.loaded / event.total : 0);
    request.onerror = () => reject(new ApiError(0, "unreachable", null, null, null));
    request.onload = () => {
      if (request.status >= 200 && request.status < 300) resolve(JSON.parse(request.responseText) as T);
      else reject(failure(request.status, request.responseText));
    };
    request.send(file);
  });
}

/// A window of a stored revision's text.
export async function lines(program: number, revision: number, from: number, count: number, signal?: AbortSignal): Promise<string[]> {
  const response = await send("GET",
    `/programs/${program}/revisions/${revision}/content?from_line=${from}&lines=${count}`, undefined, signal);
  const text = await response.text();
  if (response.headers.get("Content-Type")?.startsWith("application/json")) {
    const parsed = JSON.parse(text) as { lines?: string[]; text?: string };
    return parsed.lines ?? splitLines(parsed.text ?? "");
  }
  return splitLines(text);
}

export function splitLines(text: string): string[] {
  const rows = text.split(/\r\n|\n|\r/);
  if (rows.at(-1) === "") rows.pop();
  return rows;
}

export const contentAddress = (program: number, revision: number) => `${base}/programs/${program}/revisions/${revision}/content`;

export async function wholeText(program: number, revision: number): Promise<string> {
  return (await send("GET", `/programs/${program}/revisions/${revision}/content`)).text();
}

interface Job<T> { job: number; state: "running" | "done" | "failed"; result?: T; error?: { code?: string; message?: Localised; where?: string } }

/// Checks, plots and comparisons may be long: the server then answers with a job to ask for until it is done.
export async function settled<T extends object>(answer: T | Job<T>, signal?: AbortSignal): Promise<T> {
  let current = answer;
  for (let waitMs = 250; "job" in current && "state" in current; waitMs = Math.min(2_000, waitMs * 1.5)) {
    if (current.state === "done") return current.result as T;
    if (current.state === "failed") throw new ApiError(422, current.error?.code ?? "http", current.error?.message ?? null, current.error?.where ?? null, null);
    await new Promise((resolve) => setTimeout(resolve, waitMs));
    current = await get<Job<T>>(`/jobs/${current.job}`, signal);
  }
  return current as T;
}
