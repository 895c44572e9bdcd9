// The body as flat outlines, seen from one side: what is drawn where there is no WebGL, and for small pictures of poses.
import type { BodyModel, Vec } from "./model";
import { corners, NOWHERE, placed, type Place } from "./pose";

export interface Patch { link: string; joint: string; points: string; shade: string; depth: number }
export interface Sketch { patches: Patch[]; box: [number, number, number, number] }
type Point = [number, number];

/** From where it is looked at: turned to its left by so much from straight ahead, and from so far above. */
export interface From { yaw: number; pitch: number }
export const THREE_QUARTERS: From = { yaw: 0.5, pitch: 0.18 };

/** A point as it is seen: to the right, up, and towards who looks. */
export function seen([x, y, z]: Vec, { yaw, pitch }: From): Vec {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const [ahead, left] = [cy * x + sy * y, -sy * x + cy * y];
  return [left, z * cp - ahead * sp, ahead * cp + z * sp];
}

/** The point that is seen there. */
export function unseen([left, up, near]: Vec, { yaw, pitch }: From): Vec {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const ahead = near * cp - up * sp;
  return [cy * ahead - sy * left, sy * ahead + cy * left, up * cp + near * sp];
}

/** The convex outline of points, anticlockwise (Andrew). */
export function hull(points: Point[]): Point[] {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (all: Point[]): Point[] => {
    const found: Point[] = [];
    for (const point of all) {
      while (found.length > 1 && turn(found.at(-2)!, found.at(-1)!, point) <= 0) found.pop();
      found.push(point);
    }
    return found.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

const turn = (a: Point, b: Point, c: Point): number => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);

function movers(model: BodyModel): Map<string, string> {
  const found = new Map<string, string>([["", ""]]);
  for (const link of model.links) found.set(link.name, link.joint || (found.get(link.parent) ?? ""));
  return found;
}

/** Draws a pose; `places` may be given where they are known. The y of the picture goes down. */
export function sketch(model: BodyModel, angles: Record<string, number | null | undefined>, from: From = THREE_QUARTERS, places: Map<string, Place> = placed(model, angles)): Sketch {
  const moved = movers(model);
  const patches: Patch[] = [];
  const box: [number, number, number, number] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const link of model.links) {
    for (const shape of link.shapes) {
      const points = corners(places.get(link.name) ?? NOWHERE, shape).map((corner) => seen(corner, from));
      const outline = hull(points.map(([across, up]): Point => [across, -up]));
      for (const [x, y] of outline) {
        box[0] = Math.min(box[0], x); box[1] = Math.min(box[1], y);
        box[2] = Math.max(box[2], x); box[3] = Math.max(box[3], y);
      }
      const depth = points.reduce((sum, point) => sum + point[2], 0) / points.length;
      patches.push({ link: link.name, joint: moved.get(link.name) ?? "", points: outline.map(([x, y]) => `${x.toFixed(4)},${y.toFixed(4)}`).join(" "), shade: shaded(shape.rgba), depth });
    }
  }
  patches.sort((a, b) => a.depth - b.depth);
  if (!Number.isFinite(box[0])) return { patches, box: [0, 0, 1, 1] };
  const [w, h] = [box[2] - box[0], box[3] - box[1]];
  const edge = 0.06 * Math.max(w, h);
  return { patches, box: [box[0] - edge, box[1] - edge, w + 2 * edge, h + 2 * edge] };
}

const shaded = ([r, g, b]: readonly number[]): string => `rgb(${[r, g, b].map((value) => Math.round(255 * (value ?? 0))).join(" ")})`;
