// Short sentences that come and go, read aloud by screen readers.
import { signal } from "@preact/signals";

export type Tone = "info" | "good" | "warn" | "bad";
/** `code` and `about` are those of a refusal. */
export interface Notice { id: number; text: string; tone: Tone; code: string; about: string }
export const notices = signal<Notice[]>([]);

const MOST = 3;
const SHOWN_MS: Record<Tone, number> = { info: 4000, good: 3500, warn: 7000, bad: 9000 };
/** What may have a button stays until it can be read and pressed. */
const REFUSED_MS = 14_000;
let count = 0;

/** Shows a sentence for some seconds; the same sentence is shown once. */
export function notice(text: string, tone: Tone = "info", { code = "", about = "" } = {}): void {
  const id = ++count;
  notices.value = [...notices.value.filter((one) => one.text !== text), { id, text, tone, code, about }].slice(-MOST);
  setTimeout(() => dismiss(id), code ? REFUSED_MS : SHOWN_MS[tone]);
}

export function dismiss(id: number): void {
  notices.value = notices.value.filter((one) => one.id !== id);
}

/** Takes a sentence back that something else says now. */
export function withdraw(text: string): void {
  notices.value = notices.value.filter((one) => one.text !== text);
}
