// Changes that are tried before they are written: what they would touch, or what is wrong with them.
import { useEffect, useRef, useState } from "preact/hooks";
import { told, type Answer } from "../../access";
import { plain } from "../../format";
import { link } from "../../live";
import { t } from "../../words";
import { changeAll, type Reply, type RowChange, type Touched } from "./manage";

const TRY_MS = 400;
/** What the robot said of the changes; `refused` where that is none of its problems with rows. */
export interface Trial { reply: Reply<null> | null; refused: string }
const NONE: Trial = { reply: null, refused: "" };
export const heard = (answer: Answer<Reply<null>>): Trial => ({ reply: answer.data, refused: answer.ok || (answer.data?.problems ?? []).length > 0 ? "" : told(answer) });

/** Tries changes whenever they are others, and again once a robot that was away is back; `made` says whether there are any to try. */
export function useTrial(changes: RowChange[], made: boolean): [Trial, (trial: Trial) => void] {
  const [trial, tell] = useState<Trial>(NONE);
  const [asked, again] = useState(0);
  const unheard = useRef(false);
  const there = link.value === "open";
  useEffect(() => {
    if (!there || !unheard.current) return;
    unheard.current = false;
    again(asked + 1);
  }, [there]);
  useEffect(() => {
    tell(NONE);
    if (!made) return;
    let over = false;
    const timer = setTimeout(() => void changeAll(changes, false, true).then((answer) => {
      if (over) return;
      unheard.current = answer.status === 0;
      tell(heard(answer));
    }), TRY_MS);
    return () => { over = true; clearTimeout(timer); };
  }, [JSON.stringify(changes), made, asked]);
  return [trial, tell];
}

/** What a change of rows starts, stops and restarts. */
export function effects(touched: Touched): string {
  const found = (["restart", "start", "stop", "plug"] as const).filter((what) => touched[what].length > 0);
  return found.map((what) => t(`rows.${what}`, { names: touched[what].map(plain).join(", ") })).join(" ") || t("rows.nothing");
}
