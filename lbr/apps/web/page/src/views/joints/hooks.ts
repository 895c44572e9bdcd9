// What the views of joints and motions have in common: streams at the pace of a reader, and the joints of all buses together.
import { useEffect, useState } from "preact/hooks";
import { watch, type Aged, type Sample } from "../../live";
import { streamsOfType } from "../../robot";
import type { JointsState } from "./model";

/** Calls `show` with the newest, no more often than so. */
function calmly<T>(everyMs: number, show: (newest: T) => void): { hear: (one: T) => void; end: () => void } {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let shownAt = -Infinity;
  let newest: T;
  const now = (): void => {
    timer = undefined;
    shownAt = performance.now();
    show(newest);
  };
  const hear = (one: T): void => {
    newest = one;
    const wait = shownAt + everyMs - performance.now();
    if (wait <= 0 && timer === undefined) now();
    else timer ??= setTimeout(now, Math.max(0, wait));
  };
  return { hear, end: () => clearTimeout(timer) };
}

/** What is seen of a stream, no more than so often: lists need not follow each message. */
export function useCalm<T>(key: string, everyMs = 100): Sample<T> | null {
  const [sample, show] = useState<{ key: string; sample: Sample<T> } | null>(null);
  useEffect(() => {
    const calm = calmly<Sample<T>>(everyMs, (newest) => show({ key, sample: newest }));
    const end = watch(key, (one) => calm.hear(one as Sample<T>));
    return () => { end(); calm.end(); };
  }, [key, everyMs]);
  return sample?.key === key ? sample.sample : null;
}

/** The capability that owns a stream. */
export const ownerOf = (stream: string): string => stream.split("/")[0] ?? "";

/** All joints of the robot: a robot with several lines of servos has a capability for each. */
export interface Joints extends Aged { state: JointsState; owners: Record<string, string> }

export const jointStreams = (): string[] => streamsOfType("JointsState");

/** Calls `fn` with all joints whenever some are seen to change; by `listen`, whenever some were measured. */
export function listenJoints(streams: readonly string[], fn: (joints: Joints) => void, by = watch): () => void {
  const newest = new Map<string, Sample<JointsState>>();
  const ends = streams.map((stream) => by(stream, (one) => {
    newest.set(stream, one as Sample<JointsState>);
    fn(together(newest));
  }));
  return () => ends.forEach((end) => end());
}

/** What several capabilities say of their joints, as one; the oldest of them says how old it is. */
function together(newest: ReadonlyMap<string, Sample<JointsState>>): Joints {
  const all = [...newest];
  const owners = Object.fromEntries(all.flatMap(([stream, { message }]) => Object.keys(message.joints).map((name) => [name, ownerOf(stream)])));
  const oldest = (): Sample<JointsState> => all.map(([, one]) => one).reduce((a, b) => (a.at <= b.at ? a : b));
  const told = all.map(([, one]) => one.message).find((one) => one.reason) ?? oldest().message;
  const joints = Object.assign({}, ...all.map(([, one]) => one.message.joints)) as JointsState["joints"];
  return { state: { ...told, joints, moving: all.some(([, one]) => one.message.moving) }, owners, stale: (ms) => oldest().stale(ms), ageMs: () => oldest().ageMs() };
}

/** All joints, drawn again when something about them is seen to change. */
export function useJoints(streams: readonly string[], everyMs = 100): Joints | null {
  const [joints, show] = useState<Joints | null>(null);
  const key = streams.join(" ");
  useEffect(() => {
    const calm = calmly<Joints>(everyMs, show);
    const end = listenJoints(streams, calm.hear);
    return () => { end(); calm.end(); };
  }, [key, everyMs]);
  return joints;
}
