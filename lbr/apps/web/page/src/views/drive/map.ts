// A map of where the base was and what it measured there: cells of five centimetres, by odometry alone. Pure.
import { placed, type Point, type Pose } from "./geometry";

export const CELL_M = 0.05;
const MOST_CELLS = 30_000;
const MOST_STEPS = 4000;
const STEP_M = 0.04;

export class WorldMap {
  readonly cells = new Map<string, { x: number; y: number; count: number }>();
  readonly trail: Point[] = [];
  pose: Pose | null = null;
  private epoch = "";

  /** Notes where the base is. Another epoch of the odometry begins another map. */
  move(pose: Pose, epoch: string): void {
    if (epoch !== this.epoch) this.clear();
    this.epoch = epoch;
    this.pose = pose;
    const last = this.trail.at(-1);
    if (last && Math.hypot(last.x - pose.x, last.y - pose.y) < STEP_M) return;
    this.trail.push({ x: pose.x, y: pose.y });
    if (this.trail.length > MOST_STEPS) this.trail.shift();
  }

  /** Notes what was seen from where the base is now. */
  see(points: Point[]): void {
    if (!this.pose) return;
    for (const point of points) {
      const { x, y } = placed(this.pose, point);
      const [column, row] = [Math.round(x / CELL_M), Math.round(y / CELL_M)];
      const key = `${column},${row}`;
      const cell = this.cells.get(key);
      if (cell) cell.count = Math.min(cell.count + 1, 20);
      else this.cells.set(key, { x: column * CELL_M, y: row * CELL_M, count: 1 });
    }
    for (const key of this.cells.keys()) {
      if (this.cells.size <= MOST_CELLS) break;
      this.cells.delete(key);
    }
  }

  clear(): void {
    this.cells.clear();
    this.trail.length = 0;
    this.pose = null;
  }
}
