// Dragging a limb: which angle of its joint brings the point that is held nearest to the pointer on the screen.
import type { Vec } from "./model";
import { about, rotated } from "./pose";

export type Screen = [number, number];
export interface Held {
  /** The joint's axis and a point on it, and the point that is held, in the world as the joint stands at `angle`. */
  axis: Vec; centre: Vec; point: Vec; angle: number; lower: number; upper: number;
  /** Whether it slides along its axis rather than turns about it. */
  slides?: boolean;
}

/** One step of the pointer turns a joint no further than this, so that it never jumps to the other side of its circle. */
const FURTHEST_RAD = 0.6;
const STEPS = 24;

export function moved({ axis, centre, point, angle, slides }: Held, to: number): Vec {
  const turn = to - angle;
  if (slides) return [point[0] + axis[0] * turn, point[1] + axis[1] * turn, point[2] + axis[2] * turn];
  const [x, y, z] = rotated(about(axis, turn), [point[0] - centre[0], point[1] - centre[1], point[2] - centre[2]]);
  return [centre[0] + x, centre[1] + y, centre[2] + z];
}

/** The angle, from `from` on, that brings the held point nearest to the pointer; within the joint's limits. */
export function draggedTo(held: Held, from: number, pointer: Screen, project: (at: Vec) => Screen): number {
  const [low, high] = [Math.max(held.lower, from - FURTHEST_RAD), Math.min(held.upper, from + FURTHEST_RAD)];
  if (!(low < high)) return Math.min(held.upper, Math.max(held.lower, from));
  const off = (angle: number): number => {
    const [x, y] = project(moved(held, angle));
    return (x - pointer[0]) ** 2 + (y - pointer[1]) ** 2;
  };
  let best = from < low ? low : from > high ? high : from;
  let least = off(best);
  const step = (high - low) / STEPS;
  for (let at = 0; at <= STEPS; at++) {
    const angle = low + at * step;
    const value = off(angle);
    if (value < least - 1e-9) [best, least] = [angle, value];
  }
  let [a, b] = [Math.max(low, best - step), Math.min(high, best + step)];
  for (let round = 0; round < 24; round++) {
    const [left, right] = [a + (b - a) / 3, b - (b - a) / 3];
    if (off(left) <= off(right)) b = right;
    else a = left;
  }
  return (a + b) / 2;
}
