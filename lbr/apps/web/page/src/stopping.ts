// Stopping: asked by requests of their own, which wait for nothing, whether the socket lives or not.
import { computed, signal } from "@preact/signals";
import { ask, told } from "./access";
import { holding } from "./holding";
import { status } from "./live";
import { notice, toldLately, withdraw } from "./notices";
import { t } from "./words";

const pressed = signal(false);
/** Whether a person is asked if the emergency stop shall be released. */
export const asksReset = signal(false);
const URGENT = { method: "POST", keepalive: true, quiet: true, timeoutMs: 5000 } as const;

/** The emergency stop as the robot tells it, or as it was just asked for. */
export const estop = computed(() => ({
  engaged: (status.value?.estop.engaged ?? false) || pressed.value,
  told: status.value?.estop.engaged ?? false,
  reason: status.value?.estop.reason ?? "",
  source: status.value?.estop.source ?? "",
  text: status.value?.estop.text ?? "",
}));

/** Stops the robot: wheels stand, joints hold, motions end. */
export async function stop(): Promise<void> {
  holding.release();
  let answer = await ask("stop", URGENT);
  if (!answer.ok && answer.status === 0) answer = await ask("stop", URGENT);
  if (answer.ok && !pressed.value) notice(t("stop.stopped"), "info");
  if (!answer.ok) notice(t("stop.failed", { reason: told(answer) }), "bad");
}

/** Whether a stop ended the motion, and a notice has just reported that stop. */
export const toldStop = (code = ""): boolean => code === "stopped" && toldLately(t("stop.stopped"));

/** Latches the emergency stop. */
export async function engage(): Promise<void> {
  holding.release();
  pressed.value = true;
  withdraw(t("stop.stopped"));
  let answer = await ask("estop", { ...URGENT, body: { reason: "pressed on the page" } });
  if (!answer.ok && answer.status === 0) answer = await ask("estop", { ...URGENT, body: {} });
  if (!answer.ok) notice(t("stop.failed", { reason: told(answer) }), "bad");
  setTimeout(() => { pressed.value = false; }, 3000);
}

/** Releases the emergency stop; moves nothing. */
export async function resetEstop(): Promise<void> {
  asksReset.value = false;
  const answer = await ask("estop/reset", { method: "POST" });
  if (!answer.ok) return;
  pressed.value = false;
  notice(t("stop.released"), "good");
}
