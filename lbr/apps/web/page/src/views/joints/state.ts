// What the page reads out of the joints' state.
import type { JointsState } from "./model";
import { toneOf, type Tone } from "./tone";

export function positions(state: JointsState): Record<string, number | null | undefined> {
  return Object.fromEntries(Object.entries(state.joints).map(([name, joint]) => [name, joint.position_rad]));
}

/** To where joints are on their way: what this page asks of them, else what the robot says. */
export function goals(state: JointsState, asked: Record<string, number>): Record<string, number | null | undefined> {
  const told = Object.entries(state.joints).map(([name, joint]) => [name, joint.torque === 0 ? null : joint.target_rad ?? null] as const);
  return { ...Object.fromEntries(told), ...asked };
}

export function tones(state: JointsState): Record<string, Tone> {
  return Object.fromEntries(Object.entries(state.joints).map(([name, joint]) => [name, toneOf(joint)]));
}
