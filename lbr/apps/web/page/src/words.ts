// All text of the page, English and German side by side. A view's own words stand in `words/`, and come with the view.
import { signal } from "@preact/signals";
import type { behaviours } from "./words/behaviours";
import type { below } from "./words/below";
import type { call } from "./words/call";
import { codes } from "./words/codes";
import { drive } from "./words/drive";
import type { joints } from "./words/joints";
import type { motions } from "./words/motions";
import { shell } from "./words/shell";
import type { system } from "./words/system";
import { plain } from "./format";
import { remembered } from "./kept";

type Text = readonly [english: string, german: string];
export type WordKey = keyof (typeof shell & typeof behaviours & typeof below & typeof call & typeof codes & typeof drive & typeof joints & typeof motions & typeof system);
/** What can be said so far. */
export const TABLE: Partial<Record<WordKey, Text>> = { ...shell, ...codes, ...drive };

/** Adds the words of a view, by the module that says them. */
export const learn = (words: Partial<Record<WordKey, Text>>): void => { Object.assign(TABLE, words); };

export type Language = "en" | "de";
const PLACE: Record<Language, 0 | 1> = { en: 0, de: 1 };

/** The page's language: what was chosen, else the browser's. */
export const language = signal<Language>(remembered<Language>("language", navigator.language.toLowerCase().startsWith("de") ? "de" : "en"));

/** The text for a key, `{name}` in it replaced. */
export function t(key: WordKey, values: Record<string, string | number> = {}): string {
  const text = TABLE[key]?.[PLACE[language.value]] ?? key;
  return text.replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ""));
}

/** A row's name as people read it: a side in the page's language, other names as they are. */
export const named = (name: string): string => maybe(`side.${name}`) || plain(name);

/** A joint's name as people read it: in the page's language, its side last, where the page knows all its words. */
export function jointName(name: string): string {
  if (language.value === "en") return plain(name);
  const words = name.replace(/^(left|right)_(.+)/, "$2_$1").split("_").map((one) => maybe(`limb.${one}`));
  return words.every(Boolean) ? words.join(" ") : plain(name);
}

/** What a motion does, in the page's words where it has some: the names of rows are for tables and programs. */
export const deedName = (motion: string): string => maybe(`motions.key.${motion}`) || plain(motion);

/** The text for a key made at run time, such as a code; empty if the table has none. */
export const maybe = (key: string): string => (key in TABLE ? t(key as WordKey) : "");
