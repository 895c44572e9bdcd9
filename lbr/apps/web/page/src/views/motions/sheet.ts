// A motion in the making: key frames one after the other. Pure: each change returns a new sheet.
import { nameLetters } from "../../format";
import { mirrored, type BodyModel } from "../joints/model";
import type { KeyFrame } from "./data";

export interface Sheet { name: string; help: string; frames: KeyFrame[] }
export const EMPTY: Sheet = { name: "", help: "", frames: [] };
export const SHORTEST_S = 0.1;
export const LONGEST_S = 60;
export const MOST_FRAMES = 1000;

export const good = (name: string): boolean => /^[a-z][a-z0-9_]{0,39}$/.test(name);
export const nameFrom = (text: string): string => nameLetters(text.trimStart()).replace(/^_+/, "").slice(0, 40);
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

/** Angles are kept in ten thousandths. */
const ROUNDED_RAD = 1e-4;
export interface Fault { frame: number; joint: string; kind: "limit" | "speed"; value: number; most: number }

/** What the robot would refuse or slow down: angles beyond limits, ways that take longer than their key frame. */
export function faults(frames: readonly KeyFrame[], model: BodyModel): Fault[] {
  const found: Fault[] = [];
  frames.forEach((frame, at) => {
    const before = at > 0 ? poseAt(frames, at - 1) : {};
    for (const [joint, angle] of Object.entries(frame.positions)) {
      const range = model.joints[joint];
      if (!range) continue;
      if (range.lower != null && angle < range.lower - ROUNDED_RAD) found.push({ frame: at, joint, kind: "limit", value: angle, most: range.lower });
      else if (range.upper != null && angle > range.upper + ROUNDED_RAD) found.push({ frame: at, joint, kind: "limit", value: angle, most: range.upper });
      const rps = before[joint] === undefined ? 0 : Math.abs(angle - before[joint]) / frame.duration_s;
      if (range.speed_rps != null && rps > range.speed_rps) found.push({ frame: at, joint, kind: "speed", value: rps, most: range.speed_rps });
    }
  });
  return found;
}

/** Another one like it behind a key frame: a pose of its own, whole. */
export const doubled = (sheet: Sheet, at: number): Sheet => added(sheet, at + 1, { positions: poseAt(sheet.frames, at), duration_s: sheet.frames[at]?.duration_s ?? 1 });

/** A key frame taken out of its place and put into another. */
export function placed(sheet: Sheet, from: number, to: number): Sheet {
  const frame = sheet.frames[from];
  if (!frame || to < 0 || to >= sheet.frames.length || from === to) return sheet;
  const rest = sheet.frames.filter((_, at) => at !== from);
  return edited(sheet, [...rest.slice(0, to), frame, ...rest.slice(to)]);
}

/** A key frame reached earlier or later; those behind it stay where they are in time. */
export function timed(sheet: Sheet, at: number, s: number): Sheet {
  const frame = sheet.frames[at];
  if (!frame) return sheet;
  const next = sheet.frames[at + 1];
  const begun = lasts(sheet.frames.slice(0, at));
  const latest = next ? begun + frame.duration_s + next.duration_s - SHORTEST_S : begun + LONGEST_S;
  const to = Math.min(latest, begun + LONGEST_S, Math.max(begun + SHORTEST_S, s));
  const rest = next ? begun + frame.duration_s + next.duration_s - to : 0;
  return edited(sheet, sheet.frames.map((one, index) => (index === at ? { ...one, duration_s: grain(to - begun) } : index === at + 1 ? { ...one, duration_s: grain(rest) } : one)));
}

/** All of it faster (2: twice as fast) or slower. */
export const paced = (sheet: Sheet, factor: number): Sheet =>
  edited(sheet, sheet.frames.map((frame) => ({ ...frame, duration_s: grain(Math.min(LONGEST_S, Math.max(SHORTEST_S, frame.duration_s / factor))) })));

/** Left and right exchanged in all of it. */
export const mirroredAll = (sheet: Sheet, names: readonly string[]): Sheet => edited(sheet, sheet.frames.map((frame) => mirroredFrame(frame, names)));

/** What differs from the key frame before, in a tenth of a milliradian: what is sent and kept. */
export function sparse(frames: readonly KeyFrame[]): KeyFrame[] {
  const before: Record<string, number> = {};
  return frames.map(({ positions, duration_s }) => {
    const told = Object.entries(positions).map(([name, angle]): [string, number] => [name, Math.round(angle * 10_000) / 10_000]).filter(([name, angle]) => before[name] !== angle);
    Object.assign(before, Object.fromEntries(told));
    return { positions: Object.fromEntries(told), duration_s: Math.round(duration_s * 1000) / 1000 };
  });
}

const grain = (s: number): number => Math.round(s * 100) / 100;

/** When each key frame is reached. */
export function reached(frames: readonly KeyFrame[]): number[] {
  let s = 0;
  return frames.map((frame) => (s += frame.duration_s));
}
