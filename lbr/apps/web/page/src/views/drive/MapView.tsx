// The map: where the base was and what it measured, by odometry and ranges; kept while the page is open.
import { useCallback } from "preact/hooks";
import { listen, type Sample } from "../../live";
import type { OdometryState, Ranges, Scan } from "../../messages";
import { Button } from "../../parts";
import { robot, streamOfType, streamsOfType } from "../../robot";
import { t } from "../../words";
import { Canvas, type Pen } from "./Canvas";
import { end, fans, points, type Point } from "./geometry";
import { CELL_M, WorldMap } from "./map";

const LEAST_M = 2;
const FAR_M = 3;
export const world = new WorldMap();

/** Gathers the map while the Drive view is open, whichever picture it shows. */
export function gather(): () => void {
  const rows = robot.value?.ranges ?? [];
  const ends = [
    listen(streamOfType("OdometryState"), (one) => {
      const { valid, x_m, y_m, yaw_rad, epoch } = (one as Sample<OdometryState>).message;
      if (valid && x_m != null && y_m != null && yaw_rad != null) world.move({ x: x_m, y: y_m, yaw: yaw_rad }, epoch);
    }),
    ...streamsOfType("Ranges").map((key) => listen(key, (one) => {
      const seen = fans(rows, (one as Sample<Ranges>).message).filter((fan) => fan.status === "ok" && (fan.distance ?? FAR_M) < FAR_M);
      world.see(seen.map(end).filter((point): point is Point => point !== null));
    })),
    ...streamsOfType("Scan").map((key) => listen(key, (one) => {
      const scan = (one as Sample<Scan>).message;
      world.see(points(rows.find((row) => row.name === scan.sensor), scan));
    })),
  ];
  return () => ends.forEach((stop) => stop());
}

export function MapView() {
  const subscribe = useCallback((ask: () => void) => {
    const again = setInterval(ask, 100);
    return () => clearInterval(again);
  }, []);
  return (
    <div class="drive-map">
      <Canvas paint={paint} subscribe={subscribe} label={t("drive.map.alt")} />
      <Button kind="quiet" icon="trash" label={t("drive.map.clear")} class="drive-map-clear" onClick={() => world.clear()} />
    </div>
  );
}

function paint({ ctx, width, height, colour }: Pen): void {
  const all: Point[] = [...world.trail, ...(world.pose ? [world.pose] : [])];
  for (const cell of world.cells.values()) if (cell.count > 1) all.push(cell);
  const xs = all.map((one) => one.x);
  const ys = all.map((one) => one.y);
  const bounds = all.length > 0 ? { x: [min(xs), max(xs)] as const, y: [min(ys), max(ys)] as const } : { x: [-1, 1] as const, y: [-1, 1] as const };
  const [tall, wide] = [Math.max(LEAST_M, bounds.x[1] - bounds.x[0] + 0.6), Math.max(LEAST_M, bounds.y[1] - bounds.y[0] + 0.6)];
  const scale = Math.min(width / wide, height / tall);
  const [middleX, middleY] = [(bounds.x[0] + bounds.x[1]) / 2, (bounds.y[0] + bounds.y[1]) / 2];
  const at = (point: Point): [number, number] => [width / 2 - (point.y - middleY) * scale, height / 2 - (point.x - middleX) * scale];
  grid(ctx, width, height, at, scale, colour("--line"), middleX, middleY);
  const cell = Math.max(2, CELL_M * scale);
  ctx.fillStyle = colour("--ink");
  for (const one of world.cells.values()) {
    const [x, y] = at(one);
    ctx.globalAlpha = Math.min(1, 0.25 + one.count / 8);
    ctx.fillRect(x - cell / 2, y - cell / 2, cell, cell);
  }
  ctx.globalAlpha = 1;
  if (world.trail.length > 1) {
    ctx.beginPath();
    world.trail.forEach((point, number) => (number === 0 ? ctx.moveTo(...at(point)) : ctx.lineTo(...at(point))));
    ctx.strokeStyle = colour("--accent");
    ctx.lineWidth = 2.5;
    ctx.lineJoin = "round";
    ctx.stroke();
  }
  if (!world.pose) return;
  const [x, y] = at(world.pose);
  ctx.save();
  ctx.translate(x, y);
  ctx.rotate(-world.pose.yaw);
  ctx.beginPath();
  ctx.moveTo(0, -14);
  ctx.lineTo(10, 11);
  ctx.lineTo(0, 6);
  ctx.lineTo(-10, 11);
  ctx.closePath();
  ctx.fillStyle = colour("--accent");
  ctx.fill();
  ctx.lineWidth = 2;
  ctx.strokeStyle = colour("--bg");
  ctx.stroke();
  ctx.restore();
}

const min = (values: number[]): number => values.reduce((one, other) => Math.min(one, other), Infinity);
const max = (values: number[]): number => values.reduce((one, other) => Math.max(one, other), -Infinity);

function grid(ctx: CanvasRenderingContext2D, width: number, height: number, at: (point: Point) => [number, number], scale: number, colour: string, x: number, y: number): void {
  const step = scale < 25 ? 5 : 1;
  const reach = { x: height / 2 / scale, y: width / 2 / scale };
  ctx.strokeStyle = colour;
  ctx.lineWidth = 1;
  ctx.beginPath();
  for (let row = Math.ceil((x - reach.x) / step) * step; row <= x + reach.x; row += step) {
    const [, line] = at({ x: row, y });
    ctx.moveTo(0, line);
    ctx.lineTo(width, line);
  }
  for (let column = Math.ceil((y - reach.y) / step) * step; column <= y + reach.y; column += step) {
    const [line] = at({ x, y: column });
    ctx.moveTo(line, 0);
    ctx.lineTo(line, height);
  }
  ctx.stroke();
}
