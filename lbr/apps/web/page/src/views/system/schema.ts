// What a form needs to know of a table's columns and of settings, from their JSON schemas. Pure.
import { plain } from "../../format";
import { maybe, named } from "../../words";

export interface Schema {
  $ref?: string; $defs?: Record<string, Schema>; type?: string | string[]; title?: string; description?: string; properties?: Record<string, Schema>; required?: string[];
  enum?: unknown[]; const?: unknown; anyOf?: Schema[]; minimum?: number; maximum?: number; exclusiveMinimum?: number; exclusiveMaximum?: number; pattern?: string; maxLength?: number; minLength?: number; default?: unknown; items?: Schema;
  /** The group of settings for people that it is one of, such as `speed`. */
  "x-basic"?: string;
}
export type FieldKind = "text" | "number" | "integer" | "flag" | "choice" | "object" | "list" | "json";
export interface FieldOf {
  name: string; title: string; basic: string; kind: FieldKind; help: string; needed: boolean; nullable: boolean; fallback: unknown; choices: string[];
  least: number | null; most: number | null; above: number | null; below: number | null; longest: number | null; pattern: string;
  /** Of an object, or of each thing in a list. */
  fields: FieldOf[];
}
export type Problem = { key: "form.needed" | "form.number" | "form.whole" | "form.least" | "form.most" | "form.above" | "form.below" | "form.longest" | "form.json"; value?: number };

const UNITS: Record<string, string> = {
  s: "s", ms: "ms", us: "µs", hz: "Hz", m: "m", cm: "cm", mm: "mm", deg: "°", rad: "rad", mps: "m/s", mps2: "m/s²", rps: "rad/s", dps: "°/s", v: "V", mv: "mV", a: "A", ma: "mA", ah: "Ah", c: "°C",
  g: "g", kg: "kg", nm: "N m", px: "px", percent: "%", db: "dB", mb: "MB", kb: "kB", bytes: "B", baud: "baud", w: "W", ut: "µT",
};

/** A number's name without its unit, and the unit as it is written: `watchdog_ms` is "watchdog" in ms. */
export function unitOf(field: Pick<FieldOf, "name" | "kind">): { stem: string; unit: string } {
  const [, stem = "", per = "", unit = ""] = /^(.+?)(_per)?_([a-z0-9]+)$/.exec(field.name) ?? [];
  const known = (field.kind === "number" || field.kind === "integer") && UNITS[unit];
  return known ? { stem, unit: per ? `/ ${known}` : known } : { stem: field.name, unit: "" };
}

/** What the page says of a field that people ask for first, in its language; empty where it has no words for it. */
const said = (field: Pick<FieldOf, "basic" | "name">, more = ""): string => (field.basic ? maybe(`setting.${field.basic}.${field.name}${more}`) : "");

/** The short words of names, in full. */
const IN_FULL: Record<string, string> = {
  accel: "acceleration", argv: "arguments", ca: "certificate authority", cors: "CORS", env: "environment", fov: "field of view", fps: "pictures a second", hz: "rate", id: "ID", imu: "inertial unit",
  lsb: "counts", mag: "magnetometer", tls: "TLS", ttl: "lifetime", url: "address",
};
const inFull = (stem: string): string => plain(stem).replace(/[a-z]+/g, (word) => IN_FULL[word] ?? word);

/** What people call a field: as the page says or it is declared, or else its name in full words, without its unit. */
export const titleOf = (field: FieldOf): string => said(field) || field.title || capital(inFull(unitOf(field).stem));
/** What a field is for; nothing where the page's title says it all. */
export const helpOf = (field: FieldOf): string => said(field, ".help") || (said(field) ? "" : field.help);
/** What people call a choice. */
export const choiceOf = (field: FieldOf, choice: string): string => said(field, `.${choice}`) || choice;
const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/** What people call one thing of a list: by the first of its own names, such as the direction of a rule. */
export function itemTitle(fields: FieldOf[], item: Record<string, unknown>, number: number): string {
  const first = fields.filter((one) => one.kind === "choice" || one.kind === "text").map((one) => item[one.name]).find((one) => typeof one === "string" && one !== "");
  return first === undefined ? String(number + 1) : named(String(first));
}

function resolved(schema: Schema, defs: Record<string, Schema>, depth = 0): Schema {
  const name = schema.$ref?.split("/").pop();
  const found = name !== undefined && depth < 8 ? defs[name] : undefined;
  return found ? { ...resolved(found, defs, depth + 1), ...(schema.default !== undefined ? { default: schema.default } : {}), ...(schema.description ? { description: schema.description } : {}) } : schema;
}

/** The fields of a struct, in its order. */
export function fieldsOf(schema: Schema, defs: Record<string, Schema> = schema.$defs ?? {}, depth = 0): FieldOf[] {
  const struct = resolved(schema, defs);
  return Object.entries(struct.properties ?? {}).map(([name, one]) => fieldOf(name, one, defs, (struct.required ?? []).includes(name), depth));
}

function fieldOf(name: string, given: Schema, defs: Record<string, Schema>, needed: boolean, depth: number): FieldOf {
  const whole = resolved(given, defs);
  const options = (whole.anyOf ?? [whole]).map((one) => resolved(one, defs));
  const some = options.filter((one) => one.type !== "null");
  const bare: Schema = some.length === 1 ? some[0]! : {};
  const inner = bare.type === "array" && bare.items ? resolved(bare.items, defs) : bare;
  const fields = inner.type === "object" && inner.properties && depth < 3 ? fieldsOf(inner, defs, depth + 1) : [];
  const help = given.description ?? whole.description ?? bare.description ?? "";
  const choices = bare.enum ?? (bare.const !== undefined ? [bare.const] : []);
  return {
    name, title: given.title ?? "", basic: given["x-basic"] ?? "", kind: fields.length > 0 ? (inner === bare ? "object" : "list") : kindOf(bare, choices), needed, nullable: some.length < options.length,
    help: help.toLowerCase() === given.title?.toLowerCase() ? "" : help, fallback: given.default ?? whole.default ?? null, choices: choices.map(String),
    least: bare.minimum ?? null, most: bare.maximum ?? null, above: bare.exclusiveMinimum ?? null, below: bare.exclusiveMaximum ?? null,
    longest: bare.maxLength ?? null, pattern: bare.pattern ?? "", fields,
  };
}

function kindOf(schema: Schema, choices: unknown[]): FieldKind {
  if (choices.length > 0) return choices.every((one) => typeof one === "string" || typeof one === "number") ? "choice" : "json";
  switch (schema.type) {
    case "string": return "text";
    case "number": return "number";
    case "integer": return "integer";
    case "boolean": return "flag";
    default: return "json";
  }
}

/** What a person typed as the value of a field; undefined leaves it out, and what cannot be read stays as it was typed. */
export function read(field: FieldOf, typed: string): unknown {
  const text = typed.trim();
  if (field.kind === "text") return typed;
  if (text === "") return field.nullable && field.needed ? null : undefined;
  if (field.kind === "number" || field.kind === "integer") {
    const value = Number(text.replace(",", "."));
    return Number.isFinite(value) ? value : typed;
  }
  if (field.kind === "choice") return field.choices.includes(text) && /^-?\d+(\.\d+)?$/.test(text) && !Number.isNaN(Number(text)) ? Number(text) : text;
  try {
    return JSON.parse(text);
  } catch {
    return typed;
  }
}

/** A value as a person types it. */
export function shown(field: FieldOf, value: unknown): string {
  if (value === undefined || value === null) return "";
  return (field.kind === "json" || field.kind === "list") && typeof value !== "string" ? JSON.stringify(value) : String(value);
}

/** What is wrong with a value as far as its schema says; null if nothing is. */
export function wrong(field: FieldOf, value: unknown): Problem | null {
  if (value === undefined || value === null || value === "") return field.needed && !field.nullable && !(field.kind === "text" && value === "") ? { key: "form.needed" } : null;
  if (field.kind === "json" && typeof value === "string" && /^\s*[[{]/.test(value)) return { key: "form.json" };
  if (field.kind === "text") return field.longest !== null && String(value).length > field.longest ? { key: "form.longest", value: field.longest } : null;
  if (field.kind !== "number" && field.kind !== "integer") return null;
  if (typeof value !== "number") return { key: "form.number" };
  if (field.kind === "integer" && !Number.isInteger(value)) return { key: "form.whole" };
  if (field.least !== null && value < field.least) return { key: "form.least", value: field.least };
  if (field.most !== null && value > field.most) return { key: "form.most", value: field.most };
  if (field.above !== null && value <= field.above) return { key: "form.above", value: field.above };
  if (field.below !== null && value >= field.below) return { key: "form.below", value: field.below };
  return null;
}

/** The paths of all fields with something wrong, such as `settings.max_power`. */
export function problems(fields: FieldOf[], value: Record<string, unknown>, path = ""): Map<string, Problem> {
  const found = new Map<string, Problem>();
  for (const field of fields) {
    const at = path + field.name, one = value[field.name];
    if (field.kind === "object") {
      for (const [key, problem] of problems(field.fields, (one ?? {}) as Record<string, unknown>, `${at}.`)) if (one !== undefined || problem.key !== "form.needed") found.set(key, problem);
      continue;
    }
    if (field.kind === "list" && Array.isArray(one)) {
      one.forEach((each, number) => problems(field.fields, (each ?? {}) as Record<string, unknown>, `${at}.${number}.`).forEach((problem, key) => found.set(key, problem)));
      continue;
    }
    const problem = wrong(field, one);
    if (problem) found.set(at, problem);
  }
  return found;
}

/** What `now` says otherwise than `before`, also within settings: what another has written meanwhile. */
export function writtenSince(before: Record<string, unknown>, now: Record<string, unknown>): Record<string, unknown> {
  const struct = (one: unknown): one is Record<string, unknown> => typeof one === "object" && one !== null && !Array.isArray(one);
  return Object.fromEntries(Object.entries(now).filter(([name, value]) => !same(before[name], value)).map(([name, value]) => [name, struct(value) ? writtenSince(struct(before[name]) ? before[name] : {}, value) : value]));
}

/** What another has written, with my changes laid upon it; within settings only what I changed is mine. */
export function kept(there: Record<string, unknown>, before: Record<string, unknown>, mine: Record<string, unknown>): Record<string, unknown> {
  const settings = mine["settings"];
  if (typeof settings !== "object" || settings === null || Array.isArray(settings)) return { ...there, ...mine };
  const was = (before["settings"] ?? {}) as Record<string, unknown>;
  const now: Record<string, unknown> = { ...((there["settings"] ?? {}) as Record<string, unknown>) };
  for (const name of new Set([...Object.keys(was), ...Object.keys(settings)])) {
    const wanted = (settings as Record<string, unknown>)[name];
    if (same(was[name], wanted)) continue;
    if (wanted === undefined) delete now[name];
    else now[name] = wanted;
  }
  return { ...there, ...mine, settings: now };
}

export const same = (one: unknown, other: unknown): boolean => JSON.stringify(one) === JSON.stringify(other);

/** The columns that are another than before; of a new row, all that are said. */
export function changes(before: Record<string, unknown> | null, now: Record<string, unknown>): Record<string, unknown> {
  return Object.fromEntries(Object.entries(now).filter(([name, value]) => value !== undefined && (before === null || !same(before[name], value))));
}
