// Where what the sensors saw is, seen from above: x ahead, y left, metres (REP 103). Pure.
import type { RangeSensor, Ranges, Scan } from "../../messages";

export interface Fan { name: string; x: number; y: number; yaw: number; fov: number; min: number; max: number; distance: number | null; status: string }
export interface Point { x: number; y: number }
export interface Pose extends Point { yaw: number }

const LEVEL_RAD = 0.5;
const RING: RangeSensor[] = [
  { name: "forward", kind: "ultrasonic", x_m: 0.2 },
  { name: "back", kind: "ultrasonic", x_m: -0.2, yaw_rad: Math.PI },
  { name: "left", kind: "ultrasonic", y_m: 0.15, yaw_rad: Math.PI / 2 },
  { name: "right", kind: "ultrasonic", y_m: -0.15, yaw_rad: -Math.PI / 2 },
];
const OWN_FIELD = new Set(["forward", "back", "left", "right", "bottom"]);

export function metresOf(readings: Ranges, sensor: string): number | null {
  const value = OWN_FIELD.has(sensor) ? readings[`${sensor}_m` as keyof Ranges] : readings.others_m?.[sensor];
  return typeof value === "number" ? value : null;
}

/** What each level sensor of one ray reads, as fans round the base. */
export function fans(rows: RangeSensor[], readings: Ranges): Fan[] {
  const known = rows.length > 0 ? rows : RING;
  return known
    .filter((row) => Math.abs(row.pitch_rad ?? 0) <= LEVEL_RAD && (row.rays ?? 1) === 1)
    .map((row) => ({
      name: row.name, x: row.x_m ?? 0, y: row.y_m ?? 0, yaw: row.yaw_rad ?? 0, fov: row.fov_rad ?? 0.4, min: row.min_m ?? 0.02, max: row.max_m ?? 4,
      distance: metresOf(readings, row.name), status: readings.status[row.name] ?? "",
    }))
    .filter((fan) => fan.status !== "missing" && (fan.status !== "" || fan.distance !== null));
}

export interface Reading { name: string; distance: number | null; status: string }

/** What each sensor reads that the message tells of, in the order of the rows; one that has a row and no answer is missing. */
export function read(rows: RangeSensor[], readings: Ranges): Reading[] {
  const named = new Set([...rows.map((row) => row.name), ...Object.keys(readings.status), ...Object.keys(readings.others_m ?? {})]);
  return [...named]
    .map((name) => ({ name, distance: metresOf(readings, name), status: readings.status[name] ?? (metresOf(readings, name) === null ? "" : "ok") }))
    .filter((one) => one.status !== "" && (one.status !== "missing" || rows.some((row) => row.name === one.name)));
}

/** Whether it looks along the floor; a sensor without a row does, unless it is the one below. */
export function level(rows: RangeSensor[], sensor: string): boolean {
  const row = rows.find((one) => one.name === sensor);
  return row ? Math.abs(row.pitch_rad ?? 0) <= LEVEL_RAD : sensor !== "bottom";
}

/** Whether its silence is worth a warning: it looks where the base goes, or its row has it stop the base. */
export function missed(rows: RangeSensor[], sensor: string): boolean {
  return level(rows, sensor) || typeof rows.find((one) => one.name === sensor)?.stop_m === "number";
}

/** The nearest that a scan saw; null if nothing. */
export function nearestOf(scan: Scan): number | null {
  const seen = scan.ranges_m.filter((one): one is number => typeof one === "number" && one >= scan.range_min_m && one <= scan.range_max_m);
  return seen.length > 0 ? seen.reduce((one, other) => Math.min(one, other)) : null;
}

/** The points of a scan, in the base's frame. */
export function points(row: RangeSensor | undefined, scan: Scan): Point[] {
  const { x_m: x = 0, y_m: y = 0, yaw_rad: yaw = 0 } = row ?? {};
  return scan.ranges_m.flatMap((distance, number) => {
    if (typeof distance !== "number" || distance < scan.range_min_m || distance > scan.range_max_m) return [];
    const angle = yaw + scan.angle_min_rad + number * scan.angle_increment_rad;
    return [{ x: x + distance * Math.cos(angle), y: y + distance * Math.sin(angle) }];
  });
}

/** The end of a fan's middle, in the base's frame; null where nothing is seen. */
export const end = (fan: Fan): Point | null =>
  fan.distance === null ? null : { x: fan.x + fan.distance * Math.cos(fan.yaw), y: fan.y + fan.distance * Math.sin(fan.yaw) };

/** A point of the base's frame in the world's. */
export const placed = (pose: Pose, point: Point): Point => ({
  x: pose.x + point.x * Math.cos(pose.yaw) - point.y * Math.sin(pose.yaw),
  y: pose.y + point.x * Math.sin(pose.yaw) + point.y * Math.cos(pose.yaw),
});

/** How large the base is, by where its sensors sit; half its length and half its width. */
export function size(rows: RangeSensor[]): { ahead: number; aside: number } {
  const reach = (values: number[], least: number): number => Math.min(0.6, Math.max(least, ...values.map(Math.abs)));
  return { ahead: reach(rows.map((row) => row.x_m ?? 0), 0.17), aside: reach(rows.map((row) => row.y_m ?? 0), 0.13) };
}

/** The way that the base would go in the next seconds, by the powers of its two sides; a drawing's guess, not a forecast. */
export function way(left: number, right: number, steps = 14, reach = 1.1): Point[] {
  const ahead = ((left + right) / 2) * reach;
  const turn = (right - left) * 1.5;
  const found: Point[] = [];
  let [x, y, yaw] = [0, 0, 0];
  for (let step = 0; step < steps; step++) {
    yaw += turn / steps;
    x += (ahead / steps) * Math.cos(yaw);
    y += (ahead / steps) * Math.sin(yaw);
    found.push({ x, y });
  }
  return found;
}
