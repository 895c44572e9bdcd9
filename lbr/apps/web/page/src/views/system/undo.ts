// Changes of rows that this page has made, and their way back, which the robot knows.
import { signal } from "@preact/signals";
import { notice } from "../../notices";
import { t } from "../../words";
import type { Answer } from "../../access";
import { takeBack, type Reply } from "./manage";

/** `said`: that it was made; `name`: what was changed. */
export interface Made { said: string; name: string; revision: number }
/** What was saved here since the page was opened, the newest last. */
export const made = signal<Made[]>([]);

export const noteMade = (said: string, name: string, answer: Answer<Reply<null>>): void => {
  if (answer.data?.revision) made.value = [...made.value, { said, name, revision: answer.data.revision }];
};

/** Takes the newest change back; whatever another has changed since in these columns keeps it from that. */
export async function undo(): Promise<boolean> {
  const newest = made.value.at(-1);
  if (!newest) return false;
  const answer = await takeBack(newest.revision);
  if (answer.status !== 0) made.value = made.value.filter((one) => one !== newest); // one that did not arrive can be said again
  if (answer.ok) notice(t("rows.undone", { name: newest.name }), "good");
  return answer.ok;
}
