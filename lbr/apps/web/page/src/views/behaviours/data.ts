// Behaviours as the robot tells of them: its tables and what is wrong in them, their rows, and the run.
import { nameLetters } from "../../format";
import { capabilities, fetchJson } from "../../robot";
import type { Answer } from "../../access";
import type { CommandReply } from "../../messages";
import { rows as motions } from "../motions/data";
import { table as rowsOf, type Reply, type Row, type RowChange } from "../system/manage";

export interface Fault { step: number; line: number; column: string; text: string; error: boolean }
export interface Summary { name: string; help: string; rows: number; faults: Fault[] }
export interface Tables { tables: Summary[] }
export interface Unmet { column: string; condition: string; seen: number | string | null; by: number | null; text: string }
export interface RowView { step: number; next_state: string; unmet: Unmet[] }
export interface Run {
  phase: "resting" | "running" | "paused" | "ended"; table: string; state: string; called: string[]; doing: string; state_s: number; run_s: number;
  transitions: number; result: string; variables: Record<string, number | string>; rows: RowView[]; good: boolean | null; reason: string; code: string;
}
export type Cells = Record<string, string>;
export interface Step { behaviour: string; step: number; type: string; state: string; conditions: Cells; outputs: Cells; next_state: string; deadline_s: number | null }

export const TABLE = "behaviour", ROW = "behaviour_row";
export const TYPES = ["", "start", "end", "fail", "entry", "#"] as const;
export const OUTPUT = "O:";
export const COLUMNS = { type: "Type", state: "Current State", next: "Next State", deadline: "Deadline" } as const;
export const LARGEST = 45_000;
export const MOST_CHANGES = 256;

/** The rows of a table, in the order in which they are tried. */
export async function steps(name: string): Promise<Step[] | null> {
  const answer = await rowsOf(ROW);
  const found = answer.data?.data?.rows as unknown as Step[] | undefined;
  return answer.ok && found ? found.filter((one) => one.behaviour === name).sort((a, b) => a.step - b.step) : null;
}

export const write = (changes: RowChange[]): Promise<Answer<Reply<null>>> =>
  fetchJson("api/rows", { method: "POST", body: { changes, write: true }, quiet: true, timeoutMs: 12_000 });
export const changeOf = (before: Step | null, after: Step | null): RowChange => ({ table: ROW, before: before as Row | null, after: after as Row | null });

type Checked = CommandReply & { faults: Fault[]; rows: Step[] };
const ask = <T>(owner: string, name: string, body: unknown): Promise<Answer<T>> => fetchJson<T>(`api/${owner}/${name}`, { method: "POST", body, quiet: true });
export const check = (owner: string, name: string, rows: Step[]): Promise<Answer<Checked>> => ask(owner, "check", { name, rows });
export const read = (owner: string, name: string, file: string, content: string): Promise<Answer<Checked>> => ask(owner, "read", { name, file, content });
export const written = (owner: string, name: string, form: string): Promise<Answer<CommandReply & { content: string }>> => ask(owner, "write", { name, form });

/** What changes the rows that are there into others: all or none. */
export function exchange(old: Step[], next: Step[]): RowChange[] {
  const before = new Map(old.map((one) => [one.step, one]));
  const kept = next.map((one) => changeOf(before.get(one.step) ?? null, one)).filter((one) => JSON.stringify(one.before) !== JSON.stringify(one.after));
  const there = new Set(next.map((one) => one.step));
  return [...kept, ...old.filter((one) => !there.has(one.step)).map((one) => changeOf(one, null))];
}

/** The headings that a table's rows use, in their order. */
export const headings = (rows: Step[], which: "conditions" | "outputs"): string[] => [...new Set(rows.flatMap((row) => Object.keys(row[which])))];

/** What a person types as a table's name, in the letters that it may have. */
export const typed = (text: string): string => nameLetters(text).replace(/^[^a-z]+/, "").slice(0, 40);

/** A table's name, from what a person typed or a file is called. */
export const nameFrom = (text: string): string => typed(text.replace(/(\.states)?\.\w+$/, "")).replace(/_+$/, "") || "table";

/** What a new table begins with: the robot drives ahead for a moment, or waves, and is at its end. */
export const first = (behaviour: string): Step[] => {
  const moved = motions().find(({ name }) => name.includes("wave")) ?? motions()[0];
  const row = { behaviour, type: "", conditions: {}, outputs: {}, next_state: "", deadline_s: null };
  return [
    { ...row, step: 1, type: "start", state: "Begin", outputs: capabilities("drive").length > 0 ? { level: "0.3", range: "50" } : moved ? { motion: moved.name } : { wait: "1" }, next_state: "Done" },
    { ...row, step: 2, type: "end", state: "Done" },
    { ...row, step: 3, type: "fail", state: "Stuck" },
  ];
};
