// Numbers as people read them; null, undefined and NaN are a dash.
export const NONE = "–";
type Maybe = number | null | undefined;

const known = (value: Maybe): value is number => typeof value === "number" && Number.isFinite(value);

/** The language of the page, of those it has. */
const isGerman = (language?: string): boolean => (language ?? (globalThis.document?.documentElement.lang || "en")).startsWith("de");

/** A number with so many digits after the point, by the page's language. The browser's own formats take 25 ms to begin with. */
export function number(value: Maybe, digits = 0, language?: string): string {
  if (!known(value)) return NONE;
  const [thousands, point] = isGerman(language) ? [".", ","] : [",", "."];
  const [whole, part] = Math.abs(value).toFixed(digits).split(".");
  const text = whole!.replace(/\B(?=(\d{3})+$)/g, thousands) + (part ? point + part : "");
  return value < 0 && /[1-9]/.test(text) ? `-${text}` : text;
}

/** A number at an axis whose lines are so far apart: with as many digits as tell it from its neighbours. */
export function tickText(value: Maybe, apart: number, language?: string): string {
  let digits = 0;
  while (digits < 12 && Math.abs(apart * 10 ** digits - Math.round(apart * 10 ** digits)) > 1e-6) digits++;
  return number(value, digits, language);
}

export const metres = (value: Maybe): string =>
  known(value) ? (Math.abs(value) < 1 ? `${number(value * 100)} cm` : `${number(value, value < 10 ? 2 : 1)} m`) : NONE;
export const degrees = (radians: Maybe, digits = 0): string => (known(radians) ? `${number((radians * 180) / Math.PI, digits)}°` : NONE);
export const percent = (part: Maybe): string => (known(part) ? `${number(part * 100)} %` : NONE);

/** How old something is: 0.2 s, 12 s, 3 min, 2 h. */
export function age(ms: Maybe): string {
  if (!known(ms)) return NONE;
  const s = Math.max(0, ms) / 1000;
  if (s < 10) return `${number(s, 1)} s`;
  if (s < 100) return `${number(s)} s`;
  if (s < 6000) return `${number(s / 60)} min`;
  return s < 172_800 ? `${number(s / 3600)} h` : `${number(s / 86_400)} d`;
}

/** A compass heading within 0 to 360. */
export const heading = (value: number): number => ((value % 360) + 360) % 360;

/** The shorter way from one heading to another, clockwise positive, within -180 to 180. */
export const between = (from: number, to: number): number => heading(to - from + 180) - 180;

const WINDS = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"] as const;
/** The wind that a heading looks to, by the page's language: east is O in German. */
export function wind(value: number, language?: string): string {
  const name = WINDS[Math.round(heading(value) / 45) % 8]!;
  return isGerman(language) ? name.replace("E", "O") : name;
}

/** A name of a row as people read it: left_shoulder_roll is "left shoulder roll". */
export const plain = (name: string): string => name.replaceAll("_", " ");

/** The letters that a row's name may have, of any text: "Ça va!" is "ca_va_". */
export const nameLetters = (text: string): string => text.normalize("NFKD").replace(/\p{M}+/gu, "").toLowerCase().replace(/[^a-z0-9_]+/g, "_");

/** The time of day of a wall clock in nanoseconds. */
export const timeOfDay = (wallNs: number): string =>
  wallNs > 0 ? new Date(wallNs / 1e6).toLocaleTimeString(globalThis.document?.documentElement.lang || "en", { hourCycle: "h23" }) : NONE;
