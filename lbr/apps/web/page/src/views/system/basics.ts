// The settings that people ask for first: those that their declarations say are basic, of all parts of the robot. Pure.
import { itemTitle, titleOf, unitOf, type FieldOf } from "./schema";

export type Path = (string | number)[];
/** One basic setting: of which part, where in its settings, and what it is called. */
export interface Basic { part: string; path: Path; group: string; title: string; field: FieldOf }
export type Settings = Record<string, unknown>;
const FIRST = ["speed", "distances", "joints", "voice", "cameras"];

/** The basic settings of a part, in the order of their declaration; of a list, those of each thing in it. */
export function basicsOf(part: string, fields: FieldOf[], settings: Settings, path: Path = [], of = ""): Basic[] {
  return fields.flatMap((field) => {
    const at = [...path, field.name], value = settings[field.name] ?? field.fallback;
    if (field.kind === "list") return (Array.isArray(value) ? value : []).flatMap((item: Settings, number) => basicsOf(part, declared(field, number), item, [...at, number], itemTitle(field.fields, item, number)));
    if (field.kind === "object") return basicsOf(part, field.fields, (value ?? {}) as Settings, at, of);
    return field.basic ? [{ part, path: at, group: field.basic, title: [titleOf(field), of].filter(Boolean).join(", "), field }] : [];
  });
}

/** The fields of one thing in a list; where the list is declared with such a thing, that is what it usually is. */
function declared(field: FieldOf, number: number): FieldOf[] {
  const usual = (Array.isArray(field.fallback) ? field.fallback[number] : undefined) as Settings | undefined;
  return field.fields.map((one) => ({ ...one, fallback: usual?.[one.name] ?? one.fallback }));
}

/** The groups that there are: what most robots have first, then others by name. */
export function groupsOf(basics: Basic[]): { group: string; basics: Basic[] }[] {
  const found = [...new Set(basics.map((one) => one.group))];
  const order = [...FIRST.filter((one) => found.includes(one)), ...found.filter((one) => !FIRST.includes(one)).sort()];
  return order.map((group) => ({ group, basics: basics.filter((one) => one.group === group) }));
}

/** What a setting is, as it is written or else as declared. */
export function valueAt(fields: FieldOf[], settings: unknown, path: Path): unknown {
  const [name, ...rest] = path;
  if (name === undefined) return settings;
  if (typeof name === "number") return valueAt(fields, (settings as unknown[])[name], rest);
  const field = fields.find((one) => one.name === name);
  return valueAt(field?.fields ?? [], (settings as Settings | undefined)?.[name] ?? field?.fallback, rest);
}

/** Settings with one that is another; a list that was not written yet is written as declared, with that change. */
export function withValue<T>(fields: FieldOf[], settings: T, path: Path, value: unknown): T {
  const [name, ...rest] = path;
  if (name === undefined) return value as T;
  if (typeof name === "number") return (settings as unknown[]).map((one, number) => (number === name ? withValue(fields, one, rest, value) : one)) as T;
  const field = fields.find((one) => one.name === name);
  const { [name]: was, ...others } = (settings ?? {}) as Settings;
  const next = withValue(field?.fields ?? [], rest.length > 0 ? was ?? field?.fallback : was, rest, value);
  return (next === undefined ? others : { ...others, [name]: next }) as T;
}

/** A part of a whole, which a slider shows as per cent. */
export const isShare = (field: FieldOf): boolean => field.kind === "number" && field.most === 1 && (field.least === 0 || field.above === 0) && unitOf(field).unit === "";
