// What the robot can do, beside its body: a few motions by one press, and the one that is played.
import { useEffect, useMemo } from "preact/hooks";
import { holding } from "../../holding";
import { Button } from "../../parts";
import { may, robot, streamOfType } from "../../robot";
import { estop } from "../../stopping";
import { deedName, t } from "../../words";
import { deeds, endPlay, ends, isThere, loadEnds, Progress, rows, type MotionsState } from "../motions/data";
import { Playing } from "../motions/Playing";
import { ownerOf, useCalm } from "./hooks";

/** `said`: what stands beside it already; `at`: where the joints are. */
export function Deeds({ said, at }: { said: string; at: Record<string, number | null | undefined> }) {
  const stream = streamOfType("MotionsState");
  const owner = ownerOf(stream);
  const state = useCalm<MotionsState>(stream)?.message;
  const progress = useMemo(() => new Progress(), []);
  const offered = useMemo(() => deeds(rows()), [robot.value?.revision]);
  useEffect(() => void loadEnds(offered, String(robot.value?.revision ?? 0)), [offered]);
  if (!owner || offered.length === 0) return null;
  const there = (name: string): boolean => isThere(ends.value[name], at);
  const can = may("operate") && !estop.value.engaged && !state?.playing && !state?.fallen;
  return (
    <section class="joints-deeds" aria-label={t("joints.deeds")}>
      <Playing state={state} part={progress.part(state)} said={said} onStop={() => endPlay(owner)} />
      <div class="joints-deeds-all">
        {offered.map((one) => <Button key={one.name} icon={there(one.name) ? "check" : "play"} title={there(one.name) ? t("joints.deeds.there") : one.help} disabled={!can || there(one.name)} onClick={() => holding.play(`${owner}/play`, { motion: one.name, times: 1 })}>{deedName(one.name)}</Button>)}
        <a class="button button-quiet" href="#motions">{t("joints.deeds.all")}</a>
      </div>
    </section>
  );
}
