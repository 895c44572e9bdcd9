// A robot that lies: shown above every view, with what brings it back to its feet.
import { useRef } from "preact/hooks";
import { holding } from "./holding";
import { useStream } from "./live";
import { Button, Icon } from "./parts";
import { command, may, robot, streamOfType } from "./robot";
import { estop } from "./stopping";
import { t } from "./words";

interface Lying { playing: boolean; motion?: string; fallen?: "" | "face" | "back" | "side" }

export function Fallen() {
  const stream = streamOfType("MotionsState");
  const state = useStream<Lying>(stream)?.message;
  const tried = useRef(false);
  const lies = state?.fallen;
  if (!lies) tried.current = false;
  if (!lies) return null;
  const motion = `get_up_${lies}`;
  const gets = may("operate") && (robot.value?.motions.some((one) => one["name"] === motion) ?? false);
  const rises = state.playing && state.motion?.startsWith("get_up_");
  if (rises) tried.current = true;
  const world = robot.value?.capabilities.find((one) => one.commands["pick_up"] && may(one.commands["pick_up"].role));
  return (
    <div class="alarm alarm-stop" role="alert">
      <Icon name="warn" />
      <p><strong>{t(rises ? "fallen.rises" : `fallen.${lies}`)}</strong>{tried.current && !rises && t("fallen.not")}</p>
      {gets && !rises && <Button icon="play" disabled={estop.value.engaged || state.playing} onClick={() => holding.play(`${stream.split("/")[0]}/play`, { motion, times: 1 })}>{t("fallen.up")}</Button>}
      {world && !rises && <Button icon="person" onClick={() => void command(world.name, "pick_up", {})}>{t("fallen.pick")}</Button>}
    </div>
  );
}
