// Motion that this page holds: begun, changed and kept over the socket, one at a time. It ends by itself when the page is
// hidden, loses the focus or the link; and the robot ends it, whatever the page does, when it is not told to go on.
import { signal } from "@preact/signals";
import { told } from "./access";
import { heardTime, link, onHold, onLink, send, type HoldNews } from "./live";
import { notice } from "./notices";
import { t } from "./words";

export interface Holding { moving: boolean; to: string; holds: boolean; code: string; reason: string; holder: string }
const RESTS: Holding = { moving: false, to: "", holds: false, code: "", reason: "", holder: "" };
/** How often it is told that the hand is still there: well within the 0.25 s after which the robot's server halts. */
const KEEP_MS = 80;
/** Changes are told this often at most. */
const CHANGE_MS = 40;
/** A reason why it ended is shown for so long. */
const SHOWN_MS = 8000;
const EXPECTED = new Set(["", "done", "idle", "superseded", "time_over"]);

const state = signal<Holding>(RESTS);
let n = 0;
let wanted = "";
let told_ = "";
let toldAt = 0;
let over = false;
/** Since the last release something was asked for: the robot wants to hear of the rest, after a refusal and a stop too. */
let begun = false;
let once = false;
let timer: ReturnType<typeof setInterval> | undefined;

/** Begins to move or changes how: `to` is a command's key, such as `drive/command`. Repeat it as often as you like. False: refused until `release`. */
function move(to: string, message: object): boolean {
  if (over && to === state.value.to) return false;
  if (link.value !== "open" && link.value !== "quiet") return false;
  once = false;
  begin(to, message);
  return true;
}

/** Begins what ends by itself, such as a turn or a motion, and keeps it until the robot says that it ended. */
function play(to: string, message: object): void {
  release();
  once = true;
  begin(to, message);
}

function begin(to: string, message: object): void {
  over = false;
  wanted = JSON.stringify({ to, message });
  if (!state.value.moving || state.value.to !== to) state.value = { ...RESTS, moving: true, to };
  timer ??= setInterval(beat, KEEP_MS / 2);
  if (performance.now() - toldAt >= CHANGE_MS) beat();
}

function beat(): void {
  const now = performance.now();
  if (wanted !== told_ && now - toldAt >= CHANGE_MS) {
    const { to, message } = JSON.parse(wanted) as { to: string; message: object };
    if (send({ hold: { to, message, n: ++n }, ...heardTime(!told_) })) {
      begun = true;
      told_ = wanted;
      toldAt = now;
    }
  } else if (now - toldAt >= KEEP_MS && told_) {
    if (send({ keep: n, ...heardTime() })) toldAt = now;
  }
}

/** Lets what moves come to rest. */
function release(): void {
  clearInterval(timer);
  timer = undefined;
  over = once = false;
  if (begun) send({ release: true });
  begun = false;
  wanted = told_ = "";
  toldAt = 0;
  if (state.value === RESTS) return;
  state.value = { ...RESTS, code: state.value.code, reason: state.value.reason, holder: state.value.holder };
  const left = state.value;
  setTimeout(() => { if (state.value === left) state.value = RESTS; }, SHOWN_MS);
}

function heard(news: HoldNews): void {
  if (!timer || news.n < n - 3) return;
  state.value = { ...state.value, holds: news.holds, code: news.code, reason: news.reason, holder: news.holder };
  if (news.holds || (news.n !== n && !news.code)) return;
  clearInterval(timer);
  timer = undefined;
  wanted = told_ = "";
  over = !once;
  state.value = { ...state.value, moving: false };
  if (once) {
    if (EXPECTED.has(news.code)) notice(t("drive.reached", { reason: news.reason }), "good");
    else notice(told(news), news.code === "stopped" ? "info" : "warn");
  }
}

/** Forgets the last refusal. */
function forget(): void {
  if (!state.value.moving) state.value = RESTS;
}

onHold.add(heard);
onLink.add((open) => { if (!open) release(); });
window.addEventListener("blur", () => { if (!once) release(); });
window.addEventListener("pagehide", release);
document.addEventListener("freeze", release);
document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });

export const holding = { state, move, play, release, forget };
