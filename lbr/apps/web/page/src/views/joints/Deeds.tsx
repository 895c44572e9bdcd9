// What the robot can do, beside its body: a few motions by one press, and the one that is played.
import { useMemo } from "preact/hooks";
import { holding } from "../../holding";
import { Button } from "../../parts";
import { command, may, robot, streamOfType } from "../../robot";
import { estop } from "../../stopping";
import { t } from "../../words";
import { deedName, deeds, Progress, rows, type MotionsState } from "../motions/data";
import { Playing } from "../motions/Playing";
import { ownerOf, useCalm } from "./hooks";

/** `said`: what stands beside it already. */
export function Deeds({ said }: { said: string }) {
  const stream = streamOfType("MotionsState");
  const owner = ownerOf(stream);
  const state = useCalm<MotionsState>(stream)?.message;
  const progress = useMemo(() => new Progress(), []);
  const offered = useMemo(() => deeds(rows()), [robot.value?.revision]);
  if (!owner || offered.length === 0) return null;
  const end = (): void => {
    holding.release();
    void command(owner, "stop", { reason: "from the page" }, { quiet: true });
  };
  const can = may("operate") && !estop.value.engaged && !state?.playing && !state?.fallen;
  return (
    <section class="joints-deeds" aria-label={t("joints.deeds")}>
      <Playing state={state} part={progress.part(state)} said={said} onStop={end} />
      <div class="joints-deeds-all">
        {offered.map((one) => <Button key={one.name} icon="play" title={one.help} disabled={!can} onClick={() => holding.play(`${owner}/play`, { motion: one.name, times: 1 })}>{deedName(one.name)}</Button>)}
        <a class="button button-quiet" href="#motions">{t("joints.deeds.all")}</a>
      </div>
    </section>
  );
}
