// A motion in the making: key frames one after the other. Pure: each change returns a new sheet.
import { mirrored, type BodyModel } from "../joints/model";
import type { KeyFrame, Motion } from "./data";

export interface Sheet { name: string; help: string; frames: KeyFrame[] }
export const EMPTY: Sheet = { name: "", help: "", frames: [] };
export const SHORTEST_S = 0.1;
export const LONGEST_S = 60;
export const MOST_FRAMES = 1000;

export const good = (name: string): boolean => /^[a-z][a-z0-9_]{0,39}$/.test(name);
export const nameFrom = (text: string): string => text.trim().toLowerCase().replace(/[^a-z0-9]+/g, "_").replace(/^_+/, "").slice(0, 40);
export const lasts = (frames: readonly KeyFrame[]): number => frames.reduce((sum, frame) => sum + frame.duration_s, 0);

/** The whole pose at a key frame: joints that it leaves out are where the ones before put them. */
export function poseAt(frames: readonly KeyFrame[], at: number): Record<string, number> {
  return Object.assign({}, ...frames.slice(0, at + 1).map((frame) => frame.positions)) as Record<string, number>;
}

/** The pose at a time, straight from one key frame to the next. */
export function poseOver(frames: readonly KeyFrame[], s: number, from: Record<string, number> = {}): Record<string, number> {
  let begun = 0;
  let before = from;
  for (const frame of frames) {
    const part = Math.min(1, Math.max(0, (s - begun) / frame.duration_s));
    const eased = part * part * (3 - 2 * part);
    if (part < 1) return { ...before, ...Object.fromEntries(Object.entries(frame.positions).map(([name, angle]) => [name, (before[name] ?? angle) + (angle - (before[name] ?? angle)) * eased])) };
    begun += frame.duration_s;
    before = { ...before, ...frame.positions };
  }
  return before;
}

const edited = (sheet: Sheet, frames: KeyFrame[]): Sheet => ({ ...sheet, frames: frames.slice(0, MOST_FRAMES) });

export const added = (sheet: Sheet, at: number, frame: KeyFrame): Sheet => edited(sheet, [...sheet.frames.slice(0, at), frame, ...sheet.frames.slice(at)]);
export const removed = (sheet: Sheet, at: number): Sheet => edited(sheet, sheet.frames.filter((_, index) => index !== at));
export const replaced = (sheet: Sheet, at: number, change: Partial<KeyFrame>): Sheet =>
  edited(sheet, sheet.frames.map((frame, index) => (index === at ? { ...frame, ...change } : frame)));

export function shifted(sheet: Sheet, at: number, by: -1 | 1): Sheet {
  const to = at + by;
  if (to < 0 || to >= sheet.frames.length) return sheet;
  const frames = [...sheet.frames];
  [frames[at], frames[to]] = [frames[to]!, frames[at]!];
  return edited(sheet, frames);
}

/** Left and right exchanged; mirrored joints count alike. */
export function mirroredFrame(frame: KeyFrame, names: readonly string[]): KeyFrame {
  return { ...frame, positions: Object.fromEntries(Object.entries(frame.positions).map(([name, angle]) => [mirrored(name, names) || name, angle])) };
}

/** Each pose a little like its neighbours, the first and the last as they are. */
export function smoothed(sheet: Sheet): Sheet {
  const whole = sheet.frames.map((_, at) => poseAt(sheet.frames, at));
  return edited(sheet, sheet.frames.map((frame, at) => {
    if (at === 0 || at === sheet.frames.length - 1) return frame;
    const positions = Object.fromEntries(Object.entries(whole[at]!).map(([name, angle]) => [name, 0.5 * angle + 0.25 * (whole[at - 1]![name] ?? angle) + 0.25 * (whole[at + 1]![name] ?? angle)]));
    return { ...frame, positions };
  }));
}

export interface Fault { frame: number; joint: string; kind: "limit" | "speed"; value: number; most: number }

/** What the robot would refuse or slow down: angles beyond limits, ways that take longer than their key frame. */
export function faults(frames: readonly KeyFrame[], model: BodyModel): Fault[] {
  const found: Fault[] = [];
  frames.forEach((frame, at) => {
    const before = at > 0 ? poseAt(frames, at - 1) : {};
    for (const [joint, angle] of Object.entries(frame.positions)) {
      const range = model.joints[joint];
      if (!range) continue;
      if (range.lower != null && angle < range.lower - 1e-6) found.push({ frame: at, joint, kind: "limit", value: angle, most: range.lower });
      else if (range.upper != null && angle > range.upper + 1e-6) found.push({ frame: at, joint, kind: "limit", value: angle, most: range.upper });
      const rps = before[joint] === undefined ? 0 : Math.abs(angle - before[joint]) / frame.duration_s;
      if (range.speed_rps != null && rps > range.speed_rps) found.push({ frame: at, joint, kind: "speed", value: rps, most: range.speed_rps });
    }
  });
  return found;
}

/** Reads a file: what `lbr motion export` wrote, or a plain list of key frames. Throws with a sentence. */
export function read(text: string, names: readonly string[]): Sheet {
  const told = JSON.parse(text) as { motion?: Partial<Motion> } & Partial<Motion>;
  const motion = told.motion ?? told;
  if (!Array.isArray(motion.frames) || motion.frames.length === 0) throw new Error("no key frames");
  if (motion.frames.length > MOST_FRAMES) throw new Error(`${motion.frames.length} > ${MOST_FRAMES}`);
  const frames = motion.frames.map((frame, at): KeyFrame => {
    const positions = Object.fromEntries(Object.entries(frame?.positions ?? {}).filter(([name]) => names.includes(name)));
    if (!Object.values(positions).every((angle) => typeof angle === "number" && Number.isFinite(angle))) throw new Error(`#${at + 1}`);
    const duration = Number(frame.duration_s);
    return { positions, duration_s: Number.isFinite(duration) ? Math.min(LONGEST_S, Math.max(0.01, duration)) : 1 };
  });
  return { name: nameFrom(String(motion.name ?? "")), help: String(motion.help ?? "").slice(0, 200), frames };
}
