// The one WebSocket of the page: connects again with back-off, and calls itself lost when the server falls silent.
import { emptyShop, lost, receive, type ServerMessage, type Shop } from "./store";

const silenceMs = 4_000;      // the server ticks every second
const firstWaitMs = 500;
const longestWaitMs = 10_000;

export class LiveLink {
  private shop: Shop = emptyShop;
  private readonly listeners = new Set<() => void>();
  private socket: WebSocket | null = null;
  private wanted = false;
  private waitMs = firstWaitMs;
  private retry: ReturnType<typeof setTimeout> | undefined;
  private watch: ReturnType<typeof setInterval> | undefined;
  private heardAt = 0;
  private frame: ReturnType<typeof setTimeout> | undefined;
  private readonly topics = new Map<string, number>([["floor", 1], ["transfers", 1], ["programs", 1]]);

  get state(): Shop { return this.shop; }

  subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  start(): void {
    if (this.wanted) return;
    this.wanted = true;
    this.connect();
    this.watch = setInterval(() => {
      if (this.shop.link === "open" && performance.now() - this.heardAt > silenceMs) this.socket?.close();
      // close() may take long on a dead network: do not wait for it to say so.
      if (this.shop.link === "open" && performance.now() - this.heardAt > silenceMs + 500) this.dropped(this.socket);
    }, 500);
  }

  stop(): void {
    this.wanted = false;
    clearTimeout(this.retry);
    clearInterval(this.watch);
    const socket = this.socket;
    this.socket = null;
    socket?.close();
    this.shop = emptyShop;
    this.tell();
  }

  /// Asks for more about one thing ("machine:3") while something on the page shows it.
  want(topic: string): () => void {
    this.topics.set(topic, (this.topics.get(topic) ?? 0) + 1);
    this.sendTopics();
    return () => {
      const left = (this.topics.get(topic) ?? 1) - 1;
      if (left === 0) this.topics.delete(topic);
      else this.topics.set(topic, left);
      this.sendTopics();
    };
  }

  retryNow(): void {
    if (!this.wanted || this.shop.link === "open") return;
    clearTimeout(this.retry);
    this.waitMs = firstWaitMs;
    this.connect();
  }

  private connect(): void {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/api/v1/events`);
    this.socket = socket;
    socket.onopen = () => {
      this.heardAt = performance.now();
      this.sendTopics();
    };
    socket.onmessage = (event) => {
      if (socket !== this.socket) return;
      this.heardAt = performance.now();
      let message: ServerMessage;
      try {
        message = JSON.parse(String(event.data)) as ServerMessage;
      } catch {
        return;
      }
      if (message.type === "snapshot") this.waitMs = firstWaitMs;
      this.shop = receive(this.shop, message, this.heardAt);
      this.tellSoon();
    };
    socket.onclose = () => this.dropped(socket);
  }

  private dropped(socket: WebSocket | null): void {
    if (!this.wanted || socket !== this.socket) return;
    this.socket = null;
    this.shop = lost(this.shop, performance.now());
    this.tell();
    // Jitter: sixty tablets must not all come back in the same instant.
    const wait = this.waitMs * (0.75 + Math.random() / 2);
    this.waitMs = Math.min(this.waitMs * 2, longestWaitMs);
    clearTimeout(this.retry);
    this.retry = setTimeout(() => this.connect(), wait);
  }

  private sendTopics(): void {
    if (this.socket?.readyState === WebSocket.OPEN) {
      this.socket.send(JSON.stringify({ subscribe: [...this.topics.keys()] }));
    }
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }

  // Sixty machines at five messages a second would be 300 drawings a second: ten are enough for eyes.
  private tellSoon(): void {
    this.frame ??= setTimeout(() => {
      this.frame = undefined;
      this.tell();
    }, 100);
  }
}

export const link = new LiveLink();
