// Motion that this page holds: begun, changed and kept over the socket, one at a time. It ends by itself when the page is
// hidden, loses the focus or the link; and the robot ends it, whatever the page does, when it is not told to go on.
import { signal } from "@preact/signals";
import { told } from "./access";
import { OLD, outdated } from "./build";
import { heardTime, link, onHold, onLink, pace, send, silentMs, type HoldNews } from "./live";
import { notice } from "./notices";
import { deedName, t } from "./words";

export interface Holding { moving: boolean; to: string; holds: boolean; code: string; reason: string; holder: string }
const RESTS: Holding = { moving: false, to: "", holds: false, code: "", reason: "", holder: "" };
/** How often it is told that the hand is still there: well within the 0.25 s after which the robot's server halts. */
const KEEP_MS = 80;
/** Changes are told this often at most: a little more often than screens show pictures, well below what the server bears. */
const CHANGE_MS = 16;
/** A page that came to nothing for so long, or heard nothing, was asleep or cut off: its hand is off. The robot knew sooner. */
const ASLEEP_MS = 1000;
/** The robot waits longer for a page that plays what ends by itself; so does this. */
const PLAYING_MS = 3000;
/** A stick that is still held goes on from rest if the link was bad for no longer than this. */
const RETURNS_MS = 1000;
/** The link is good while a frame came so lately: the robot sends five a second. */
const STEADY_MS = 300;
/** A page that did nothing for so long was asleep itself: then its hand is off, however good the link is. */
const AWAKE_MS = 250;
/** A reason why it ended is shown for so long. */
export const SHOWN_MS = 5000;
/** Who holds it can be asked for it for so long. */
const HELD_MS = 20_000;
/** What is told of the last few wishes still counts: so many are told while an answer is on its way. */
const LATELY = 8;
/** Who holds it and the emergency stop have places of their own on the page. */
const SHOWN_ELSEWHERE = new Set(["held", "estop"]);
const EXPECTED = new Set(["", "done", "idle", "superseded", "time_over"]);

const state = signal<Holding>(RESTS);
/** The robot refused, or ended, what a hand moves: it has to come to rest first, and the reason is shown until then. */
export const refused = signal(false);
/** What moves next takes over from who holds the robot. */
const takesOver = signal(false);
let played: { to: string; message: object } | null = null;
let n = 0;
let wanted = "";
let sent = "";
let sentAt = 0;
let changedAt = 0;
let steadyAt = 0;
let beatAt = 0;
let asleep = false;
let over = false;
/** Since the last release something was asked for: the robot wants to hear of the rest, after a refusal and a stop too. */
let begun = false;
let once = false;
/** It moved since it was begun, or begun again, which was at that time. */
let granted = false;
let begunAt = 0;
let active = false;
let timer: ReturnType<typeof setTimeout> | undefined;

/** Begins to move or changes how: `to` is a command's key, such as `drive/command`. Repeat it as often as you like. False: refused until `release`. */
function move(to: string, message: object): boolean {
  if (behind(to)) return false;
  if (over && to === state.value.to) return false;
  if (link.value !== "open" && link.value !== "quiet") return false;
  once = false;
  played = null;
  begin(to, message);
  return true;
}

/** Begins what ends by itself, such as a turn or a motion, and keeps it until the robot says that it ended. */
function play(to: string, message: object): void {
  release();
  if (behind(to)) return notice(OLD.reason(), "warn");
  once = true;
  played = { to, message };
  begin(to, message);
}

function begin(to: string, message: object): void {
  over = false;
  wanted = JSON.stringify({ to, message: takesOver.value ? { ...message, take_over: true } : message });
  if (!state.value.moving || state.value.to !== to) state.value = { ...RESTS, moving: true, to };
  if (!active) begunAt = performance.now();
  active = true;
  beat();
}

/** Whether the robot has another page than this one: then nothing moves, and it is said why. */
function behind(to: string): boolean {
  if (outdated.value) state.value = { ...RESTS, to, code: OLD.code, reason: OLD.reason() };
  return outdated.value;
}

/** The time since the hand that moves something last changed its command. */
const unchangedMs = (): number => (active && !once && sentAt ? performance.now() - changedAt : 0);

/** Tells what is new, or that the hand is still there, once that is due. */
function beat(): void {
  clearTimeout(timer);
  const now = performance.now();
  if (silentMs() < STEADY_MS) steadyAt = now;
  if (beatAt && now - beatAt > AWAKE_MS) asleep = true;
  beatAt = now;
  if (sent && Math.max(now - sentAt, silentMs()) > (once ? PLAYING_MS : ASLEEP_MS)) return slept();
  const changed = wanted !== sent;
  if (changed && now - changedAt >= CHANGE_MS) tell(now);
  else if (!changed && now - sentAt >= KEEP_MS && send({ keep: n, ...heardTime() })) sentAt = now;
  const due = (wanted === sent ? sentAt + KEEP_MS : changedAt + CHANGE_MS) - performance.now();
  timer = setTimeout(beat, Math.max(1, due));
}

function tell(now: number): void {
  const { to, message } = JSON.parse(wanted) as { to: string; message: object };
  if (!send({ hold: { to, message, n: ++n }, ...heardTime() })) return;
  begun = true;
  sent = wanted;
  sentAt = changedAt = now;
}

/** Takes the hand off because this page was asleep, or hears nothing. */
function slept(): void {
  send({ release: true });
  end({ n, holds: false, code: "lapsed", reason: t("link.slept"), holder: "" });
}

/** Lets what moves come to rest. */
function release(): void {
  clearTimeout(timer);
  if (state.value.moving) takesOver.value = false;
  active = over = once = asleep = granted = false;
  beatAt = 0;
  if (begun) send({ release: true });
  pace.value = null;
  begun = false;
  wanted = sent = "";
  sentAt = changedAt = 0;
  if (state.value === RESTS) return;
  state.value = { ...RESTS, code: state.value.code, reason: state.value.reason, holder: state.value.holder };
  fade();
}

function heard(news: HoldNews): void {
  if (!active || news.n < n - LATELY) return;
  const now = performance.now();
  const awake = !asleep && now - beatAt < AWAKE_MS;
  granted ||= news.holds;
  const slow = news.code === "lapsed" || (news.code === "late" && (granted || now - begunAt < RETURNS_MS));
  if (slow && !once && awake && now - steadyAt < RETURNS_MS) return goOn();
  const code = news.code === "lapsed" && !awake ? "asleep" : news.code;
  state.value = { ...state.value, holds: news.holds, code, reason: news.reason, holder: news.holder };
  if (!news.holds && (news.n === n || code)) end({ ...news, code });
}

/** The robot stopped because the link was bad for a moment, and the hand is still there: it begins again, from rest. */
function goOn(): void {
  if (granted) {
    begunAt = performance.now();
    notice(t("link.back"), "info");
  }
  granted = false;
  sent = "";
  beat();
}

/** Notes that what moved has ended without this hand. */
function end(news: HoldNews): void {
  clearTimeout(timer);
  active = false;
  wanted = sent = "";
  over = !once;
  state.value = { ...state.value, moving: false, holds: false, code: news.code, reason: news.reason, holder: news.holder };
  fade();
  takesOver.value = false;
  if (!once) return;
  const motion = (played?.message as { motion?: string } | undefined)?.motion;
  if (EXPECTED.has(news.code) && motion?.startsWith("get_up_")) return; // its attitude shows whether it is up
  if (EXPECTED.has(news.code)) notice(t("drive.reached", { reason: motion ? deedName(motion) : news.reason }), "good");
  else if (news.code === "stopped") notice(t("stop.stopped"));
  else if (!SHOWN_ELSEWHERE.has(news.code)) notice(told(news), "warn", { code: news.code, about: state.value.to.split("/")[0] });
}

/** Takes over from who holds what was refused: what ends by itself begins again at once, a hand with its next push. */
function takeOver(): void {
  const again = state.value.code === "held" ? played : null;
  takesOver.value = !takesOver.value;
  forget();
  if (again && takesOver.value) play(again.to, again.message);
}

/** Takes the reason of an end off the page after some seconds; not while a hand has to come to rest for it. `to` stays: `move` still refuses that hand. */
function fade(): void {
  const left = state.value;
  setTimeout(() => { if (state.value === left && !refused.value) state.value = { ...RESTS, to: left.to }; }, left.code === "held" ? HELD_MS : SHOWN_MS);
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

export const holding = { state, takesOver, move, play, release, forget, takeOver, unchangedMs };
