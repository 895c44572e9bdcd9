// The robot's body and its joints as the page has them: GET /api/model, and the newest of what the joints say.
import { signal } from "@preact/signals";
import { told } from "../../access";
import { fetchJson } from "../../robot";

export type Vec = [number, number, number];
export type ShapeKind = "box" | "cylinder" | "sphere" | "capsule" | "ellipsoid";
export interface Shape { kind: ShapeKind; size: number[]; xyz: Vec; rpy: Vec; rgba: [number, number, number, number] }
export interface Link { name: string; parent: string; joint: string; axis: Vec; origin_xyz: Vec; origin_rpy: Vec; shapes: Shape[] }
export type JointKind = "hinge" | "slide" | "wheel";
export type Side = "left" | "right" | "centre";
export interface JointRange { lower: number | null; upper: number | null; kind: JointKind; side: Side; speed_rps: number | null; drawn: boolean }
export interface BodySensor { name: string; kind: string; link: string; xyz: Vec; rpy: Vec; fov_rad: number | null; max_m: number | null }
export interface BodyModel { robot: string; links: Link[]; joints: Record<string, JointRange>; sensors: BodySensor[]; left_out: string[]; reason: string }

export interface JointState {
  id: number; position_rad?: number | null; speed_rps?: number | null; load?: number | null; goal_rad?: number | null; target_rad?: number | null;
  torque?: number | null; voltage_v?: number | null; temperature_c?: number | null; faults?: string[]; latched?: string[]; reason?: string; code?: string;
  trusted?: boolean | null; age_s?: number | null;
}
export interface JointsState {
  sequence: number; measured_s: number; moving: boolean; phase: string; joints: Record<string, JointState>; holder?: string | null; goal?: string | null;
  reason?: string; code?: string; estop?: boolean; stopped_by?: string;
}

export const body = signal<BodyModel | null>(null);
let of: string | null = null;

/** Asks for the body, once for each revision of the rows. */
export async function loadBody(revision: string): Promise<void> {
  if (of === revision && body.value) return;
  of = revision;
  const answer = await fetchJson<BodyModel>("api/model", { quiet: true });
  if (of !== revision) return;
  if (answer.ok && answer.data) body.value = answer.data;
  else {
    of = null;
    body.value ??= { robot: "", links: [], joints: {}, sensors: [], left_out: [], reason: told(answer) };
  }
}

/** The joints that a page lists, from the head of the body's tree down, those that are not drawn last. */
export function jointNames(model: BodyModel): string[] {
  const order = new Map(model.links.map((link, at) => [link.joint, at]));
  const names = Object.keys(model.joints).filter((name) => model.joints[name]!.kind !== "wheel");
  return names.sort((a, b) => (order.get(a) ?? Infinity) - (order.get(b) ?? Infinity) || 0);
}

/** The name of the same joint on the other side; empty if there is none. */
export function mirrored(name: string, names: readonly string[]): string {
  const other = name.startsWith("left_") ? `right_${name.slice(5)}` : name.startsWith("right_") ? `left_${name.slice(6)}` : "";
  return names.includes(other) ? other : "";
}
