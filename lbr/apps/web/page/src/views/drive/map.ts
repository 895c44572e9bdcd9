// A map of where the base was and what it measured there: cells of five centimetres, by odometry alone. Pure.
import { placed, type Point, type Pose } from "./geometry";

export const CELL_M = 0.05;
const MOST_CELLS = 30_000;
const MOST_STEPS = 4000;
const STEP_M = 0.04;
/** A base that moved by less is where it was. */
const MOVED_M = 0.005;
const TURNED_RAD = 0.003;
/** Seen so often, a cell is as dark as it gets. */
export const SURE = 7;

/** What of the map is shown: so many dots a metre, round a place; null follows the base and shows all. */
export interface Sight extends Point { scale: number }
const LEAST_SCALE = 4;
const MOST_SCALE = 400;

/** A sight nearer or further by a factor, the place under `at` (metres from its middle) staying where it is. */
export function zoomed(sight: Sight, factor: number, at: Point = { x: 0, y: 0 }): Sight {
  const scale = Math.min(MOST_SCALE, Math.max(LEAST_SCALE, sight.scale * (Number.isFinite(factor) && factor > 0 ? factor : 1)));
  const rest = 1 - sight.scale / scale;
  return { scale, x: sight.x + at.x * rest, y: sight.y + at.y * rest };
}

export class WorldMap {
  /** What the newest scan saw, in the world's frame. */
  seen: Point[] = [];
  readonly cells = new Map<string, { x: number; y: number; count: number }>();
  readonly trail: Point[] = [];
  pose: Pose | null = null;
  /** Counts what is seen to change. */
  changes = 0;
  private epoch = "";

  /** Notes where the base is. Another epoch of the odometry begins another map. */
  move(pose: Pose, epoch: string): void {
    if (epoch !== this.epoch) this.clear();
    this.epoch = epoch;
    const now = this.pose;
    if (now && Math.hypot(now.x - pose.x, now.y - pose.y) < MOVED_M && Math.abs(now.yaw - pose.yaw) < TURNED_RAD) return;
    this.pose = pose;
    this.changes += 1;
    const last = this.trail.at(-1);
    if (last && Math.hypot(last.x - pose.x, last.y - pose.y) < STEP_M) return;
    this.trail.push({ x: pose.x, y: pose.y });
    if (this.trail.length > MOST_STEPS) this.trail.shift();
  }

  /** Notes what was seen from where the base is now; a scan is shown as it is, besides. */
  see(points: Point[], scan = false): void {
    const pose = this.pose;
    if (!pose) return;
    const all = points.map((point) => placed(pose, point));
    if (scan) {
      this.seen = all;
      this.changes += 1;
    }
    for (const { x, y } of all) {
      const [column, row] = [Math.round(x / CELL_M), Math.round(y / CELL_M)];
      const key = `${column},${row}`;
      const cell = this.cells.get(key) ?? { x: column * CELL_M, y: row * CELL_M, count: 0 };
      if (cell.count >= SURE) continue;
      cell.count += 1;
      this.cells.set(key, cell);
      this.changes += 1;
    }
    for (const key of this.cells.keys()) {
      if (this.cells.size <= MOST_CELLS) break;
      this.cells.delete(key);
    }
  }

  clear(): void {
    this.cells.clear();
    this.trail.length = 0;
    this.seen = [];
    this.pose = null;
    this.changes += 1;
  }
}
