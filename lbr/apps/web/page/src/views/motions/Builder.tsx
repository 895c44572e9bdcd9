// The motion builder: key frames on a time line, posed by dragging a puppet, by sliders and numbers or as the robot stands;
// checked for balance by the robot's machine, played on the puppet first, then on the robot.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { degrees, number } from "../../format";
import { holding } from "../../holding";
import { notice } from "../../notices";
import { Badge, Button, Card, Choice, Dialog, Field, Slider } from "../../parts";
import { may } from "../../robot";
import { estop } from "../../stopping";
import { jointName, t } from "../../words";
import { jointStreams, ownerOf, useJoints } from "../joints/hooks";
import { jointNames, mirrored, type BodyModel } from "../joints/model";
import { at as sampleAt, cancel, check, current, onSheet, type Report } from "./balance";
import { CheckCard } from "./Check";
import type { MotionRow } from "./data";
import { canRedo, canUndo, change, chosen, clip, copy, dirty, index, redo, sheet, undo } from "./desk";
import { Files } from "./Files";
import { Hands } from "./Hands";
import { added, doubled, faults, lasts, mirroredAll, mirroredFrame, paced, placed, poseAt, poseOver, removed, replaced, SHORTEST_S, smoothed, sparse } from "./sheet";
import { Puppet } from "./Puppet";
import { Timeline } from "./Timeline";
import { torques } from "../joints/tone";

/** What one message to the robot may hold, and some room: longer motions are saved first, and played by their name. */
const MOST_TOLD = 14_000;
const TYPED = "input:not([type=range]):not([type=checkbox]), textarea, select, [role=dialog]";
const PACE = 1.25;

export function Builder({ model, motions, player }: { model: BodyModel; motions: MotionRow[]; player: string }) {
  const now = sheet.value;
  const at = index.value;
  const frame = now.frames[at];
  const [joint, pick] = useState("");
  const [time, setTime] = useState<number | null>(null);
  const [live, goLive] = useState(false);
  const [asks, ask] = useState(false);
  const names = useMemo(() => jointNames(model), [model]);
  const streams = jointStreams();
  const joints = useJoints(streams, live ? 60 : 250);
  const state = joints?.state;
  const measured = (): Record<string, number> => Object.fromEntries(Object.entries(state?.joints ?? {}).flatMap(([name, one]) => (one.position_rad == null || !model.joints[name] ? [] : [[name, clamp(model, name, one.position_rad)]])));
  const pose = live && state ? measured() : time === null ? poseAt(now.frames, at) : poseOver(now.frames, time, poseAt(now.frames, 0));
  const wrong = useMemo(() => faults(now.frames, model), [now, model]);
  const limits = wrong.filter((one) => one.kind === "limit");
  const can = may("operate") && !estop.value.engaged;
  const owner = streams[0] ? ownerOf(streams[0]) : "joints";
  const report = current.value?.report ?? null;
  const samples = useMemo(() => (report ? onSheet(report, now.frames) : []), [report, now]);
  const sample = samples.length && time !== null ? sampleAt(samples, time) : null;

  const put = (positions: Record<string, number>, hand: string): void => { if (frame) change(replaced(now, at, { positions: { ...frame.positions, ...positions } }), `${hand}-${at}`); };
  const append = (positions: Record<string, number>): void => {
    const place = now.frames.length ? at + 1 : 0;
    change(added(now, place, { positions, duration_s: 1 }));
    chosen.value = place;
    setTime(null);
  };
  /** A limb that is pressed has its slider in sight. */
  const choose = (name: string): void => {
    pick(name);
    if (name) requestAnimationFrame(() => document.querySelector(".motions-number")?.scrollIntoView({ block: "nearest", behavior: "smooth" }));
  };
  const narrow = useNarrow();
  const one = joint && frame && <One joint={joint} model={model} value={pose[joint] ?? 0} onPut={(positions) => put(positions, joint)} other={mirrored(joint, names)} />;
  const capture = (): void => { if (state) append(measured()); };
  const acts: Acts = {
    add: () => append(frame ? poseAt(now.frames, at) : zero(model)),
    copy,
    cut: () => { copy(); acts.remove(); },
    paste: () => { if (clip.value) { const place = now.frames.length ? at + 1 : 0; change(added(now, place, clip.value)); chosen.value = place; } },
    double: () => { if (frame) { change(doubled(now, at)); chosen.value = at + 1; } },
    remove: () => { if (frame) { change(removed(now, at)); chosen.value = Math.max(0, at - 1); } },
    mirror: () => { if (frame) change(replaced(now, at, mirroredFrame({ ...frame, positions: poseAt(now.frames, at) }, names))); },
    earlier: () => { if (at > 0) { change(placed(now, at, at - 1)); chosen.value = at - 1; } },
    later: () => { if (at < now.frames.length - 1) { change(placed(now, at, at + 1)); chosen.value = at + 1; } },
    go: (by) => { setTime(null); chosen.value = Math.min(Math.max(0, now.frames.length - 1), Math.max(0, at + by)); },
    undo, redo,
  };
  const start = (): Record<string, number> => (torques(names, state?.joints).held === names.length ? measured() : {});
  const run = (): Promise<Awaited<ReturnType<typeof check>>> => { goLive(false); return check(now, start()); };
  const play = (): void => {
    const frames = sparse(now.frames);
    const kept = !dirty.value && motions.some((one) => one.name === now.name && one.slot == null);
    if (kept) holding.play(`${player}/play`, { motion: now.name, times: 1 });
    else if (JSON.stringify(frames).length <= MOST_TOLD) holding.play(`${owner}/command`, { frames, interpolation: "smooth" });
    else notice(t("motions.too.long"), "warn");
  };
  const checked = useRef(play);
  checked.current = play;
  /** Plays what stands; what falls is asked about once more, and any touch in between, a stop above all, ends it. */
  const playChecked = async (): Promise<void> => {
    if (current.value?.why) return play();
    if (current.value?.report) return safe(current.value.report) ? play() : ask(true);
    const untouched = watchTouches();
    const found = await run();
    const calm = untouched();
    if (!found || !calm) return;
    if (found.report && !safe(found.report)) return ask(true);
    if (found.why) notice(t("motions.check.not", { why: found.why }), "info");
    if (!estop.value.engaged) checked.current();
  };
  useKeys(acts);
  useEffect(() => () => cancel(), []);
  return (
    <div class="motions-builder">
      <div class="motions-build-main">
        <Puppet model={model} pose={pose} tilt={time !== null && sample ? sample : null} selected={joint} drags={time === null && frame !== undefined && !live} live={live} onPick={choose} onDrag={(name, rad) => put({ [name]: rad }, name)} />
        {narrow && one && <Card>{one}</Card>}
        <Timeline model={model} time={time} report={report} wrong={new Set(limits.map((one) => one.frame))} onTime={setTime} />
        <Tools acts={acts} frame={frame !== undefined}>
          <Preview whole={lasts(now.frames)} time={time} onTime={(s) => { goLive(false); setTime(s); }} />
        </Tools>
      </div>
      <div class="motions-build-side">
        <Card title={t("motions.motion")} icon="motions">
          <p class="motions-badges">
            <Badge>{now.frames.length === 1 ? t("motions.frames.one") : t("motions.frames", { count: now.frames.length })}</Badge><Badge>{number(lasts(now.frames), 1)} s</Badge>
            {limits.length > 0 && <Badge tone="bad" icon="warn">{t("motions.wrong.limit", { joint: jointName(limits[0]!.joint), value: degrees(limits[0]!.value), most: degrees(limits[0]!.most) })}</Badge>}
            {limits.length === 0 && wrong.length > 0 && <Badge tone="warn" icon="speed">{t("motions.wrong.speed", { joint: jointName(wrong[0]!.joint) })}</Badge>}
          </p>
          <Button kind="primary" icon="play" class="motions-on-robot" disabled={!can || now.frames.length === 0 || limits.length > 0} onClick={() => void playChecked()}>{t("motions.on.robot")}</Button>
          <div class="joints-actions">
            <Button disabled={!frame} onClick={() => change(paced(now, 1 / PACE), "pace")}>{t("motions.slower")}</Button>
            <Button disabled={!frame} onClick={() => change(paced(now, PACE), "pace")}>{t("motions.faster")}</Button>
            <Button disabled={now.frames.length < 3} onClick={() => change(smoothed(now))}>{t("motions.smooth")}</Button>
            <Button icon="mirror" disabled={!frame} onClick={() => change(mirroredAll(now, names))}>{t("motions.mirror.all")}</Button>
          </div>
        </Card>
        {frame && (
          <Card title={t("motions.frame.at", { frame: at + 1, of: now.frames.length })} icon="joints">
            <Slider label={t("motions.keep.lasts")} min={SHORTEST_S} max={Math.max(5, Math.ceil(frame.duration_s))} step={0.05} value={frame.duration_s} show={(value) => `${number(value, 2)} s`} onInput={(value) => change(replaced(now, at, { duration_s: value }), `lasts-${at}`)} />
            <Choice label={t("motions.joint")} value={joint} options={[{ value: "", text: t("motions.joint.none") }, ...names.map((name) => ({ value: name, text: jointName(name) }))]} onChange={pick} />
            {!narrow && one}
          </Card>
        )}
        <CheckCard sample={sample && report?.falls_s != null && sample.t_s > report.falls_s ? null : sample} empty={now.frames.length === 0 || limits.length > 0} onCheck={() => void run()} />
        <Hands model={model} joints={joints} live={live} onLive={(on) => { setTime(null); goLive(on); }} onCapture={capture} />
        <Card title={t("motions.file")} icon="save"><Files model={model} motions={motions} bad={limits.length > 0} /></Card>
      </div>
      <Dialog
        title={t("motions.falls.title")} open={asks} onClose={() => ask(false)}
        actions={<><Button kind="quiet" autofocus onClick={() => ask(false)}>{t("dialog.cancel")}</Button><Button kind="danger" icon="play" onClick={() => { ask(false); play(); }}>{t("motions.falls.yes")}</Button></>}
      >
        <p>{report?.falls_s != null ? t("motions.falls.text", { robot: model.robot, s: number(report.falls_s, 1), frame: report.falls_frame ?? 0 }) : t(report?.stands ? "motions.falls.led" : "motions.falls.begins", { robot: model.robot })}</p>
      </Dialog>
    </div>
  );
}

/** Whether it stands, from the pose that the robot has now. */
const safe = (report: Report): boolean => report.stands && !report.led;
const NARROW = matchMedia("(max-width: 1039.98px)");

/** Whether the drawing and what turns its joints stand in one column. */
function useNarrow(): boolean {
  const [narrow, note] = useState(NARROW.matches);
  useEffect(() => {
    const changed = (): void => note(NARROW.matches);
    NARROW.addEventListener("change", changed);
    return () => NARROW.removeEventListener("change", changed);
  }, []);
  return narrow;
}

/** Begins to watch; what it returns says whether nothing was touched since, and the page was seen all the time. */
function watchTouches(): () => boolean {
  let calm = true;
  const note = (event: Event): void => { if (event.type !== "blur" || event.target === window) calm = false; };
  const kinds = ["pointerdown", "keydown", "visibilitychange", "blur"] as const;
  for (const kind of kinds) window.addEventListener(kind, note, { capture: true });
  return () => {
    for (const kind of kinds) window.removeEventListener(kind, note, { capture: true });
    return calm && !document.hidden;
  };
}

const zero = (model: BodyModel): Record<string, number> => Object.fromEntries(jointNames(model).map((name) => [name, clamp(model, name, 0)]));
const clamp = (model: BodyModel, name: string, rad: number): number => Math.min(model.joints[name]?.upper ?? rad, Math.max(model.joints[name]?.lower ?? rad, rad));

type Act = "add" | "copy" | "cut" | "paste" | "double" | "remove" | "mirror" | "earlier" | "later" | "undo" | "redo";
type Acts = Record<Act, () => void> & { go: (by: number) => void };

/** Keys, where nothing is typed; space and Escape stay the robot's stop. */
function useKeys(acts: Acts): void {
  const newest = useRef(acts);
  newest.current = acts;
  useEffect(() => {
    const press = (event: KeyboardEvent): void => {
      const target = event.target instanceof Element ? event.target : document.body;
      if (target.closest(TYPED) || document.querySelector("[role=dialog]")) return;
      if (target.closest("input[type=range]") && event.key.startsWith("Arrow")) return;
      const act = meant(event);
      if (!act) return;
      event.preventDefault();
      if (typeof act === "number") newest.current.go(act);
      else newest.current[act]();
    };
    window.addEventListener("keydown", press);
    return () => window.removeEventListener("keydown", press);
  }, []);
}

function meant(event: KeyboardEvent): Act | number | null {
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (key === "z") return event.shiftKey ? "redo" : "undo";
    return ({ y: "redo", c: "copy", x: "cut", v: "paste", d: "double" } as const)[key as "y"] ?? null;
  }
  if (event.altKey) return key === "arrowleft" ? "earlier" : key === "arrowright" ? "later" : null;
  if (key === "arrowleft" || key === "arrowright") return key === "arrowleft" ? -1 : 1;
  if (key === "home" || key === "end") return key === "home" ? -Infinity : Infinity;
  return ({ delete: "remove", backspace: "remove", insert: "add", a: "add", m: "mirror" } as const)[key as "m"] ?? null;
}

function Tools({ acts, frame, children }: { acts: Acts; frame: boolean; children: preact.ComponentChildren }) {
  const last = index.value >= sheet.value.frames.length - 1;
  return (
    <div class="motions-tools" role="toolbar" aria-label={t("motions.tools")}>
      {children}
      <Button icon="plus" onClick={acts.add}>{t("motions.add.same")}</Button>
      <span class="motions-some">
        <Button icon="copy" label={t("motions.copy")} disabled={!frame} onClick={acts.copy} />
        <Button icon="paste" label={t("motions.paste")} disabled={!clip.value} onClick={acts.paste} />
        <Button icon="double" label={t("motions.double")} disabled={!frame} onClick={acts.double} />
        <Button icon="mirror" label={t("motions.mirror.do")} disabled={!frame} onClick={acts.mirror} />
        <Button icon="back" class="motions-left" label={t("motions.earlier")} disabled={index.value === 0} onClick={acts.earlier} />
        <Button icon="ahead" class="motions-right" label={t("motions.later")} disabled={last} onClick={acts.later} />
        <Button icon="trash" label={t("motions.remove")} disabled={!frame} onClick={acts.remove} />
      </span>
      <span class="motions-some">
        <Button kind="quiet" icon="undo" label={t("motions.undo")} disabled={!canUndo.value} onClick={acts.undo} />
        <Button kind="quiet" icon="redo" label={t("motions.redo")} disabled={!canRedo.value} onClick={acts.redo} />
      </span>
    </div>
  );
}

function One({ joint, model, value, onPut, other }: { joint: string; model: BodyModel; value: number; onPut: (positions: Record<string, number>) => void; other: string }) {
  const range = model.joints[joint];
  const [typed, type] = useState<string | null>(null);
  const deg = (rad: number): string => String(Math.round((1800 * rad) / Math.PI) / 10);
  const [lower, upper] = [range?.lower ?? -Math.PI, range?.upper ?? Math.PI];
  const take = (text: string): void => {
    const rad = (Number(text.replace(",", ".")) * Math.PI) / 180;
    if (text.trim() !== "" && Number.isFinite(rad)) onPut({ [joint]: clamp(model, joint, rad) });
    type(null);
  };
  const edge = Math.min(value - lower, upper - value) < Math.PI / 360;
  return (
    <>
      <Slider label={jointName(joint)} min={lower} max={upper} step={Math.PI / 360} value={value} show={(rad) => degrees(rad, 1)} onInput={(rad) => onPut({ [joint]: rad })} />
      <div class="motions-number">
        <Field label={t("motions.angle")} inputMode="decimal" value={typed ?? deg(value)} onInput={(event) => type(event.currentTarget.value)} onKeyDown={(event) => { if (event.key === "Enter") take(event.currentTarget.value); }} onBlur={(event) => { if (typed !== null) take(event.currentTarget.value); }} />
        <Badge tone={edge ? "warn" : "calm"} icon={edge ? "warn" : undefined}>{t("motions.range", { lower: degrees(lower), upper: degrees(upper) })}</Badge>
      </div>
      {other && <Button onClick={() => onPut({ [other]: clamp(model, other, value) })}>{t("motions.other.side")}</Button>}
    </>
  );
}

/** Plays it on the puppet. */
function Preview({ whole, time, onTime }: { whole: number; time: number | null; onTime: (s: number | null) => void }) {
  const frame = useRef(0);
  const [plays, setPlays] = useState(false);
  const stop = (): void => { cancelAnimationFrame(frame.current); setPlays(false); onTime(null); };
  useEffect(() => () => cancelAnimationFrame(frame.current), []);
  const play = (): void => {
    const begun = performance.now() - 1000 * (time !== null && time < whole - 0.05 ? time : 0);
    setPlays(true);
    const step = (at: number): void => {
      const s = (at - begun) / 1000;
      if (s > whole + 0.4) return stop();
      onTime(Math.max(0, s));
      frame.current = requestAnimationFrame(step);
    };
    frame.current = requestAnimationFrame(step);
  };
  return plays
    ? <Button icon="pause" onClick={stop}>{t("motions.preview.end")}</Button>
    : <Button kind="primary" icon="play" disabled={whole === 0} onClick={play}>{t("motions.preview")}</Button>;
}
