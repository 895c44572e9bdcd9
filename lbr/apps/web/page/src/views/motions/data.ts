// The robot's motions as the page has them: rows of GET /api, and a picture of each.
import { signal } from "@preact/signals";
import { holding } from "../../holding";
import { notice } from "../../notices";
import { command, fetchJson, robot } from "../../robot";
import { t } from "../../words";

export interface MotionRow { name: string; help: string; slot?: number | null; builtin?: boolean; frames?: number; duration_s?: number }
export interface ButtonRow { id: number; name: string; button?: string; motion?: string }
export interface MotionsState {
  playing: boolean; motion?: string; frame?: number; frames?: number; round?: number; times?: number; left_s?: number | null; holder?: string | null; reason?: string; code?: string;
  fallen?: string;
}
export interface KeyFrame { positions: Record<string, number>; duration_s: number }
export interface Motion { name: string; help?: string; frames: KeyFrame[]; lead_in?: string; lead_out?: string; slot?: number | null }

export const poses = signal<Record<string, Record<string, number>>>({});
let of = "";
const AGAIN_MS = 1000, MOST_TRIES = 30;

/** Loads a pose of each motion. A server that starts again with new rows does not answer, or not of them yet: then it is asked again. */
export async function loadPoses(revision: string): Promise<void> {
  if (of === revision) return;
  of = revision;
  for (let tries = 0; tries < MOST_TRIES; tries += 1) {
    const answer = await fetchJson<{ poses: Record<string, Record<string, number>> }>("api/poses", { quiet: true });
    if (of !== revision) return;
    if (answer.ok && answer.data) poses.value = answer.data.poses;
    if (answer.ok && rows().every((one) => one.slot != null || one.name in poses.value)) return;
    await new Promise((done) => { setTimeout(done, AGAIN_MS); });
  }
  of = "";
}

export const rows = (): MotionRow[] => (robot.value?.motions ?? []) as unknown as MotionRow[];
export const buttons = (): ButtonRow[] => ((robot.value?.buttons ?? []) as unknown as ButtonRow[]).filter((one) => one.motion);

/** Where the keys of a remote control stand: its pad, and what is below. */
export const PAD = [["LR", "U", "RR"], ["L", "S", "R"], ["LA", "D", "RA"]] as const;
const ARROWS: Record<string, string> = { U: "↑", D: "↓", L: "←", R: "→", LR: "⟲", RR: "⟳", S: "⇧", LA: "⇈", RA: "⇈⇈" };
export const keycap = (button: string): string => ARROWS[button] ?? button;
/** Whether buttons are laid out as on a remote control. */
export const hasPad = (all: ButtonRow[]): boolean => PAD.flat().filter((key) => all.some((one) => one.button === key)).length >= 4;

/** How much of a motion is over, by what was left when it was first heard. */
export class Progress {
  private key = "";
  private whole = 0;

  part(state: MotionsState | undefined): number {
    if (!state?.playing || state.left_s == null) {
      this.key = "";
      return 0;
    }
    const key = `${state.holder ?? ""}/${state.times ?? 1}`;
    if (key !== this.key || state.left_s > this.whole) {
      this.key = key;
      this.whole = Math.max(state.left_s, 0.1);
    }
    return Math.min(1, Math.max(0, 1 - state.left_s / this.whole));
  }
}

/** Ends the motion that is played, whoever plays it. */
export function endPlay(owner: string): void {
  holding.release();
  notice(t("stop.stopped"));
  void command(owner, "stop", { reason: "from the page" }, { quiet: true });
}

/** In which pose motions end that go there and no further, by their names. */
export const ends = signal<Record<string, Record<string, number>>>({});
const GOES_THERE = /^(stand|reset$|sit)/;
/** So far off the joints may be, in the mean: an arm elsewhere is no reason to stand up once more. */
const THERE_RAD = 0.12;
let endsOf = "";

/** Loads where these motions end, once for each revision of the rows. */
export async function loadEnds(all: MotionRow[], revision: string): Promise<void> {
  if (endsOf === revision) return;
  endsOf = revision;
  ends.value = {};
  for (const { name } of all.filter((one) => GOES_THERE.test(one.name))) {
    const answer = await fetchJson<Motion>(`api/motion?motion=${encodeURIComponent(name)}`, { quiet: true });
    if (endsOf !== revision) return;
    if (answer.ok && answer.data) ends.value = { ...ends.value, [name]: Object.assign({}, ...answer.data.frames.map((one) => one.positions)) };
  }
}

/** Whether the joints are where a motion ends already. */
export function isThere(end: Record<string, number> | undefined, at: Record<string, number | null | undefined>): boolean {
  const off = Object.entries(end ?? {}).map(([joint, rad]) => Math.abs((at[joint] ?? Infinity) - rad));
  return off.length > 0 && off.reduce((sum, one) => sum + one, 0) / off.length < THERE_RAD;
}

/** What people ask of a humanoid first, in this order. */
const FIRST = [/^stand/, /^reset$/, /^(wave|demo)/, /^walk.*(short|ahead|forward)/, /^sit/, /^dance/, /^turn/, /^(kick|bow)/, /^initial$/];
const MOST = 5;

/** All motions: of each kind that people ask for the quickest, then others, and last what begins lying. */
export function ordered(all: MotionRow[]): MotionRow[] {
  const quick = [...all].sort((a, b) => (a.duration_s ?? 0) - (b.duration_s ?? 0));
  const found = FIRST.flatMap((kind) => quick.find(({ name }) => kind.test(name)) ?? []);
  const rest = all.filter((one) => !found.includes(one));
  return [...found, ...rest.filter((one) => !lying(one)), ...rest.filter(lying)];
}

const lying = ({ name }: MotionRow): boolean => name.startsWith("get_up_");

/** The few motions that are offered beside the body; what gets it up is shown when it lies. */
export const deeds = (all: MotionRow[]): MotionRow[] => ordered(all).filter((one) => !lying(one)).slice(0, MOST);
