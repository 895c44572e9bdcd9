// From a stick to what the base is told. Pure. x is to the right, y is ahead, turn is clockwise, all within -1 to 1.
export interface Aim { power: number; angle_deg: number }
export interface Twist { vx_mps: number; vy_mps: number; wz_rps: number }
export interface Push { x: number; y: number; turn: number }
/** The greatest speeds of a base. */
export interface Most { max_speed_mps: number; max_turn_rps: number }

/** Of a stick's way: less is rest, so that a thumb that only lies there moves nothing. */
export const DEAD = 0.12;
/** So near to an axis the stick means the axis: straight ahead is hard to hit with a thumb. */
export const SNAP_DEG = 9;
/** Fine near the centre: the power grows with this power of the way. */
export const CURVE = 1.6;

/** How much of what is possible a way of the stick means; 0 at rest, for what is no number, and where nothing is given. */
function share(way: number, top: number): number {
  if (!Number.isFinite(way) || !Number.isFinite(top) || way < DEAD || top <= 0) return 0;
  return ((Math.min(1, way) - DEAD) / (1 - DEAD)) ** CURVE * Math.min(1, top);
}

/** Whether a way of the stick means motion at all. */
const moves = (way: number, top: number): boolean => Number.isFinite(way) && Number.isFinite(top) && way >= DEAD && top > 0;

/** What the base is told, or null at rest. `top` is the most power that is given. Not a number means rest. */
export function aim(x: number, y: number, top = 1): Aim | null {
  const way = Math.hypot(x, y);
  if (!moves(way, top)) return null;
  const power = Math.round(Math.max(0.02, share(way, top)) * 100) / 100;
  return { power, angle_deg: snapped((Math.atan2(x, y) * 180) / Math.PI) };
}

/** The same for a base that goes sideways and turns meanwhile (REP 103: ahead, to the left, anticlockwise). */
export function twist({ x, y, turn }: Push, most: Most, top = 1): Twist | null {
  if (![x, y, turn].every(Number.isFinite)) return null;
  const way = Math.hypot(x, y);
  const turns = Math.abs(turn);
  if (!moves(way, top) && !moves(turns, top)) return null;
  const speed = (moves(way, top) ? Math.max(0.02, share(way, top)) : 0) * most.max_speed_mps;
  const angle = (snapped((Math.atan2(x, y) * 180) / Math.PI) * Math.PI) / 180;
  const rate = (moves(turns, top) ? Math.max(0.02, share(turns, top)) : 0) * most.max_turn_rps;
  return { vx_mps: neat(speed * Math.cos(angle)), vy_mps: neat(-speed * Math.sin(angle)), wz_rps: neat(-Math.sign(turn) * rate) };
}

const neat = (value: number): number => Math.round(value * 1000) / 1000 || 0;

function snapped(angle: number): number {
  const round = (angle + 360) % 360;
  const axis = (Math.round(round / 90) * 90) % 360;
  const off = Math.abs(((round - axis + 540) % 360) - 180);
  return off <= SNAP_DEG ? axis : Math.round(round);
}

/** The stick that keys stand for: opposite keys cancel one another. Q and E turn a base that goes sideways. */
export function ofKeys(keys: { has(key: string): boolean }): Push {
  const held = (...names: string[]): number => (names.some((name) => keys.has(name)) ? 1 : 0);
  const x = held("ArrowRight", "KeyD") - held("ArrowLeft", "KeyA");
  const y = held("ArrowUp", "KeyW") - held("ArrowDown", "KeyS");
  const way = Math.hypot(x, y) || 1;
  return { x: x / way, y: y / way, turn: held("KeyE") - held("KeyQ") };
}

/** What several hands mean together: the strongest of the sticks, and the strongest of the turns. */
export function together(pushes: Iterable<Push>): Push {
  const found = { x: 0, y: 0, turn: 0 };
  for (const { x, y, turn } of pushes) {
    if (![x, y, turn].every(Number.isFinite)) return { x: 0, y: 0, turn: 0 };
    if (Math.hypot(x, y) > Math.hypot(found.x, found.y)) [found.x, found.y] = [x, y];
    if (Math.abs(turn) > Math.abs(found.turn)) found.turn = turn;
  }
  return found;
}

/** Whether two wishes are so alike that nothing needs to be told. */
export const alike = (one: object | null, other: object | null): boolean => JSON.stringify(one) === JSON.stringify(other);
