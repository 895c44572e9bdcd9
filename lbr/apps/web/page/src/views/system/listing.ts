// Events that were written down and those heard since, as one list. Pure.
import type { Event } from "../../messages";

export type Level = "info" | "warning" | "error";
const LEVELS: Level[] = ["info", "warning", "error"];
export interface Listed { key: string; event: Event }

/** Whether an event is of a part, and of a level or above. */
export const matches = (event: Event, subject: string, level: Level): boolean =>
  (subject === "" || event.subject === subject) && LEVELS.indexOf(event.level ?? "info") >= LEVELS.indexOf(level);

/** Both lists as one, the newest first, each event once; what is heard knows more of it than what is written. */
export function merged(heard: Event[], written: Event[], most: number): Listed[] {
  const found = new Map<string, Listed>();
  for (const event of [...heard, ...written]) {
    const key = `${event.wall_ns ?? 0} ${event.kind} ${event.subject} ${event.text}`;
    if (!found.has(key)) found.set(key, { key, event });
  }
  return [...found.values()].sort((one, other) => (other.event.wall_ns ?? 0) - (one.event.wall_ns ?? 0)).slice(0, most);
}

/** The day of an event as people say it; nothing for today. */
export function dayOf(wallNs: number, now: Date, language: string): string {
  const then = new Date(wallNs / 1e6);
  return wallNs <= 0 || then.toDateString() === now.toDateString() ? "" : then.toLocaleDateString(language, { weekday: "short", day: "numeric", month: "short" });
}
