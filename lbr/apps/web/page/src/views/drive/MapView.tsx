// The map: where the base was and what it measured, by odometry and ranges; kept while the page is open.
import { useSignal } from "@preact/signals";
import { useCallback, useEffect, useRef } from "preact/hooks";
import { listen, type Sample } from "../../live";
import type { OdometryState, Ranges, Scan } from "../../messages";
import { Button } from "../../parts";
import { robot, streamOfType, streamsOfType } from "../../robot";
import { t } from "../../words";
import { Canvas, type Pen } from "./Canvas";
import { end, fans, points, type Point } from "./geometry";
import { CELL_M, SURE, WorldMap, zoomed, type Sight } from "./map";

const LEAST_M = 2;
const FAR_M = 3;
/** What the compass covers of the picture, in dots. */
const ABOVE = 60;
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
      world.see(points(rows.find((row) => row.name === scan.sensor), scan), true);
    })),
  ];
  return () => ends.forEach((stop) => stop());
}

export function MapView() {
  const box = useRef<HTMLDivElement>(null);
  const chosen = useSignal<Sight | null>(null);
  const fingers = useRef(new Map<number, Point>());
  const shown = useRef<Sight>({ x: 0, y: 0, scale: 60 });
  const asks = useRef<() => void>(() => undefined);
  const subscribe = useCallback((ask: () => void) => {
    asks.current = ask;
    let drawn = -1;
    const again = setInterval(() => {
      if (drawn !== world.changes) ask();
      drawn = world.changes;
    }, 100);
    return () => clearInterval(again);
  }, []);
  const look = (sight: Sight | null): void => {
    chosen.value = sight;
    asks.current();
  };
  const zoom = (factor: number, clientX?: number, clientY?: number): void => {
    const { left, top, width, height } = box.current!.getBoundingClientRect();
    const { scale } = shown.current;
    const at = clientX === undefined || clientY === undefined ? { x: 0, y: 0 } : { x: (top + height / 2 - clientY) / scale, y: (left + width / 2 - clientX) / scale };
    shown.current = zoomed(shown.current, factor, at);
    look(shown.current);
  };
  useEffect(() => {
    const wheel = (event: WheelEvent): void => {
      event.preventDefault();
      zoom(Math.exp(-event.deltaY / 400), event.clientX, event.clientY);
    };
    box.current!.addEventListener("wheel", wheel, { passive: false });
    return () => box.current?.removeEventListener("wheel", wheel);
  }, []);
  const drag = (event: PointerEvent): void => {
    const before = fingers.current.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const other = [...fingers.current].find(([id]) => id !== event.pointerId)?.[1];
    fingers.current.set(event.pointerId, now);
    if (other) {
      const [was, is] = [Math.hypot(before.x - other.x, before.y - other.y), Math.hypot(now.x - other.x, now.y - other.y)];
      if (was > 8) zoom(is / was, (now.x + other.x) / 2, (now.y + other.y) / 2);
    } else if (Math.hypot(now.x - before.x, now.y - before.y) > 0) {
      const { x, y, scale } = shown.current;
      shown.current = { scale, x: x + (now.y - before.y) / scale, y: y + (now.x - before.x) / scale };
      look(shown.current);
    }
  };
  const lift = (event: PointerEvent): void => { fingers.current.delete(event.pointerId); };
  return (
    <div
      ref={box} class="drive-map" onPointerDown={(event) => { if (!(event.target as Element).closest("button")) { fingers.current.set(event.pointerId, { x: event.clientX, y: event.clientY }); box.current!.setPointerCapture(event.pointerId); } }}
      onPointerMove={drag} onPointerUp={lift} onPointerCancel={lift} onLostPointerCapture={lift}
    >
      <Canvas paint={(pen) => paint(pen, chosen.value, shown)} subscribe={subscribe} label={t("drive.map.alt")} />
      <div class="drive-map-tools" role="group" aria-label={t("drive.map")}>
        <Button kind="quiet" icon="plus" label={t("drive.map.nearer")} onClick={() => zoom(1.5)} />
        <Button kind="quiet" icon="minus" label={t("drive.map.further")} onClick={() => zoom(1 / 1.5)} />
        <Button kind="quiet" icon="fit" label={t("drive.map.all")} pressed={chosen.value === null} onClick={() => look(null)} />
        <Button kind="quiet" icon="trash" label={t("drive.map.clear")} onClick={() => { world.clear(); look(null); }} />
      </div>
    </div>
  );
}

/** The sight in which all of the map is shown. */
function whole(width: number, height: number): Sight {
  const all: Point[] = [...world.trail, ...world.seen, ...(world.pose ? [world.pose] : [])];
  for (const cell of world.cells.values()) if (cell.count > 1) all.push(cell);
  if (all.length === 0) all.push({ x: -1, y: -1 }, { x: 1, y: 1 });
  const xs = all.map((one) => one.x);
  const ys = all.map((one) => one.y);
  const [low, high] = [{ x: min(xs), y: min(ys) }, { x: max(xs), y: max(ys) }];
  const [tall, wide] = [Math.max(LEAST_M, high.x - low.x + 0.6), Math.max(LEAST_M, high.y - low.y + 0.6)];
  const scale = Math.min(width / wide, (height - ABOVE) / tall);
  return { x: (low.x + high.x) / 2 + ABOVE / 3 / scale, y: (low.y + high.y) / 2, scale };
}

function paint({ ctx, width, height, colour }: Pen, chosen: Sight | null, shown: { current: Sight }): void {
  const sight = chosen ?? whole(width, height);
  shown.current = sight;
  const { scale } = sight;
  const at = (point: Point): [number, number] => [width / 2 - (point.y - sight.y) * scale, height / 2 - (point.x - sight.x) * scale];
  grid(ctx, width, height, at, sight, colour("--line"));
  const cell = Math.max(2, CELL_M * scale);
  ctx.fillStyle = colour("--ink");
  for (const one of world.cells.values()) {
    const [x, y] = at(one);
    if (x < -cell || y < -cell || x > width + cell || y > height + cell) continue;
    ctx.globalAlpha = Math.min(1, 0.2 + one.count / (SURE + 1));
    ctx.fillRect(Math.round(x - cell / 2), Math.round(y - cell / 2), Math.ceil(cell), Math.ceil(cell));
  }
  ctx.globalAlpha = 1;
  ctx.fillStyle = colour("--accent");
  for (const point of world.seen) {
    const [x, y] = at(point);
    ctx.beginPath();
    ctx.arc(x, y, 2, 0, 2 * Math.PI);
    ctx.fill();
  }
  if (world.trail.length > 1) {
    ctx.beginPath();
    world.trail.forEach((point, number) => (number === 0 ? ctx.moveTo(...at(point)) : ctx.lineTo(...at(point))));
    ctx.strokeStyle = colour("--accent");
    ctx.globalAlpha = 0.8;
    ctx.lineWidth = 2.5;
    ctx.lineJoin = "round";
    ctx.stroke();
    ctx.globalAlpha = 1;
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

function grid(ctx: CanvasRenderingContext2D, width: number, height: number, at: (point: Point) => [number, number], { x, y, scale }: Sight, colour: string): void {
  const step = scale < 8 ? 10 : scale < 25 ? 5 : 1;
  const reach = { x: height / scale, y: width / 2 / scale };
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
