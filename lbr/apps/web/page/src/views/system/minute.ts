// What each part took of the processor during the last minute: heard since the page was opened.
import { effect, signal } from "@preact/signals";
import { status } from "../../live";
import type { CapabilityStatus } from "../../messages";

const MOST = 60;
export type Minute = Record<string, number[]>;
export const minute = signal<Minute>({});

/** A minute, and one second more of it; a part that is gone is forgotten. Pure. */
export const gathered = (known: Minute, parts: Pick<CapabilityStatus, "name" | "cpu_percent">[]): Minute =>
  Object.fromEntries(parts.map(({ name, cpu_percent }) => [name, [...(known[name] ?? []), ...(cpu_percent == null ? [] : [cpu_percent])].slice(-MOST)]));

/** A line for a box of 60 by 20: the newest at the right, the ceiling at 10 per cent or the most that there was. Pure. */
export function lineOf(values: number[]): string {
  const top = Math.max(10, ...values);
  return values.map((value, at) => `${at === 0 ? "M" : "L"}${MOST - values.length + at} ${(20 - (19 * value) / top).toFixed(1)}`).join("");
}

effect(() => {
  const told = status.value;
  if (told) minute.value = gathered(minute.peek(), told.capabilities);
});
