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
const last = { text: "", at: 0 };
/** What a notice told lately is not told once more beside it. */
const LATELY_MS = 6000;

/** Shows a sentence for some seconds; the same sentence is shown once. */
export function notice(text: string, tone: Tone = "info", { code = "", about = "" } = {}): void {
  const id = ++count;
  Object.assign(last, { text, at: performance.now() });
  notices.value = [...notices.value.filter((one) => one.text !== text), { id, text, tone, code, about }].slice(-MOST);
  setTimeout(() => dismiss(id), code ? REFUSED_MS : SHOWN_MS[tone]);
}

/** Whether a notice told this sentence a moment ago, whether it still stands or not. */
export const toldLately = (text: string): boolean => notices.value.some((one) => one.text === text) || (last.text === text && performance.now() - last.at < LATELY_MS);

export function dismiss(id: number): void {
  notices.value = notices.value.filter((one) => one.id !== id);
}

/** Takes a sentence back that something else says now. */
export function withdraw(text: string): void {
  notices.value = notices.value.filter((one) => one.text !== text);
}
