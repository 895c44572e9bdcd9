// Whether a motion stands: played by the robot's machine with the simulated body, while this page asks how far it is.
import { computed, signal } from "@preact/signals";
import { told } from "../../access";
import { fetchJson } from "../../robot";
import type { KeyFrame } from "./data";
import { sheet } from "./desk";
import { reached, sparse, type Sheet } from "./sheet";
import { upload } from "./upload";

export type Spot = [number, number];
export interface Sample { t_s: number; frame: number; tilt_rad: number; roll_rad: number; pitch_rad: number; mass: Spot; pressure?: Spot | null; support: Spot[]; margin_mm?: number | null }
export interface Report {
  stands: boolean; begins: boolean; led?: boolean; duration_s: number; least_mm?: number | null; least_s?: number | null; falls_s?: number | null; falls_frame?: number | null; took_s: number; body: string; trace: Sample[];
}
export interface Checking { of: string; part: number; report: Report | null; why: string }

const ASK_MS = 150;
const NONE: Checking = { of: "", part: 0, report: null, why: "" };
export const checking = signal<Checking>(NONE);
export const busy = signal(false);
let turn = 0;
let number = 0;

const markOf = (frames: readonly KeyFrame[]): string => JSON.stringify(sparse(frames));
const mark = computed(() => markOf(sheet.value.frames));
/** What is known of the sheet as it is now. */
export const current = computed<Checking | null>(() => (checking.value.of !== "" && checking.value.of === mark.value ? checking.value : null));

/** Checks a sheet from a pose on; returns what came of it, or null if another took its turn. */
export async function check(of: Sheet, start: Record<string, number>): Promise<Checking | null> {
  const mine = ++turn;
  busy.value = true;
  checking.value = { ...NONE, of: markOf(of.frames) };
  const found = await asked(of, start, mine);
  if (mine !== turn) return null;
  busy.value = false;
  checking.value = { ...checking.value, ...found, part: 1 };
  return checking.value;
}

async function asked(of: Sheet, start: Record<string, number>, mine: number): Promise<Pick<Checking, "report" | "why">> {
  const sent = await upload(JSON.stringify({ name: of.name || "motion", frames: sparse(of.frames) }));
  if (sent.refused) return { report: null, why: told(sent.refused) };
  const begun = await fetchJson<{ check: number }>("api/motion/check", { method: "POST", quiet: true, body: { upload: sent.name, start } });
  if (!begun.ok || !begun.data) return { report: null, why: told(begun) };
  number = begun.data.check;
  for (;;) {
    const answer = await fetchJson<{ part: number; report: Report | null }>(`api/motion/check?check=${number}`, { quiet: true });
    if (mine !== turn) return { report: null, why: "" };
    if (!answer.ok || !answer.data) return { report: null, why: told(answer) };
    if (answer.data.report) return { report: answer.data.report, why: "" };
    checking.value = { ...checking.value, part: answer.data.part };
    await new Promise((done) => setTimeout(done, ASK_MS));
  }
}

export function cancel(): void {
  if (!busy.value) return;
  turn++;
  busy.value = false;
  checking.value = NONE;
  if (number) void fetchJson(`api/motion/check?check=${number}`, { method: "DELETE", quiet: true });
}

/** When in the sheet's own time each sample was: joints that are too slow stretch a key frame, and a lead-in comes before. */
export function onSheet(report: Report, frames: readonly KeyFrame[]): { s: number; sample: Sample }[] {
  const ends = reached(frames);
  const first = new Map<number, number>();
  for (const { frame, t_s } of report.trace) if (!first.has(frame)) first.set(frame, t_s);
  return report.trace.flatMap((sample) => {
    const frame = frames[sample.frame - 1];
    if (!frame || sample.t_s > report.duration_s + 0.02) return [];
    const begun = first.get(sample.frame) ?? 0;
    const over = first.get(sample.frame + 1) ?? report.duration_s;
    const part = over > begun ? Math.min(1, (sample.t_s - begun) / (over - begun)) : 1;
    return [{ s: ends[sample.frame - 1]! - frame.duration_s * (1 - part), sample }];
  });
}

/** The sample nearest to a time of the sheet. */
export function at(samples: readonly { s: number; sample: Sample }[], s: number): Sample | null {
  let best: { s: number; sample: Sample } | null = null;
  for (const one of samples) if (!best || Math.abs(one.s - s) <= Math.abs(best.s - s)) best = one;
  return best?.sample ?? null;
}
