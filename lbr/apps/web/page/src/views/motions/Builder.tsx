// The motion builder: key frames on a time line, posed by dragging a puppet, by sliders or as the robot stands; played on the
// puppet first, then on the robot.
import { signal } from "@preact/signals";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { degrees, number, plain } from "../../format";
import { holding } from "../../holding";
import { remember, remembered } from "../../kept";
import { notice } from "../../notices";
import { Badge, Button, Card, Choice, Field, Slider } from "../../parts";
import { fetchJson, may, robot } from "../../robot";
import { estop } from "../../stopping";
import { t } from "../../words";
import { jointStreams, useJoints } from "../joints/hooks";
import { jointNames, mirrored, type BodyModel } from "../joints/model";
import type { KeyFrame, Motion, MotionRow } from "./data";
import { Figure } from "./Figure";
import { Puppet } from "./Puppet";
import { added, EMPTY, faults, good, lasts, mirroredFrame, nameFrom, poseAt, poseOver, read, removed, replaced, shifted, SHORTEST_S, smoothed, type Sheet } from "./sheet";

const KEPT = "motion.draft";
const sheet = signal<Sheet>(remembered<Sheet>(KEPT, EMPTY));
const before = signal<Sheet[]>([]);
const MOST_BACK = 40;

function change(next: Sheet): void {
  if (next === sheet.value) return;
  before.value = [...before.value, sheet.value].slice(-MOST_BACK);
  sheet.value = next;
  remember(KEPT, next);
}

function back(): void {
  const last = before.value.at(-1);
  if (!last) return;
  before.value = before.value.slice(0, -1);
  sheet.value = last;
  remember(KEPT, last);
}

export function Builder({ model, motions }: { model: BodyModel; motions: MotionRow[] }) {
  const now = sheet.value;
  const [at, choose] = useState(0);
  const [joint, pick] = useState("");
  const [time, setTime] = useState<number | null>(null);
  const names = jointNames(model);
  const streams = jointStreams();
  const state = useJoints(streams, 250)?.state;
  const index = Math.min(at, Math.max(0, now.frames.length - 1));
  const frame = now.frames[index];
  const pose = useMemo(() => (time === null ? poseAt(now.frames, index) : poseOver(now.frames, time)), [now, index, time]);
  const wrong = useMemo(() => faults(now.frames, model), [now, model]);
  const limits = wrong.filter((one) => one.kind === "limit");
  const can = may("operate") && !estop.value.engaged;
  const owner = streams[0]?.split("/")[0] ?? "joints";

  const measured = (): Record<string, number> => Object.fromEntries(Object.entries(state?.joints ?? {}).flatMap(([name, one]) => (one.position_rad == null ? [] : [[name, clamp(model, name, one.position_rad)]])));
  const put = (positions: Record<string, number>): void => { if (frame) change(replaced(now, index, { positions: { ...frame.positions, ...positions } })); };
  const append = (positions: Record<string, number>): void => {
    const place = now.frames.length ? index + 1 : 0;
    change(added(now, place, { positions, duration_s: 1 }));
    choose(place);
  };
  const robotPlay = (): void => holding.play(`${owner}/command`, { frames: now.frames, interpolation: "smooth" });

  return (
    <div class="motions-builder">
      <div class="motions-build-main">
        {model.links.length > 0 && <Puppet model={model} pose={pose} selected={joint} drags={time === null && frame !== undefined} onPick={pick} onDrag={(name, rad) => put({ [name]: rad })} />}
        <Line now={now} index={index} time={time} model={model} wrong={new Set(limits.map((one) => one.frame))} onChoose={(to) => { setTime(null); choose(to); }} />
        <div class="motions-tools" role="toolbar" aria-label={t("motions.tools")}>
          <Preview whole={lasts(now.frames)} time={time} onTime={setTime} />
          <Button icon="camera" disabled={!state} onClick={() => append(measured())}>{t("motions.add.robot")}</Button>
          <Button icon="joints" onClick={() => append(frame ? poseAt(now.frames, index) : zero(model))}>{t("motions.add.same")}</Button>
          <Button icon="back" class="motions-left" label={t("motions.earlier")} disabled={index === 0} onClick={() => { change(shifted(now, index, -1)); choose(index - 1); }} />
          <Button icon="ahead" class="motions-right" label={t("motions.later")} disabled={index >= now.frames.length - 1} onClick={() => { change(shifted(now, index, 1)); choose(index + 1); }} />
          <Button icon="mirror" disabled={!frame} onClick={() => frame && change(replaced(now, index, mirroredFrame({ ...frame, positions: poseAt(now.frames, index) }, names)))}>{t("motions.mirror.do")}</Button>
          <Button icon="motions" disabled={now.frames.length < 3} onClick={() => change(smoothed(now))}>{t("motions.smooth")}</Button>
          <Button kind="quiet" icon="trash" label={t("motions.remove")} disabled={!frame} onClick={() => { change(removed(now, index)); choose(Math.max(0, index - 1)); }} />
          <Button kind="quiet" icon="turnleft" label={t("motions.undo")} disabled={before.value.length === 0} onClick={back} />
        </div>
      </div>
      <div class="motions-build-side">
        {frame && (
          <Card title={t("motions.frame.at", { frame: index + 1, of: now.frames.length })} icon="joints">
            <Slider label={t("motions.keep.lasts")} min={SHORTEST_S} max={5} step={0.1} value={frame.duration_s} show={(value) => `${number(value, 1)} s`} onInput={(value) => change(replaced(now, index, { duration_s: value }))} />
            <Choice label={t("motions.joint")} value={joint} options={[{ value: "", text: t("motions.joint.none") }, ...names.map((name) => ({ value: name, text: plain(name) }))]} onChange={pick} />
            {joint && <One joint={joint} model={model} value={pose[joint] ?? 0} onPut={put} other={mirrored(joint, names)} />}
          </Card>
        )}
        <Card title={t("motions.file")} icon="save">
          <Field label={t("motions.keep.name")} value={now.name} maxLength={40} placeholder="bow" autocomplete="off" onInput={(event) => { sheet.value = { ...now, name: nameFrom(event.currentTarget.value) }; remember(KEPT, sheet.value); }} />
          <p class="motions-badges">
            <Badge>{t("motions.frames", { count: now.frames.length })}</Badge><Badge>{number(lasts(now.frames), 1)} s</Badge>
            {limits.length > 0 && <Badge tone="bad" icon="warn">{t("motions.wrong.limit", { joint: plain(limits[0]!.joint), value: degrees(limits[0]!.value), most: degrees(limits[0]!.most) })}</Badge>}
            {limits.length === 0 && wrong.length > 0 && <Badge tone="warn" icon="speed">{t("motions.wrong.speed", { joint: plain(wrong[0]!.joint) })}</Badge>}
          </p>
          <div class="joints-actions">
            <Button kind="primary" icon="play" disabled={!can || now.frames.length === 0 || limits.length > 0} onClick={robotPlay}>{t("motions.on.robot")}</Button>
            <Save now={now} bad={limits.length > 0} known={motions.some((one) => one.name === now.name)} />
          </div>
          <Files model={model} motions={motions} onOpen={(opened) => { change(opened); choose(0); }} />
        </Card>
      </div>
    </div>
  );
}

const zero = (model: BodyModel): Record<string, number> => Object.fromEntries(jointNames(model).map((name) => [name, clamp(model, name, 0)]));
const clamp = (model: BodyModel, name: string, rad: number): number => Math.min(model.joints[name]?.upper ?? rad, Math.max(model.joints[name]?.lower ?? rad, rad));

function One({ joint, model, value, onPut, other }: { joint: string; model: BodyModel; value: number; onPut: (positions: Record<string, number>) => void; other: string }) {
  const range = model.joints[joint];
  return (
    <>
      <Slider label={plain(joint)} min={range?.lower ?? -3.1} max={range?.upper ?? 3.1} step={Math.PI / 360} value={value} show={(rad) => degrees(rad, 1)} onInput={(rad) => onPut({ [joint]: rad })} />
      {other && <Button onClick={() => onPut({ [other]: clamp(model, other, value) })}>{t("motions.other.side")}</Button>}
    </>
  );
}

/** The key frames, each as wide as it lasts. */
function Line({ now, index, time, model, wrong, onChoose }: { now: Sheet; index: number; time: number | null; model: BodyModel; wrong: Set<number>; onChoose: (at: number) => void }) {
  if (now.frames.length === 0) return <p class="motions-hint motions-empty">{t("motions.build.empty")}</p>;
  const shown = now.frames.slice(0, 120);
  const whole = lasts(now.frames);
  return (
    <div class="motions-line">
      <ol role="listbox" aria-label={t("motions.line")}>
        {shown.map((frame, at) => (
          <li key={at} style={{ width: `${Math.round(Math.min(220, 74 + 30 * Math.max(0, frame.duration_s - 0.5)))}px` }}>
            <button type="button" role="option" aria-selected={at === index} class="motions-frame" data-wrong={wrong.has(at) || undefined} onClick={() => onChoose(at)}>
              <Thumb model={model} frames={now.frames} at={at} />
              <span>{at + 1} · {number(frame.duration_s, 1)} s</span>
            </button>
          </li>
        ))}
      </ol>
      {time !== null && <div class="motions-bar"><span style={{ width: `${(100 * time) / Math.max(0.1, whole)}%` }} /></div>}
    </div>
  );
}

function Thumb({ model, frames, at }: { model: BodyModel; frames: KeyFrame[]; at: number }) {
  const pose = useMemo(() => poseAt(frames, at), [frames, at]);
  return <Figure model={model} pose={pose} />;
}

/** Plays it on the puppet. */
function Preview({ whole, time, onTime }: { whole: number; time: number | null; onTime: (s: number | null) => void }) {
  const frame = useRef(0);
  const stop = (): void => { cancelAnimationFrame(frame.current); onTime(null); };
  useEffect(() => () => cancelAnimationFrame(frame.current), []);
  const play = (): void => {
    const begun = performance.now();
    const step = (at: number): void => {
      const s = (at - begun) / 1000;
      if (s > whole + 0.3) return stop();
      onTime(Math.max(0, s));
      frame.current = requestAnimationFrame(step);
    };
    frame.current = requestAnimationFrame(step);
  };
  return time === null
    ? <Button kind="primary" icon="play" disabled={whole === 0} onClick={play}>{t("motions.preview")}</Button>
    : <Button icon="pause" onClick={stop}>{t("motions.preview.end")}</Button>;
}

function Save({ now, bad, known }: { now: Sheet; bad: boolean; known: boolean }) {
  const save = async (): Promise<void> => {
    const answer = await fetchJson("api/motion", { method: "POST", body: { name: now.name, help: now.help, frames: now.frames, replace: known } });
    if (answer.ok) notice(t("motions.saved", { motion: plain(now.name) }), "good");
  };
  return <Button icon="save" disabled={!may("admin") || !good(now.name) || now.frames.length === 0 || bad} onClick={() => void save()}>{t(known ? "motions.replace" : "motions.save")}</Button>;
}

function Files({ model, motions, onOpen }: { model: BodyModel; motions: MotionRow[]; onOpen: (sheet: Sheet) => void }) {
  const input = useRef<HTMLInputElement>(null);
  const own = motions.filter((one) => one.slot == null);
  const names = jointNames(model);
  const open = async (name: string): Promise<void> => {
    const answer = await fetchJson<Motion>(`api/motion?motion=${encodeURIComponent(name)}`);
    if (answer.ok && answer.data) onOpen({ name: answer.data.name, help: answer.data.help ?? "", frames: answer.data.frames });
  };
  const take = async (file: File | undefined): Promise<void> => {
    if (!file) return;
    try {
      if (file.size > 4 << 20) throw new Error(`${Math.round(file.size / 1024)} kB`);
      onOpen(read(await file.text(), names));
    } catch (err) {
      notice(t("motions.no.motion", { file: file.name, why: err instanceof Error ? err.message : String(err) }), "warn");
    }
  };
  const export_ = (): void => {
    const now = sheet.value;
    const text = JSON.stringify({ format: "lbr-motion", robot: robot.value?.robot ?? "", motion: { name: now.name || "motion", help: now.help, frames: now.frames }, version: 1 }, null, 1);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
    link.download = `${now.name || "motion"}.json`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  };
  return (
    <>
      {own.length > 0 && <Choice label={t("motions.open")} value="" options={[{ value: "", text: "…" }, ...own.map((one) => ({ value: one.name, text: plain(one.name) }))]} onChange={(name) => { if (name) void open(name); }} />}
      <div class="joints-actions">
        <Button onClick={() => input.current?.click()}>{t("motions.import")}</Button>
        <Button disabled={sheet.value.frames.length === 0} onClick={export_}>{t("motions.export")}</Button>
        <Button kind="quiet" disabled={sheet.value.frames.length === 0} onClick={() => onOpen(EMPTY)}>{t("motions.new")}</Button>
      </div>
      <input ref={input} type="file" accept=".json,application/json" hidden aria-label={t("motions.import")} onChange={(event) => { void take(event.currentTarget.files?.[0]); event.currentTarget.value = ""; }} />
    </>
  );
}
