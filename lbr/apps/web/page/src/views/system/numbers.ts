// The numbers within a message, each by its path. Pure.
const DEEPEST = 4;
const MOST = 200;

/** All numbers of a message by path, such as `left_m` or `loop.rate_hz` or `joints.neck.position_rad`. */
export function numbers(message: unknown): Map<string, number> {
  const found = new Map<string, number>();
  walk(message, "", 0, found);
  return found;
}

function walk(value: unknown, path: string, depth: number, found: Map<string, number>): void {
  if (found.size >= MOST) return;
  if (typeof value === "number") found.set(path, value);
  else if (typeof value === "boolean") found.set(path, value ? 1 : 0);
  else if (value !== null && typeof value === "object" && depth < DEEPEST) {
    for (const [name, inner] of Object.entries(value)) walk(inner, path ? `${path}.${name}` : name, depth + 1, found);
  }
}

/** A table of time and numbers as CSV. */
export function csv(names: string[], rows: { s: number; values: (number | null)[] }[]): string {
  const quoted = (text: string): string => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const lines = rows.map((row) => [row.s.toFixed(3), ...row.values.map((value) => (value === null ? "" : String(value)))].join(","));
  return [["seconds", ...names].map(quoted).join(","), ...lines].join("\n") + "\n";
}
