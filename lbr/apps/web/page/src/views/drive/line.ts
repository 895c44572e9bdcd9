// Which of all that may be shown comes first: what goes on, then what this hand was refused, then rest.
import type { Holding } from "../../holding";
import type { DriveState } from "../../messages";

export type First = "limited" | "mine" | "other" | "ended" | "rest";

/** What a status line is about; `again`: this hand has to come to rest before it moves again. */
export function first(hand: Pick<Holding, "moving" | "holds" | "code">, drive: Pick<DriveState, "moving" | "limited_by"> | null, again: boolean): First {
  if (drive?.limited_by) return "limited";
  if (hand.moving && hand.holds) return "mine";
  const over = hand.code !== "" && hand.code !== "done" && !hand.holds;
  if (over && hand.code === "held") return "ended";
  if (drive?.moving && !again) return "other";
  return over || again ? "ended" : drive?.moving ? "other" : "rest";
}
