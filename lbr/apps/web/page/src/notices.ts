// Short sentences that come and go, read aloud by screen readers.
import { signal } from "@preact/signals";

export type Tone = "info" | "good" | "warn" | "bad";
export interface Notice { id: number; text: string; tone: Tone }
export const notices = signal<Notice[]>([]);

const MOST = 3;
const SHOWN_MS: Record<Tone, number> = { info: 4000, good: 3500, warn: 7000, bad: 9000 };
let count = 0;

/** Shows a sentence for some seconds; the same sentence is shown once. */
export function notice(text: string, tone: Tone = "info"): void {
  const id = ++count;
  notices.value = [...notices.value.filter((one) => one.text !== text), { id, text, tone }].slice(-MOST);
  setTimeout(() => dismiss(id), SHOWN_MS[tone]);
}

export function dismiss(id: number): void {
  notices.value = notices.value.filter((one) => one.id !== id);
}
