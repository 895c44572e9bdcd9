// What the page's modules need of a browser, with a clock that is the test's.
type Fn = () => void;
interface Timer { at: number; fn: Fn; every: number }

class Document extends EventTarget {
  hidden = false;
  documentElement = { lang: "en", dataset: {} };
}

export const kept = new Map<string, string>();
export let now = 1000;
const timers = new Map<number, Timer>();
let number = 0;

const put = (fn: Fn, ms: number, every: number): number => {
  timers.set(++number, { at: now + ms, fn, every });
  return number;
};

/** Lets time pass, timers and all; `starved`: nothing runs until it has passed. */
export function pass(ms: number, starved = false): void {
  const end = now + ms;
  if (starved) now = end;
  for (;;) {
    const due = [...timers].filter(([, one]) => one.at <= end).sort(([, a], [, b]) => a.at - b.at)[0];
    if (!due) break;
    const [key, timer] = due;
    now = Math.max(now, timer.at);
    if (timer.every) timer.at = now + timer.every;
    else timers.delete(key);
    timer.fn();
  }
  now = Math.max(now, end);
}

/** The robot's side of the socket. */
export class Socket {
  static OPEN = 1;
  static all: Socket[] = [];
  readyState = 0;
  said: Record<string, unknown>[] = [];
  onopen?: Fn;
  onclose?: Fn | null;
  onmessage?: (event: { data: string }) => void;
  constructor(readonly address: URL, readonly protocols: string[]) { Socket.all.push(this); }
  send(text: string): void { this.said.push(JSON.parse(text) as Record<string, unknown>); }
  close(): void { this.readyState = 3; }
  open(): void { this.readyState = 1; this.onopen?.(); }
  cut(): void { this.readyState = 3; this.onclose?.(); }
  tell(message: object): void { this.onmessage?.({ data: JSON.stringify({ t: Math.floor(now), ...message }) }); }
  get last(): Record<string, unknown> { return this.said.at(-1) ?? {}; }
}

export const doc = new Document();
export const win = new EventTarget();
export let reloads = 0;
const storage = { getItem: (key: string) => kept.get(key) ?? null, setItem: (key: string, value: string) => { kept.set(key, value); }, removeItem: (key: string) => { kept.delete(key); } };
const globals: Record<string, unknown> = {
  window: Object.assign(win, { addEventListener: win.addEventListener.bind(win) }),
  document: doc,
  localStorage: storage,
  sessionStorage: storage,
  location: { href: "http://robot.test/", reload: () => { reloads += 1; } },
  navigator: { language: "en-GB", userAgent: "" },
  performance: { now: () => now, timeOrigin: 0 },
  WebSocket: Socket,
  fetch: () => new Promise(() => undefined),
  setTimeout: (fn: Fn, ms = 0) => put(fn, ms, 0),
  setInterval: (fn: Fn, ms: number) => put(fn, ms, ms),
  clearTimeout: (key: number) => timers.delete(key),
  clearInterval: (key: number) => timers.delete(key),
  queueMicrotask: (fn: Fn) => fn(),
};
for (const [name, value] of Object.entries(globals)) Object.defineProperty(globalThis, name, { value, configurable: true, writable: true });
