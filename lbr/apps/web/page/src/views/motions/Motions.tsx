// The motions: a picture of each, played with speed and mirrored where the robot offers that; the remote control's keys; poses
// kept by hand.
import { signal } from "@preact/signals";
import { useEffect, useMemo, useState } from "preact/hooks";
import { number, plain } from "../../format";
import { Held } from "../../handover";
import { holding } from "../../holding";
import { Badge, Button, Card, Empty, Field, Icon, Segments, Slider, Toggle } from "../../parts";
import { capabilities, command, may, robot, streamOfType } from "../../robot";
import { estop } from "../../stopping";
import { deedName, learn, t } from "../../words";
import { motions as motionsWords } from "../../words/motions";
import { joints as jointsWords } from "../../words/joints";
import { ownerOf, useCalm } from "../joints/hooks";
import { body, loadBody, type BodyModel } from "../joints/model";
import { Builder } from "./Builder";
import { buttons, endPlay, hasPad, keycap, loadPoses, ordered, PAD, poses, Progress, rows, type ButtonRow, type MotionRow, type MotionsState } from "./data";
import { Figure } from "./Figure";
import { Playing } from "./Playing";
import "../joints/Joints.css";
import "./Motions.css";

learn(motionsWords);
learn(jointsWords);

const speed = signal(1);
const mirror = signal(false);
const times = signal(1);
const TIMES = ["1", "2", "3", "5", "10"] as const;

export default function Motions() {
  const revision = String(robot.value?.revision ?? 0);
  useEffect(() => {
    void loadBody(revision);
    void loadPoses(revision);
  }, [revision]);
  const stream = streamOfType("MotionsState");
  const owner = ownerOf(stream) || capabilities("motions")[0]?.name || "motions";
  const state = useCalm<MotionsState>(stream)?.message;
  const [what, show] = useState<"play" | "build">("play");
  const progress = useMemo(() => new Progress(), []);
  const all = rows();
  const keys = buttons();
  const can = may("operate") && !estop.value.engaged;
  const play = (motion: string): void => {
    const row = all.find((one) => one.name === motion);
    const stored = row?.slot != null;
    holding.play(`${owner}/play`, { motion, times: times.value, ...(stored ? {} : { speed: speed.value, mirror: mirror.value }) });
  };
  const end = (): void => endPlay(owner);
  const part = progress.part(state);
  if (all.length === 0 && !body.value?.links.length) return <Empty icon="motions" title={t("motions.none")} />;
  const own = all.filter((one) => one.slot == null);
  const model = body.value;
  const tabs = model && model.links.length > 0 && (
    <Segments
      label={t("motions.what")} value={what} onChange={show}
      options={[{ value: "play", text: t("motions.play"), icon: "play" }, { value: "build", text: t("motions.build"), icon: "joints" }]}
    />
  );
  const holder = <><Held capability={owner} /><Playing state={state} part={part} model={model} onStop={end} /></>;
  if (what === "build" && model) {
    return <div class="motions-both"><h2 class="sr">{t("view.motions")}</h2>{tabs}{holder}<Builder model={model} motions={all} player={owner} /></div>;
  }
  return (
    <div class="motions-both">
    <h2 class="sr">{t("view.motions")}</h2>
    {tabs}
    {holder}
    <div class="motions" data-remote={keys.length > 0 || undefined}>
      <div class="motions-main">
        <Card class="motions-options">
          {own.length > 0 && <Slider label={t("motions.speed")} min={0.3} max={2} step={0.1} value={speed.value} show={(value) => `${number(value, 1)} ×`} onInput={(value) => { speed.value = value; }} />}
          {own.length > 0 && <Toggle label={t("motions.mirror")} checked={mirror.value} onChange={(on) => { mirror.value = on; }} />}
          <div class="motions-times">
            <span class="motions-label">{t("motions.times")}</span>
            <Segments label={t("motions.times")} value={String(times.value) as (typeof TIMES)[number]} onChange={(value) => { times.value = Number(value); }} options={TIMES.map((value) => ({ value, text: value }))} />
          </div>
          {own.length < all.length && (speed.value !== 1 || mirror.value) && <p class="motions-hint">{t("motions.stored")}</p>}
        </Card>
        <ul class="motions-list">
          {ordered(all).map((row) => <One key={row.name} row={row} model={body.value} cap={capOf(keys, row.name)} can={can} now={state?.playing && state.motion === row.name ? part : null} onPlay={() => play(row.name)} onStop={end} />)}
        </ul>
      </div>
      <div class="motions-side">
        {keys.length > 0 && <Remote all={keys} can={can} now={state?.playing ? state.motion ?? "" : ""} onPlay={play} />}
        {capabilities("motions").some((one) => "capture" in one.commands) && <Keep owner={owner} />}
      </div>
    </div>
    </div>
  );
}

/** The sign of the remote control's key that plays a motion; empty if there is none. */
function capOf(keys: ButtonRow[], motion: string): string {
  const key = keys.find((one) => one.motion === motion);
  return key ? keycap(key.button || String(key.id)) : "";
}

function One({ row, model, cap, can, now, onPlay, onStop }: { row: MotionRow; model: BodyModel | null; cap: string; can: boolean; now: number | null; onPlay: () => void; onStop: () => void }) {
  const pose = poses.value[row.name];
  const playing = now !== null;
  return (
    <li class="motions-one" data-playing={playing || undefined} data-motion={row.name}>
      <div class="motions-picture">{model && model.links.length > 0 && pose ? <Figure model={model} pose={pose} /> : cap ? <span class="motions-cap" aria-hidden="true">{cap}</span> : <Icon name="motions" />}</div>
      <div class="motions-text">
        <h3 class="motions-name">{deedName(row.name)}</h3>
        <p>{row.help}</p>
      </div>
      <p class="motions-facts">
        {row.duration_s != null && <span>{number(row.duration_s, row.duration_s < 10 ? 1 : 0)} s</span>}
        {row.slot != null ? <Badge>{t("motions.slot", { slot: row.slot })}</Badge> : row.frames != null && <span>{row.frames === 1 ? t("motions.frames.one") : t("motions.frames", { count: row.frames })}</span>}
      </p>
      {playing
        ? <Button class="motions-go" kind="danger" icon="stop" label={t("motions.end.one", { motion: deedName(row.name) })} onClick={onStop} />
        : <Button class="motions-go" kind="primary" icon="play" label={t("motions.play.one", { motion: deedName(row.name) })} disabled={!can} onClick={onPlay} />}
      {playing && <div class="motions-bar"><span style={{ width: `${100 * now}%` }} /></div>}
    </li>
  );
}

function Remote({ all, can, now, onPlay }: { all: ButtonRow[]; can: boolean; now: string; onPlay: (motion: string) => void }) {
  const pad = hasPad(all);
  const on = pad ? new Set<string>(PAD.flat()) : new Set<string>();
  const rest = all.filter((one) => !on.has(one.button ?? ""));
  const key = (one: ButtonRow) => (
    <button key={one.id} type="button" class="motions-key" aria-pressed={one.motion === now} disabled={!can} title={rows().find(({ name }) => name === one.motion)?.help || plain(one.motion ?? "")} onClick={() => onPlay(one.motion ?? "")}>
      <span class="motions-cap" aria-hidden="true">{keycap(one.button || String(one.id))}</span>
      <span class="motions-key-name">{deedName(one.motion || one.name)}</span>
    </button>
  );
  return (
    <Card title={t("motions.remote")} icon="gamepad">
      {pad && (
        <div class="motions-pad">
          {PAD.flat().map((code) => {
            const one = all.find((each) => each.button === code);
            return one ? key(one) : <span key={code} />;
          })}
        </div>
      )}
      <div class="motions-keys">{rest.map(key)}</div>
    </Card>
  );
}

/** Keeps the pose that the joints have now, as the next key frame of a motion. */
function Keep({ owner }: { owner: string }) {
  const [name, setName] = useState("");
  const [lasts, setLasts] = useState(1);
  const [kept, count] = useState(0);
  const clean = name.trim().toLowerCase().replaceAll(" ", "_");
  const good = /^[a-z][a-z0-9_]{0,39}$/.test(clean);
  const keep = async (): Promise<void> => {
    const answer = await command(owner, "capture", { motion: clean, duration_s: lasts });
    if (answer.ok) count(kept + 1);
  };
  return (
    <Card title={t("motions.keep")} icon="camera">
      <p class="motions-hint">{t("motions.keep.text")}</p>
      <Field label={t("motions.keep.name")} value={name} maxLength={40} placeholder="bow" autocomplete="off" onInput={(event) => { setName(event.currentTarget.value); count(0); }} />
      <Slider label={t("motions.keep.lasts")} min={0.2} max={5} step={0.1} value={lasts} show={(value) => `${number(value, 1)} s`} onInput={setLasts} />
      <Button kind="primary" icon="save" disabled={!good || !may("admin")} onClick={() => void keep()}>{t("motions.keep.do")}</Button>
      {kept > 0 && <p role="status"><Badge tone="good" icon="check">{t("motions.keep.done", { count: kept, motion: plain(clean) })}</Badge></p>}
    </Card>
  );
}
