// From a stick to what the base is told. Pure. x is to the right, y is ahead, both within -1 to 1.
export interface Aim {
  power: number;
  angle_deg: number;
}

/** Of a stick's way: less is rest, so that a thumb that only lies there moves nothing. */
export const DEAD = 0.12;
/** So near to an axis the stick means the axis: straight ahead is hard to hit with a thumb. */
export const SNAP_DEG = 9;
/** Fine near the centre: the power grows with this power of the way. */
export const CURVE = 1.6;

/** What the base is told, or null at rest. `top` is the most power that is given. Not a number means rest. */
export function aim(x: number, y: number, top = 1): Aim | null {
  const way = Math.hypot(x, y);
  if (!Number.isFinite(way) || !Number.isFinite(top) || way < DEAD || top <= 0) return null;
  const reach = (Math.min(1, way) - DEAD) / (1 - DEAD);
  const power = Math.round(Math.max(0.02, reach ** CURVE * Math.min(1, top)) * 100) / 100;
  return { power, angle_deg: snapped((Math.atan2(x, y) * 180) / Math.PI) };
}

function snapped(angle: number): number {
  const round = (angle + 360) % 360;
  const axis = (Math.round(round / 90) * 90) % 360;
  const off = Math.abs(((round - axis + 540) % 360) - 180);
  return off <= SNAP_DEG ? axis : Math.round(round);
}

/** The stick that keys stand for: opposite keys cancel one another. */
export function ofKeys(keys: { has(key: string): boolean }): { x: number; y: number } {
  const held = (...names: string[]): number => (names.some((name) => keys.has(name)) ? 1 : 0);
  const x = held("ArrowRight", "KeyD") - held("ArrowLeft", "KeyA");
  const y = held("ArrowUp", "KeyW") - held("ArrowDown", "KeyS");
  const way = Math.hypot(x, y) || 1;
  return { x: x / way, y: y / way };
}

/** Whether two aims are so alike that nothing needs to be told. */
export const alike = (one: Aim | null, other: Aim | null): boolean =>
  one === other || (one !== null && other !== null && one.power === other.power && one.angle_deg === other.angle_deg);
