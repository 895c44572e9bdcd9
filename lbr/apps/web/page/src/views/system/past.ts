// What owners look at over time: which numbers, of which streams, out of the black box. Pure but for the questions to the box.
import type { Answer } from "../../access";
import type { CommandReply } from "../../messages";
import { capabilities, command, robot, streamsOfType } from "../../robot";
import type { WordKey } from "../../words";

export interface Past { at_ms: number[]; values: Record<string, (number | null)[]> }
/** A chart: one number out of one or several fields, in a unit. */
export interface Quantity { key: string; word: WordKey; unit: string; digits: number; fields: string[]; of: (values: number[]) => number; colour: string }

const least = (values: number[]): number => Math.min(...values);
const most = (values: number[]): number => Math.max(...values);
const SIDES = ["forward_m", "back_m", "left_m", "right_m"];

/** The quantities that this robot publishes. */
export function quantities(): Quantity[] {
  const of = (type: string, ...names: string[]): string[] => streamsOfType(type).flatMap((key) => names.map((name) => `${key}.${name}`));
  const joints = streamsOfType("JointsState").flatMap((key) => (robot.value?.joints ?? []).map((one) => `${key}.joints.${String(one["name"])}.temperature_c`));
  const all: Quantity[] = [
    { key: "battery", word: "past.battery", unit: "V", digits: 2, fields: [...of("BatteryState", "voltage_v"), ...of("UpsState", "external_v")].slice(0, 1), of: least, colour: "--accent" },
    { key: "speed", word: "past.speed", unit: "m/s", digits: 2, fields: of("OdometryState", "speed_mps").slice(0, 1), of: most, colour: "--good" },
    { key: "nearest", word: "past.nearest", unit: "m", digits: 2, fields: of("Ranges", ...SIDES).slice(0, 4), of: least, colour: "--warn" },
    { key: "current", word: "past.current", unit: "A", digits: 2, fields: of("BatteryState", "current_a").slice(0, 1), of: most, colour: "--ink" },
    { key: "hottest", word: "past.hottest", unit: "°C", digits: 0, fields: [...joints.slice(0, 26), ...of("UpsState", "temperature_c")], of: most, colour: "--bad" },
  ];
  return all.filter((one) => one.fields.length > 0);
}

/** One number for each time: of the fields that had one. */
export const drawn = (of: Quantity, past: Past): (number | null)[] => past.at_ms.map((_, at) => {
  const values = of.fields.flatMap((field) => past.values[field]?.[at] ?? []);
  return values.length > 0 ? of.of(values) : null;
});

/** What is known, and what came after it; without what is over. */
export function joined(known: Past, more: Past, fromMs: number): Past {
  const last = known.at_ms.at(-1) ?? 0;
  const at_ms = [...known.at_ms, ...more.at_ms.filter((ms) => ms > last)];
  const first = more.at_ms.findIndex((ms) => ms > last);
  const over = at_ms.findIndex((ms) => ms >= fromMs);
  const cut = over < 0 ? at_ms.length : over;
  const names = [...new Set([...Object.keys(known.values), ...Object.keys(more.values)])];
  const part = (of: Past, name: string): (number | null)[] => of.values[name] ?? of.at_ms.map(() => null);
  return { at_ms: at_ms.slice(cut), values: Object.fromEntries(names.map((name) => [name, [...part(known, name), ...(first < 0 ? [] : part(more, name).slice(first))].slice(cut)])) };
}

/** A table of all that is drawn: the time, and a column for each quantity. */
export function table(of: Quantity[], past: Past): string {
  const columns = of.map((one) => drawn(one, past));
  const lines = past.at_ms.map((ms, at) => [new Date(ms).toISOString(), ...columns.map((values) => values[at] ?? "")].join(","));
  return [["time", ...of.map((one) => `${one.key} (${one.unit})`)].join(","), ...lines].join("\n") + "\n";
}

export const box = (): string => capabilities("box").find((one) => one.commands["history"])?.name ?? "";
const NS_PER_MS = 1_000_000;
/** What is more than a number of JavaScript holds exactly is rounded to the microsecond, which is finer than a chart. */
const ns = (ms: number): number => Math.round(ms) * NS_PER_MS;

export const history = (fields: string[], fromMs: number, toMs: number, points: number): Promise<Answer<CommandReply & Past>> =>
  command(box(), "history", { fields, from_ns: ns(fromMs), to_ns: ns(toMs), points }, { quiet: true, timeoutMs: 12_000 }) as Promise<Answer<CommandReply & Past>>;
export interface Then extends CommandReply { state: string; text: string; late_s: number }
export const explained = (ms: number): Promise<Answer<Then>> => command(box(), "then", { at_ns: ns(ms) }, { timeoutMs: 12_000 }) as Promise<Answer<Then>>;
