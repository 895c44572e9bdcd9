// The surroundings seen from above, ahead is up: fans of single sensors, points of scans, where the base is about to go.
import { useCallback, useMemo, useRef } from "preact/hooks";
import { metres } from "../../format";
import { clock, useStream, watch, type Sample } from "../../live";
import type { DriveState, Ranges, Scan } from "../../messages";
import { robot, streamOfType, streamsOfType } from "../../robot";
import { maybe, named, t } from "../../words";
import { Canvas, type Pen } from "./Canvas";
import { fans, points, read, size, way, type Fan, type Point } from "./geometry";

const NEAR_M = 0.4;
const WARN_M = 0.9;
const RINGS_M = [0.5, 1, 2, 3];
const OLD_MS = 1500;

interface Seen { ranges: Map<string, Sample<Ranges>>; scans: Map<string, Sample<Scan>>; drive: Sample<DriveState> | null }

export function Radar({ reach = 2.4, class: more = "" }: { reach?: number; class?: string }) {
  const seen = useRef<Seen>({ ranges: new Map(), scans: new Map(), drive: null });
  const rows = robot.value?.ranges ?? [];
  const body = useMemo(() => size(rows), [rows]);
  const subscribe = useCallback((ask: () => void) => {
    const ends = [
      ...streamsOfType("Ranges").map((key) => watch(key, (one) => { seen.current.ranges.set(key, one as Sample<Ranges>); ask(); })),
      ...streamsOfType("Scan").map((key) => watch(key, (one) => { seen.current.scans.set(key, one as Sample<Scan>); ask(); })),
      watch(streamOfType("DriveState"), (one) => { seen.current.drive = one as Sample<DriveState>; ask(); }),
    ];
    let old = "";
    const aged = clock.subscribe(() => {
      const now = [...seen.current.ranges.values(), ...seen.current.scans.values()].map((one) => one.stale(OLD_MS)).join();
      if (now !== old) ask();
      old = now;
    });
    return () => { ends.forEach((end) => end()); aged(); };
  }, [robot.value?.revision]);
  const paint = (pen: Pen): void => {
    const scale = Math.min(pen.width, pen.height) / 2 / reach;
    const at = (point: Point): [number, number] => [pen.width / 2 - point.y * scale, pen.height / 2 - point.x * scale];
    rings(pen, scale);
    for (const sample of seen.current.ranges.values()) for (const fan of fans(rows, sample.message)) drawFan(pen, at, scale, fan, sample.stale(OLD_MS));
    for (const sample of seen.current.scans.values()) drawScan(pen, at, points(rows.find((row) => row.name === sample.message.sensor), sample.message), sample.stale(OLD_MS));
    drawBase(pen, scale, body, seen.current.drive?.message ?? null, at);
  };
  return <Canvas class={more} paint={paint} subscribe={subscribe} label={t("drive.radar.alt", { list: "" })} />;
}

/** The same in words, for who does not see the picture, twice a second at most by screen readers' own pace. */
export function RangesInWords() {
  const sample = useStream<Ranges>(streamOfType("Ranges"));
  if (!sample) return null;
  const said = read(robot.value?.ranges ?? [], sample.message).map((one) => `${named(one.name)} ${one.status === "ok" ? metres(one.distance) : maybe(`range.${one.status}`)}`);
  return <p class="sr">{t("drive.radar.alt", { list: said.join(", ") })}</p>;
}

function rings({ ctx, width, height, colour }: Pen, scale: number): void {
  ctx.lineWidth = 1;
  ctx.font = "600 10px system-ui, sans-serif";
  ctx.textAlign = "center";
  for (const metre of RINGS_M) {
    ctx.beginPath();
    ctx.arc(width / 2, height / 2, metre * scale, 0, 2 * Math.PI);
    ctx.strokeStyle = colour("--line");
    ctx.stroke();
    if (metre * scale < height / 2 - 4 && metre >= 1) {
      ctx.fillStyle = colour("--muted");
      ctx.fillText(`${metre} m`, width / 2, height / 2 + metre * scale - 4);
    }
  }
}

function drawFan({ ctx, colour }: Pen, at: (point: Point) => [number, number], scale: number, fan: Fan, old: boolean): void {
  const [x, y] = at(fan);
  const middle = -fan.yaw - Math.PI / 2;
  if (fan.status === "invalid" || (old && fan.distance === null)) return drawUnknown(ctx, x, y, scale, fan, middle, colour(old ? "--muted" : "--warn"));
  const far = fan.distance === null;
  const distance = Math.min(fan.distance ?? fan.max, 6);
  const tone = old ? "--muted" : far ? "--accent" : distance < NEAR_M ? "--bad" : distance < WARN_M ? "--warn" : "--accent";
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.arc(x, y, distance * scale, middle - fan.fov / 2, middle + fan.fov / 2);
  ctx.closePath();
  const fill = ctx.createRadialGradient(x, y, 0, x, y, Math.max(1, distance * scale));
  fill.addColorStop(0, `color-mix(in srgb, ${colour(tone)} 4%, transparent)`);
  fill.addColorStop(1, `color-mix(in srgb, ${colour(tone)} ${far ? 6 : 30}%, transparent)`);
  ctx.fillStyle = fill;
  ctx.fill();
  if (far || old) return;
  ctx.beginPath();
  ctx.arc(x, y, distance * scale, middle - fan.fov / 2, middle + fan.fov / 2);
  ctx.lineWidth = 3.5;
  ctx.lineCap = "round";
  ctx.strokeStyle = colour(tone);
  ctx.stroke();
}

/** A sensor that says nothing of use: an empty, dashed fan. */
function drawUnknown(ctx: CanvasRenderingContext2D, x: number, y: number, scale: number, fan: Fan, middle: number, colour: string): void {
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.arc(x, y, Math.min(fan.max, 1) * scale, middle - fan.fov / 2, middle + fan.fov / 2);
  ctx.closePath();
  ctx.setLineDash([4, 5]);
  ctx.lineWidth = 1.5;
  ctx.strokeStyle = colour;
  ctx.stroke();
  ctx.setLineDash([]);
}

function drawScan({ ctx, colour }: Pen, at: (point: Point) => [number, number], found: Point[], old: boolean): void {
  for (const point of found) {
    const near = Math.hypot(point.x, point.y);
    ctx.fillStyle = colour(old ? "--muted" : near < NEAR_M ? "--bad" : near < WARN_M ? "--warn" : "--accent");
    const [x, y] = at(point);
    ctx.beginPath();
    ctx.arc(x, y, 2, 0, 2 * Math.PI);
    ctx.fill();
  }
}

function drawBase({ ctx, width, height, colour }: Pen, scale: number, body: { ahead: number; aside: number }, drive: DriveState | null, at: (point: Point) => [number, number]): void {
  if (drive?.moving) {
    ctx.beginPath();
    ctx.moveTo(width / 2, height / 2);
    for (const point of way(drive.left, drive.right)) ctx.lineTo(...at(point));
    ctx.lineWidth = body.aside * scale;
    ctx.lineCap = "round";
    ctx.lineJoin = "round";
    ctx.strokeStyle = `color-mix(in srgb, ${colour("--accent")} 35%, transparent)`;
    ctx.stroke();
  }
  const [long, wide] = [Math.max(9, body.ahead * scale), Math.max(7, body.aside * scale)];
  ctx.save();
  ctx.translate(width / 2, height / 2);
  ctx.fillStyle = colour("--muted");
  for (const side of [-1, 1]) {
    ctx.beginPath();
    ctx.roundRect(side * (wide + 2) - 3, -long * 0.5, 6, long, 2.5);
    ctx.fill();
  }
  ctx.beginPath();
  ctx.roundRect(-wide, -long, 2 * wide, 2 * long, Math.min(wide, long) * 0.5);
  ctx.fillStyle = colour("--raised");
  ctx.fill();
  ctx.lineWidth = 2;
  ctx.strokeStyle = colour("--ink");
  ctx.stroke();
  ctx.beginPath();
  ctx.moveTo(0, -long * 0.58);
  ctx.lineTo(wide * 0.42, long * 0.18);
  ctx.lineTo(0, 0);
  ctx.lineTo(-wide * 0.42, long * 0.18);
  ctx.closePath();
  ctx.fillStyle = colour("--ink");
  ctx.fill();
  ctx.restore();
}
