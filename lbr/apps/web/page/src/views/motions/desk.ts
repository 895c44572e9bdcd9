// What lies on the builder's desk: the sheet, what it was before and after, which key frame is chosen. It outlives the view.
import { computed, signal } from "@preact/signals";
import { remember, remembered } from "../../kept";
import type { KeyFrame } from "./data";
import { EMPTY, poseAt, type Sheet } from "./sheet";

const KEPT = "motion.draft";
const MOST_BACK = 60;

/** A draft that an older page kept may lack what this one knows. */
function draft(): Sheet {
  const told = remembered<Partial<Sheet>>(KEPT, EMPTY);
  const frames = Array.isArray(told?.frames) ? told.frames.filter((one) => one && typeof one.duration_s === "number" && typeof one.positions === "object") : [];
  return { name: String(told?.name ?? ""), help: String(told?.help ?? ""), frames };
}

export const sheet = signal<Sheet>(draft());
const before = signal<Sheet[]>([]);
const after = signal<Sheet[]>([]);
/** The sheet as it was saved last, or opened. */
export const saved = signal<Sheet | null>(null);
export const chosen = signal(0);
export const clip = signal<KeyFrame | null>(null);

export const index = computed(() => Math.min(chosen.value, Math.max(0, sheet.value.frames.length - 1)));
export const canUndo = computed(() => before.value.length > 0);
export const canRedo = computed(() => after.value.length > 0);
export const dirty = computed(() => sheet.value.frames.length > 0 && JSON.stringify(sheet.value.frames) !== JSON.stringify(saved.value?.frames ?? []));

let stroke = "";
let strokeAt = 0;

/** Of one gesture whose end is not told, changes that follow one another within this are one. */
const GOES_ON_MS = 1500;

/** Changes the sheet. Changes of one `hand` that follow one another, such as a drag, are taken back together. */
export function change(next: Sheet, hand = "", goesOnMs = GOES_ON_MS): void {
  if (next === sheet.value) return;
  const now = performance.now();
  const goesOn = hand !== "" && hand === stroke && now - strokeAt < goesOnMs;
  [stroke, strokeAt] = [hand, now];
  if (!goesOn) before.value = [...before.value, sheet.value].slice(-MOST_BACK);
  after.value = [];
  put(next);
}

function put(next: Sheet): void {
  sheet.value = next;
  remember(KEPT, next);
}

export function undo(): void {
  const last = before.value.at(-1);
  if (!last) return;
  stroke = "";
  before.value = before.value.slice(0, -1);
  after.value = [...after.value, sheet.value];
  put(last);
}

export function redo(): void {
  const next = after.value.at(-1);
  if (!next) return;
  stroke = "";
  after.value = after.value.slice(0, -1);
  before.value = [...before.value, sheet.value];
  put(next);
}

/** Names it, which is nothing to take back. */
export const rename = (name: string): void => put({ ...sheet.value, name });

/** Opens another one; `known`: as it is kept at the robot. */
export function open(other: Sheet, known: boolean): void {
  change(other);
  saved.value = known ? other : null;
  chosen.value = 0;
}

export function copy(): void {
  const frame = sheet.value.frames[index.value];
  if (frame) clip.value = { positions: poseAt(sheet.value.frames, index.value), duration_s: frame.duration_s };
}
