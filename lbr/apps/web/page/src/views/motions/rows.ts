// A motion's rows, all changed together: it gets another name, or goes.
import { changeAll, table, type RowChange } from "../system/manage";

const OF = { motion: "name", motion_step: "motion" } as const;

/** Renames a motion with its key frames, or deletes it (`to` is null); true once it is done. */
export async function move(name: string, to: string | null): Promise<boolean> {
  const changes: RowChange[] = [];
  for (const [of, column] of Object.entries(OF)) {
    const answer = await table(of);
    if (!answer.ok || !answer.data) return false;
    const own = answer.data.data.rows.filter((row) => row[column] === name);
    for (const before of own) {
      changes.push({ table: of, before, after: null });
      if (to !== null) changes.push({ table: of, before: null, after: { ...before, [column]: to } });
    }
  }
  return (await changeAll(changes, true)).ok;
}
