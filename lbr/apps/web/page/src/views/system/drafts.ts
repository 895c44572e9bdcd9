// What was typed and is not saved yet: it outlives another tab or view, until it is saved or thrown away.
import { effect, signal } from "@preact/signals";
import { unsaved } from "../../build";
import type { Basic } from "./basics";
import type { Row } from "./manage";

/** A setting that people ask for first, as it was typed. */
export interface Typed { basic: Basic; value: unknown }
export const typed = signal<Record<string, Typed>>({});

/** A row's form: the row as it was read, and as it is to be. */
export interface Draft { before: Row | null; now: Row }
export const drafts = signal<Record<string, Draft>>({});

/** Keeps what was typed under a key; null throws it away. */
export function keep<T>(of: { value: Record<string, T> }, key: string, what: T | null): void {
  const { [key]: _, ...others } = of.value;
  of.value = what === null ? others : { ...others, [key]: what };
}

let counted = 0;
effect(() => {
  const now = Object.keys(typed.value).length + Object.keys(drafts.value).length > 0 ? 1 : 0;
  unsaved.add(now - counted);
  counted = now;
});
