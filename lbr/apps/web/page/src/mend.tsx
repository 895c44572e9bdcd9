// The button that mends a refusal, beside the sentence that tells it; by its code.
import { askFor } from "./handover";
import { holding } from "./holding";
import { mends, unwell } from "./lacking";
import { Button, type IconName } from "./parts";
import { able, command, may, robot } from "./robot";
import { asksReset } from "./stopping";
import type { WordKey } from "./words";
import { t } from "./words";

interface Way { text: WordKey; icon: IconName; go: () => void; pressed?: boolean }

const lends = (name: string): boolean => robot.value?.capabilities.some((one) => one.name === name && Object.values(one.commands).some(({ leased }) => leased)) ?? false;

/** A button that has every capability with a command carry it out; none without such a capability. */
const all = (name: string, message: object, text: WordKey, icon: IconName): Way[] =>
  able(name).length > 0 ? [{ text, icon, go: () => able(name).forEach((owner) => void command(owner, name, message)) }] : [];

const taken = (about: string): Way[] => !lends(about) ? [] : [{ text: "drive.takeover", icon: "drive", pressed: holding.takesOver.value, go: holding.takeOver }];
const held = (about: string): Way[] => !lends(about) ? [] : [{ text: "hand.ask", icon: "person", go: () => void askFor(about) }, ...taken(about)];

/** What is missing keeps it from that: the list of it says where to begin. */
const lacks = (): Way[] => unwell.value.length === 0 ? [] : [{ text: "lacking.title", icon: "warn", go: () => { mends.value = true; } }];

const WAYS: Record<string, (about: string) => Way[]> = {
  no_torque: () => all("torque", { on: true }, "mend.on", "bolt"),
  latched: () => all("recover", {}, "joints.recover", "restart"),
  estop: () => [{ text: "stop.reset", icon: "stop", go: () => { asksReset.value = true; } }],
  held,
  held_by_part: taken,
  foreign_lease: held,
  unwell: lacks,
  not_armed: lacks,
  no_setpoint: lacks,
  not_ready: lacks,
  unreachable: lacks,
};

/** Whether a refusal of this code, of that capability, has a button. */
export const mendable = (code: string, about = ""): boolean => may("operate") && (WAYS[code]?.(about).length ?? 0) > 0;

export function Mend({ code, about = "", onDone }: { code: string; about?: string; onDone?: () => void }) {
  if (!mendable(code, about)) return null;
  return <>{WAYS[code]!(about).map((way) => <Button key={way.text} icon={way.icon} pressed={way.pressed} onClick={() => { way.go(); onDone?.(); }}>{t(way.text)}</Button>)}</>;
}
