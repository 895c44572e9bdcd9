// The call of this page: it goes on while the views change.
import { signal } from "@preact/signals";
import type { Connection, Hears, Phase } from "./connection";
import { capabilities } from "./robot";
import { learn, t } from "./words";
import { call as callWords } from "./words/call";

learn(callWords);

export type Stage = "idle" | "asking" | Phase;
export interface Now {
  stage: Stage; watches: boolean; since: number;
  /** Why there is no picture, what is heard of the robot, whether it shows this caller: the robot's words. */
  picture: string; hears: Hears; sound: string; seen: boolean;
  /** What of this device the robot does not get, and why. */
  lacks: string;
  /** How the last one ended, or why none came to be. */
  ended: string; was: boolean;
}
const IDLE: Now = { stage: "idle", watches: false, since: 0, picture: "", hears: "silence", sound: "", seen: false, lacks: "", ended: "", was: false };

export const call = signal<Now>(IDLE);
/** What comes of the robot, and what it gets of this device. */
export const theirs = signal<MediaStream | null>(null);
export const ours = signal<MediaStream | null>(null);
export const silent = signal(false);
export const unseen = signal(false);
/** The robot's sound, whichever view is looked at. */
const voice = new Audio();
let connection: Connection | null = null;
let turn = 0;

/** The robot's capability that lets pages call; undefined if there is none. */
export const caller = () => capabilities("call")[0];

/** Calls the robot; or watches it, without sound and without being seen. */
export async function ring(watches = false): Promise<void> {
  if (call.value.stage !== "idle") return;
  const mine = ++turn;
  call.value = { ...IDLE, stage: "asking", watches };
  if (typeof RTCPeerConnection !== "function") return ended(t("call.browser"));
  const { stream, lacks } = watches ? { stream: null, lacks: "" } : await device();
  if (mine !== turn) return stop(stream);
  ours.value = stream;
  silent.value = unseen.value = false;
  call.value = { ...call.value, stage: "connecting", lacks };
  const made = await import("./connection").catch(() => null);
  if (mine !== turn) return stop(stream);
  if (made === null) return ended(t("call.lost"));
  connection = made.connect({
    purpose: watches ? "watch" : "talk",
    send: stream,
    onMedia: (media) => {
      theirs.value = media;
      if (watches || media.getAudioTracks().length === 0) return;
      voice.srcObject = media;
      void voice.play().catch(() => undefined);
    },
    onNews: ({ phase, picture, hears, sound, seen }) => {
      const since = phase === "talking" ? call.value.since || Date.now() : 0;
      call.value = { ...call.value, stage: phase, picture, hears, sound, seen, since };
    },
    onEnd: (reason) => { if (mine === turn) ended(reason); },
  });
}

/** Ends it from this side. */
export function hangUp(): void {
  turn += 1;
  connection?.close();
  ended("");
}

export function hush(on: boolean): void {
  silent.value = on;
  ours.value?.getAudioTracks().forEach((one) => { one.enabled = !on; });
}

export function hide(on: boolean): void {
  unseen.value = on;
  ours.value?.getVideoTracks().forEach((one) => { one.enabled = !on; });
}

function ended(reason: string): void {
  stop(ours.value);
  connection = null;
  voice.srcObject = null;
  theirs.value = ours.value = null;
  call.value = { ...IDLE, ended: reason, was: call.value.since > 0 };
}

const stop = (stream: MediaStream | null): void => stream?.getTracks().forEach((one) => one.stop());

/** This device's camera and microphone, as far as the browser and its user give them. */
async function device(): Promise<{ stream: MediaStream | null; lacks: string }> {
  if (!navigator.mediaDevices?.getUserMedia) return { stream: null, lacks: window.isSecureContext ? t("call.lacks.browser") : t("call.lacks.secure") };
  const video = { width: { ideal: 640 }, height: { ideal: 480 }, frameRate: { ideal: 15, max: 24 }, facingMode: "user" };
  const audio = { echoCancellation: true, noiseSuppression: true, autoGainControl: true };
  const wishes: [MediaStreamConstraints, string][] = [[{ video, audio }, ""], [{ audio }, t("call.lacks.camera")], [{ video }, t("call.lacks.microphone")]];
  for (const [wish, lacks] of wishes) {
    try {
      return { stream: await navigator.mediaDevices.getUserMedia(wish), lacks };
    } catch (err) {
      if (err instanceof DOMException && err.name === "NotAllowedError") return { stream: null, lacks: t("call.lacks.denied") };
    }
  }
  return { stream: null, lacks: t("call.lacks.both") };
}
