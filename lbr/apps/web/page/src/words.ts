// All text of the page: one table, English and German side by side. A view's own words stand in `words/`.
import { signal } from "@preact/signals";
import { behaviours } from "./words/behaviours";
import { call } from "./words/call";
import { codes } from "./words/codes";
import { drive } from "./words/drive";
import { joints } from "./words/joints";
import { motions } from "./words/motions";
import { shell } from "./words/shell";
import { system } from "./words/system";
import { plain } from "./format";
import { remembered } from "./kept";

export const TABLE = { ...shell, ...behaviours, ...call, ...codes, ...drive, ...joints, ...motions, ...system } as const;
export type WordKey = keyof typeof TABLE;
export type Language = "en" | "de";
const PLACE: Record<Language, 0 | 1> = { en: 0, de: 1 };

/** The page's language: what was chosen, else the browser's. */
export const language = signal<Language>(remembered<Language>("language", navigator.language.toLowerCase().startsWith("de") ? "de" : "en"));

/** The text for a key, `{name}` in it replaced. */
export function t(key: WordKey, values: Record<string, string | number> = {}): string {
  const text: string = TABLE[key][PLACE[language.value]];
  return text.replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ""));
}

/** A row's name as people read it: a side in the page's language, other names as they are. */
export const named = (name: string): string => maybe(`side.${name}`) || plain(name);

/** The text for a key made at run time, such as a code; empty if the table has none. */
export const maybe = (key: string): string => (key in TABLE ? t(key as WordKey) : "");
