// Where the links of a body are, by the angles of its joints: turns as quaternions (w, x, y, z). Pure, for drawings without WebGL.
import type { BodyModel, Link, Shape, Vec } from "./model";

export type Quat = [number, number, number, number];
export interface Place { p: Vec; q: Quat }
export const NOWHERE: Place = { p: [0, 0, 0], q: [1, 0, 0, 0] };

export const product = ([aw, ax, ay, az]: Quat, [bw, bx, by, bz]: Quat): Quat => [
  aw * bw - ax * bx - ay * by - az * bz,
  aw * bx + ax * bw + ay * bz - az * by,
  aw * by - ax * bz + ay * bw + az * bx,
  aw * bz + ax * by - ay * bx + az * bw,
];

export function rotated([w, x, y, z]: Quat, [a, b, c]: Vec): Vec {
  const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

export function about([x, y, z]: Vec, angle: number): Quat {
  const s = Math.sin(angle / 2);
  return [Math.cos(angle / 2), x * s, y * s, z * s];
}

/** Roll, pitch and yaw about axes that stay, one after the other. */
export const byRpy = ([r, p, y]: Vec): Quat => product(about([0, 0, 1], y), product(about([0, 1, 0], p), about([1, 0, 0], r)));

export const within = (outer: Place, inner: Place): Place => {
  const [x, y, z] = rotated(outer.q, inner.p);
  return { p: [outer.p[0] + x, outer.p[1] + y, outer.p[2] + z], q: product(outer.q, inner.q) };
};

function own(model: BodyModel, link: Link, angle: number): Place {
  if (!link.joint) return NOWHERE;
  if (model.joints[link.joint]?.kind === "slide") return { p: [link.axis[0] * angle, link.axis[1] * angle, link.axis[2] * angle], q: NOWHERE.q };
  return { p: [0, 0, 0], q: about(link.axis, angle) };
}

/** Where each link is; joints without an angle are at 0. */
export function placed(model: BodyModel, angles: Record<string, number | null | undefined>, root: Place = NOWHERE): Map<string, Place> {
  const found = new Map<string, Place>([["", root]]);
  for (const link of model.links) {
    const at = within(found.get(link.parent) ?? root, { p: link.origin_xyz, q: byRpy(link.origin_rpy) });
    found.set(link.name, within(at, own(model, link, angles[link.joint] ?? 0)));
  }
  return found;
}

/** Half the edges of the box around a shape, in the shape's own axes. */
export function halves({ kind, size }: Shape): Vec {
  const [a = 0, b = 0, c = 0] = size;
  if (kind === "box") return [a / 2, b / 2, c / 2];
  if (kind === "cylinder") return [a, a, b / 2];
  if (kind === "capsule") return [a, a, b / 2 + a];
  return kind === "sphere" ? [a, a, a] : [a, b, c];
}

const SIGNS: Vec[] = [-1, 1].flatMap((x) => [-1, 1].flatMap((y) => [-1, 1].map((z): Vec => [x, y, z])));

/** The corners of the box around a shape, where its link is. */
export function corners(at: Place, shape: Shape): Vec[] {
  const there = within(at, { p: shape.xyz, q: byRpy(shape.rpy) });
  const [x, y, z] = halves(shape);
  return SIGNS.map(([a, b, c]) => within(there, { p: [a * x, b * y, c * z], q: NOWHERE.q }).p);
}

/** The box around a whole body: its lowest and highest corner. */
export function extent(model: BodyModel, places: Map<string, Place>): { low: Vec; high: Vec } {
  const low: Vec = [Infinity, Infinity, Infinity];
  const high: Vec = [-Infinity, -Infinity, -Infinity];
  for (const link of model.links) {
    for (const shape of link.shapes) {
      for (const corner of corners(places.get(link.name) ?? NOWHERE, shape)) {
        corner.forEach((value, axis) => {
          low[axis] = Math.min(low[axis]!, value);
          high[axis] = Math.max(high[axis]!, value);
        });
      }
    }
  }
  return Number.isFinite(low[0]) ? { low, high } : { low: [-0.1, -0.1, 0], high: [0.1, 0.1, 0.2] };
}

/** Where a body that leans is: its lowest part is on the floor, and its middle where it is upright. */
export function grounded(model: BodyModel, angles: Record<string, number | null | undefined>, roll: number, pitch: number): Place {
  const q = byRpy([roll, pitch, 0]);
  const upright = extent(model, placed(model, angles));
  const leant = extent(model, placed(model, angles, { p: [0, 0, 0], q }));
  const aside = (axis: 0 | 1): number => (upright.low[axis] + upright.high[axis] - leant.low[axis] - leant.high[axis]) / 2;
  return { p: [aside(0), aside(1), -leant.low[2]], q };
}
