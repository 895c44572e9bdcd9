// How a joint is, as colour, sign and words: never by colour alone.
import type { JointState } from "./model";

export type Tone = "near" | "moving" | "loaded" | "fault" | "hot" | "limp" | "unread" | "doubt" | "held";

/** Within 1.5 degrees, five steps of a small servo, a joint is where it is to be. */
export const NEAR_RAD = 0.026;
/** From here on a servo soon switches itself off. */
export const LOADED = 0.75;
export const HOT_C = 65;

/** The worst that holds of a joint. */
export function toneOf(joint: JointState | undefined): Tone {
  if (!joint) return "unread";
  if (joint.faults?.length || joint.latched?.length) return "fault";
  if (joint.position_rad == null) return "unread";
  if (Math.abs(joint.load ?? 0) >= LOADED) return "loaded";
  if ((joint.temperature_c ?? 0) >= HOT_C) return "hot";
  if (joint.torque === 0) return "limp";
  if (joint.torque == null) return "doubt";
  const goal = joint.target_rad ?? joint.goal_rad;
  if (goal == null) return "held";
  return Math.abs(goal - joint.position_rad) <= NEAR_RAD ? "near" : "moving";
}

export const BAD: ReadonlySet<Tone> = new Set<Tone>(["fault", "loaded"]);
export const BADGE: Record<Tone, "good" | "warn" | "bad" | "calm"> = {
  near: "good", held: "good", moving: "calm", loaded: "bad", fault: "bad", hot: "warn", limp: "calm", unread: "warn", doubt: "warn",
};

/** How many joints hold, are without torque, or are not known to have any: what is not known counts as neither. */
export function torques(names: readonly string[], joints: Readonly<Record<string, JointState>> | undefined): { held: number; limp: number; unknown: number } {
  const all = names.map((name) => joints?.[name]?.torque ?? null);
  const [limp, unknown] = [all.filter((one) => one === 0).length, all.filter((one) => one === null).length];
  return { held: all.length - limp - unknown, limp, unknown };
}
