// Changes of rows that this page has made, and their way back.
import { signal } from "@preact/signals";
import { notice } from "../../notices";
import { t } from "../../words";
import { changeAll, type Row, type RowChange } from "./manage";

export interface Made { name: string; changes: RowChange[] }
/** What was saved here since the page was opened, the newest last. */
export const made = signal<Made[]>([]);

/** The change that takes one back, of the columns that it changed alone. `key` names the row's columns that never change. Pure. */
export function inverse({ table, before, after }: RowChange, key: string[]): RowChange {
  if (before === null || after === null) return { table, before: after, after: before };
  const names = [...new Set([...key, ...Object.keys(after)])];
  const only = (row: Row): Row => Object.fromEntries(names.filter((name) => row[name] !== undefined).map((name) => [name, row[name]]));
  return { table, before: only({ ...before, ...after }), after: only(before) };
}

export const noteMade = (name: string, changes: RowChange[], keys: string[][]): void => {
  made.value = [...made.value, { name, changes: changes.map((one, at) => inverse(one, keys[at] ?? [])).reverse() }];
};

/** Takes the newest change back; whatever another has changed since in these columns keeps it from that. */
export async function undo(): Promise<boolean> {
  const newest = made.value.at(-1);
  if (!newest) return false;
  const answer = await changeAll(newest.changes, true);
  if (answer.status !== 0) made.value = made.value.filter((one) => one !== newest); // one that did not arrive can be said again
  if (answer.ok) notice(t("rows.undone", { name: newest.name }), "good");
  return answer.ok;
}
