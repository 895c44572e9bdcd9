// One WebSocket for the whole page: the newest of the streams that are looked at, events, and the motion that is held.
import { signal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { token, unknown } from "./access";
import { alike } from "./alike";
import { noteBuild } from "./build";
import type { Event, Status } from "./messages";
import { notice } from "./notices";
import { look, robot } from "./robot";

export type Link = "connecting" | "open" | "quiet" | "lost" | "hidden" | "refused";
export interface Aged { ageMs(): number; stale(ms?: number): boolean }
export interface Sample<T> extends Aged { message: T; at: number }
/** How old what is driven by is, there and back, and the share of the speed that the robot's server leaves it. */
export interface Pace { age_ms: number; speed: number }
export interface HoldNews { n: number; holds: boolean; code: string; reason: string; holder: string }

export const link = signal<Link>("connecting");
/** Told while a hand is on. */
export const pace = signal<Pace | null>(null);
export const status = signal<Status | null>(null);
export const events = signal<(Event & { id: number })[]>([]);
/** Performance time, four times a second, for what shows ages. */
export const clock = signal(performance.now());

const RATE_HZ = 25;
/** A stream that says nothing for so long is marked as old. */
export const STALE_MS = 1500;
/** @status comes once a second; without it for so long the line is dead, whatever the socket says. */
const SILENT_MS = 4000;
/** The robot speaks five times a second; one that does not is shown as silent. */
const QUIET_MS = 1000;
const AGAIN_MS = [300, 600, 1200, 2500] as const;
const MOST_EVENTS = 300;
const ALWAYS = ["@status", "@event"];

type Listener = (sample: Sample<unknown>) => void;
const listeners = new Map<string, Set<Listener>>();
const newest = new Map<string, Sample<unknown>>();
let socket: WebSocket | null = null;
let tries = 0;
let heardAt = 0;
let openedAt = 0;
let eventCount = 0;
let asked = "";
/** The newest time of the robot's server that was heard; told with motion, so that what waited on the line is known to be old. */
let serverTime: number | null = null;
let telling = false;
let again: ReturnType<typeof setTimeout> | undefined;
export const onHold = new Set<(news: HoldNews) => void>();
export const onEvent = new Set<(event: Event) => void>();
export const onLink = new Set<(open: boolean) => void>();

function sampled<T>(message: T, at: number): Sample<T> {
  const sample: Sample<T> = { message, at, ageMs: () => performance.now() - sample.at, stale: (ms = STALE_MS) => sample.ageMs() > ms };
  return sample;
}

/** Calls `fn` with each newest sample of a stream until the returned function is called. */
export function listen(key: string, fn: (sample: Sample<unknown>) => void): () => void {
  if (!key) return () => undefined;
  const all = listeners.get(key) ?? new Set<Listener>();
  listeners.set(key, all);
  all.add(fn);
  const known = newest.get(key);
  if (known) fn(known);
  tellKeys();
  return () => {
    all.delete(fn);
    if (all.size === 0) {
      listeners.delete(key);
      newest.delete(key);
      tellKeys();
    }
  };
}

/** As `listen`, for what is drawn: while a message looks as the one before, `fn` is not called, and the sample that it has stays young. */
export function watch(key: string, fn: (sample: Sample<unknown>) => void): () => void {
  let shown: Sample<unknown> | null = null;
  return listen(key, (one) => {
    if (shown && !shown.stale() && alike(shown.message, one.message)) shown.at = one.at;
    else fn(shown = sampled(one.message, one.at));
  });
}

/** What is seen of a stream while the component is shown; null before the first message. An empty key hears nothing. */
export function useStream<T>(key: string): Sample<T> | null {
  const [sample, show] = useState<{ key: string; sample: Sample<T> } | null>(null);
  useEffect(() => watch(key, (one) => show({ key, sample: one as Sample<T> })), [key]);
  return sample?.key === key ? sample.sample : null;
}

function tellKeys(): void {
  if (telling) return;
  telling = true;
  queueMicrotask(() => {
    telling = false;
    const keys = document.hidden ? [...ALWAYS] : [...ALWAYS, ...[...listeners.keys()].filter((key) => !ALWAYS.includes(key)).sort()];
    const wanted = JSON.stringify({ hear: keys, rate_hz: RATE_HZ });
    if (wanted !== asked && send(wanted)) asked = wanted;
  });
}

/** Sends a message; false if there is no open socket. */
export function send(message: string | object): boolean {
  if (socket?.readyState !== WebSocket.OPEN) return false;
  socket.send(typeof message === "string" ? message : JSON.stringify(message));
  return true;
}

/** For how long nothing was heard. */
export const silentMs = (): number => performance.now() - heardAt;

/** The newest time of the server's that was heard, for what must not be late; it speaks five times a second at least. */
export const heardTime = (): { t?: number } => (serverTime === null ? {} : { t: serverTime });

export function connect(): void {
  clearTimeout(again);
  if (socket !== null || document.hidden) return;
  if (unknown.value && robot.value === null) {
    link.value = "refused";
    return;
  }
  link.value = tries > 0 ? "lost" : "connecting";
  const address = new URL("api/live", location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  const made = new WebSocket(address, token.value ? ["lbr.live", `bearer.${token.value}`] : ["lbr.live"]);
  socket = made;
  serverTime = null;
  openedAt = performance.now();
  made.onopen = () => {
    if (made !== socket) return;
    asked = "";
    heardAt = performance.now();
    tellKeys();
    onLink.forEach((fn) => fn(true));
  };
  made.onmessage = (event: MessageEvent<string>) => { if (made === socket) hear(event.data); };
  made.onclose = () => { if (made === socket) lost(); };
}

function lost(): void {
  socket = null;
  onLink.forEach((fn) => fn(false));
  if (document.hidden) {
    link.value = "hidden";
    return;
  }
  link.value = "lost";
  again = setTimeout(connect, AGAIN_MS[Math.min(tries++, AGAIN_MS.length - 1)]);
  void look(); // a browser does not report that a socket was refused
}

/** Closes the socket; whoever listens hears nothing until `connect`. */
export function disconnect(): void {
  clearTimeout(again);
  const old = socket;
  socket = null;
  old?.close();
  onLink.forEach((fn) => fn(false));
}

interface Told { t?: number; page?: string; error?: { code: string; reason: string }; streams?: Record<string, { age_ms: number; message: unknown }>; events?: Event[]; hold?: HoldNews; link?: Pace }

function hear(text: string): void {
  let told: Told;
  try {
    told = JSON.parse(text) as Told;
  } catch {
    return;
  }
  heardAt = performance.now();
  if (typeof told.t === "number") serverTime = told.t;
  if (told.error) notice(told.error.reason, "warn");
  tries = 0;
  if (typeof told.page === "string") noteBuild(told.page);
  if (link.value !== "open") link.value = "open";
  for (const [key, { age_ms, message }] of Object.entries(told.streams ?? {})) {
    const sample = sampled(message, performance.now() - (Number.isFinite(age_ms) ? Math.max(0, age_ms) : 0));
    if (key === "@status") noteStatus(message as Status);
    if (listeners.has(key)) newest.set(key, sample);
    listeners.get(key)?.forEach((fn) => fn(sample));
  }
  if (told.events?.length) {
    const fresh = told.events.map((event) => ({ ...event, id: ++eventCount }));
    told.events.forEach((event) => onEvent.forEach((fn) => fn(event)));
    events.value = [...fresh.reverse(), ...events.value].slice(0, MOST_EVENTS);
  }
  if (told.link) pace.value = told.link;
  if (told.hold) onHold.forEach((fn) => fn(told.hold!));
}

/** Notes the robot's status. While that is of newer rows than the description which this page has, it is described anew: its server may still have the older one. */
function noteStatus(now: Status): void {
  status.value = now;
  if (now.revision !== undefined && robot.value !== null && now.revision !== robot.value.revision) void look();
}

/** The page is hidden or shown: hidden it hears next to nothing. */
function seen(): void {
  if (document.hidden) {
    link.value = "hidden";
    tellKeys();
    return;
  }
  if (socket === null) connect();
  else {
    heardAt = performance.now();
    link.value = "open";
    tellKeys();
  }
}

document.addEventListener("visibilitychange", seen);
window.addEventListener("pagehide", disconnect);
window.addEventListener("pageshow", () => connect());
window.addEventListener("online", () => { tries = 0; connect(); });
setInterval(() => {
  const now = performance.now();
  clock.value = now;
  if (document.hidden || socket === null) return;
  const silent = now - Math.max(heardAt, openedAt);
  if (silent > SILENT_MS) {
    const old = socket;
    disconnect();
    old.onclose = null;
    lost();
  } else if (silent > QUIET_MS && link.value === "open") link.value = "quiet";
}, 250);
