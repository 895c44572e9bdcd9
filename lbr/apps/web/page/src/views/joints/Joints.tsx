// The joints: the body in three dimensions, each joint's angle and torque, and what else tells how the robot is.
import { useEffect, useMemo, useState } from "preact/hooks";
import { Held } from "../../handover";
import { holding } from "../../holding";
import { plain } from "../../format";
import { Badge, Button, Card, Dialog, Empty, Icon, InTurn, Segments, Stale, Toggle } from "../../parts";
import { told } from "../../access";
import { Mend } from "../../mend";
import { illness } from "../../lacking";
import { listen } from "../../live";
import { useNews } from "../../news";
import { toldLately } from "../../notices";
import { command, may, robot } from "../../robot";
import { estop, toldStop } from "../../stopping";
import { learn, t } from "../../words";
import { joints as jointsWords } from "../../words/joints";
import { motions as motionsWords } from "../../words/motions";
import { Body3d } from "./Body3d";
import { Boxes } from "./boxes";
import { Deeds } from "./Deeds";
import { jointStreams, listenJoints, useJoints, type Joints as AllJoints } from "./hooks";
import "./Joints.css";
import { body, jointNames, loadBody, mirrored, type BodyModel, type JointsState, type Side } from "./model";
import { aims, Movers, speed, SPEEDS, type Speed } from "./mover";
import { Row } from "./Row";
import { positions } from "./state";
import { BAD, toneOf, torques } from "./tone";

learn(jointsWords);
learn(motionsWords);

const SIDES: Side[] = ["right", "left", "centre"];

export default function Joints() {
  const revision = String(robot.value?.revision ?? 0);
  useEffect(() => void loadBody(revision), [revision]);
  const model = body.value;
  if (!model) return <div class="loading" role="status"><div class="pulse" />{t("shell.loading")}</div>;
  return <Shown model={withRows(model)} />;
}

let kept: [BodyModel, unknown, BodyModel] | null = null;

/** The model, with joints of the robot's rows where the body could not be had: the list works without it. */
function withRows(model: BodyModel): BodyModel {
  const rows = (robot.value?.joints ?? []) as { name: string; side?: Side; lower_rad: number; upper_rad: number; speed_rps?: number }[];
  if (kept && kept[0] === model && kept[1] === rows) return kept[2];
  const missing = rows.filter((row) => !(row.name in model.joints));
  const joints = Object.fromEntries(missing.map((row) => [row.name, { lower: row.lower_rad, upper: row.upper_rad, kind: "hinge" as const, side: row.side ?? "centre", speed_rps: row.speed_rps ?? null, drawn: false }]));
  const whole = missing.length ? { ...model, joints: { ...model.joints, ...joints } } : model;
  kept = [model, rows, whole];
  return whole;
}

function Shown({ model }: { model: BodyModel }) {
  const streams = jointStreams();
  const joints = useJoints(streams);
  const state = joints?.state;
  const [selected, select] = useState("");
  const [both, setBoth] = useState(false);
  const mover = useMemo(() => new Movers(), []);
  const names = jointNames(model);
  const operates = may("operate");
  const fresh = useNews(state ? whyNot(state) : null);
  const lost = state?.phase === "holding" || state?.phase === "releasing";

  useEffect(() => listenJoints(streams, (all) => mover.seen(positions(all.state)), listen), [streams.join(" ")]);
  useEffect(() => holding.state.subscribe((now) => { if (!now.moving) mover.forget(); }), [mover]);
  useEffect(() => () => { if (!holding.state.value.to.endsWith("/play")) holding.release(); mover.forget(); }, [mover]); // what is played goes on in other views

  const aim = (joint: string, rad: number, held: boolean): boolean => {
    const range = model.joints[joint];
    const from = state?.joints[joint]?.position_rad ?? null;
    const owner = joints?.owners[joint] ?? "";
    const rps = Math.min(SPEEDS[speed.value], range?.speed_rps ?? Infinity);
    const within = (name: string): number => Math.min(model.joints[name]?.upper ?? rad, Math.max(model.joints[name]?.lower ?? rad, rad));
    if (!owner || !mover.aim(owner, joint, within(joint), from, rps, held)) return false;
    const other = both ? mirrored(joint, names) : "";
    return other && joints?.owners[other] === owner ? mover.aim(owner, other, within(other), state?.joints[other]?.position_rad ?? null, rps, false) : true;
  };
  const torque = (named: string[], on: boolean): void => {
    for (const [owner, group] of byOwner(joints, named)) void command(owner, "torque", { on, joints: group });
  };
  const recover = (named: string[]): void => {
    for (const [owner, group] of byOwner(joints, named)) void command(owner, "recover", { joints: group });
  };
  const pick = (joint: string): void => {
    select(joint);
    if (joint) requestAnimationFrame(() => document.querySelector(`.joints-row[data-joint="${joint}"]`)?.scrollIntoView({ block: "nearest", behavior: "smooth" }));
  };

  if (names.length === 0) return <Empty icon="joints" title={t("joints.none")}>{model.reason && <p>{model.reason}</p>}</Empty>;
  const groups = grouped(names, model, joints?.owners ?? {});
  const owned = [...new Set(Object.values(joints?.owners ?? {}))];
  const sick = owned.map(illness).find(Boolean) ?? "";
  const now = state && !estop.value.engaged && !state.moving && (fresh || lost) ? whyNot(state) : "";
  const why = sick || (toldLately(now) || toldStop(state?.code) ? "" : now);
  return (
    <div class="joints">
      <div class="joints-left">
        {model.links.length > 0
          ? <Body3d model={model} streams={streams} selected={selected} may={operates} onPick={pick} onDrag={(joint, rad) => aim(joint, rad, true)} onDrop={() => mover.drop()} />
          : <div class="joints-stage"><Empty icon="joints" title={t("joints.nobody")}><p>{model.reason}</p></Empty></div>}
        {owned.map((owner) => <Held key={owner} capability={owner} />)}
        {why ? <div class="joints-why" role="status"><Icon name="info" /><p>{why}</p><Mend code={sick ? "unwell" : state!.code ?? ""} /></div> : null}
      </div>
      <div class="joints-right">
        <Deeds said={why} at={state ? positions(state) : {}} />
        <InTurn>
          <Torque names={names} model={model} joints={joints} onRecover={recover} />
          <Moving both={both} onBoth={setBoth} may={operates} pairs={names.some((name) => mirrored(name, names))} />
          <div class="joints-groups">
            <InTurn>
              {groups.map(([title, group]) => (
                <Card key={title} class="joints-group" title={title} actions={<Locks group={group} state={state} may={operates} onTorque={torque} title={title} />}>
                  <ul class="joints-list">
                    {group.map((name) => (
                      <Row
                        key={name} name={name} range={model.joints[name]!} state={state?.joints[name]} aim={aims.value[name]} selected={name === selected} may={operates && !estop.value.engaged}
                        onPick={pick} onMove={aim} onTorque={(joint, on) => torque([joint], on)} onRecover={(joint) => recover([joint])}
                      />
                    ))}
                  </ul>
                </Card>
              ))}
            </InTurn>
          </div>
          <div class="joints-boxes"><Boxes /></div>
        </InTurn>
      </div>
    </div>
  );
}

/** By side; where all are in the middle, by the capability that moves them. */
function grouped(names: string[], model: BodyModel, owners: Record<string, string>): [string, string[]][] {
  const several = new Set(Object.values(owners)).size > 1 && names.every((name) => model.joints[name]!.side === "centre");
  if (several) return [...new Set(Object.values(owners))].map((owner) => [plain(owner), names.filter((name) => owners[name] === owner)]);
  return SIDES.map((side): [string, string[]] => [t(`joints.side.${side}`), names.filter((name) => model.joints[name]!.side === side)]).filter(([, group]) => group.length > 0);
}

/** Joints by the capability that moves them. */
function byOwner(joints: AllJoints | null, named: string[]): Map<string, string[]> {
  const found = new Map<string, string[]>();
  for (const name of named) {
    const owner = joints?.owners[name];
    if (owner) found.set(owner, [...(found.get(owner) ?? []), name]);
  }
  return found;
}

/** What is as it should be, what an alarm above tells, and the end of a motion, of which its page tells. */
const SAID_ELSEWHERE = new Set(["done", "idle", "superseded", "cancelled", "released", "estop", "lapsed", "holder_gone"]);

/** Why the joints do not move, by the code and sentence of the robot; empty while nothing is wrong. */
function whyNot(state: JointsState): string {
  if (!state.code || SAID_ELSEWHERE.has(state.code)) return "";
  return told({ code: state.code, reason: state.reason ?? "" });
}

function Moving({ both, onBoth, may: operates, pairs }: { both: boolean; onBoth: (on: boolean) => void; may: boolean; pairs: boolean }) {
  if (!operates) return <p class="joints-why"><Icon name="info" />{t("joints.look.only")}</p>;
  return (
    <div class="joints-moving">
      <Segments<Speed> label={t("joints.speed")} value={speed.value} onChange={(value) => { speed.value = value; }} options={(["slow", "normal", "fast"] as const).map((value) => ({ value, text: t(`joints.speed.${value}`) }))} />
      {pairs && <Toggle label={t("joints.both")} checked={both} onChange={onBoth} />}
    </div>
  );
}

function Locks({ group, state, may: operates, onTorque, title }: { group: string[]; state?: JointsState; may: boolean; onTorque: (joints: string[], on: boolean) => void; title: string }) {
  const { held, limp } = torques(group, state?.joints);
  return (
    <>
      <Button kind="quiet" icon="bolt" label={t("joints.lock.side", { side: title })} disabled={!operates || !state || held === group.length} onClick={() => onTorque(group, true)} />
      <Button kind="quiet" icon="power" label={t("joints.release.side", { side: title })} disabled={!operates || !state || limp === group.length} onClick={() => onTorque(group, false)} />
    </>
  );
}

function Torque({ names, model, joints, onRecover }: { names: string[]; model: BodyModel; joints: ReturnType<typeof useJoints>; onRecover: (joints: string[]) => void }) {
  const [asks, ask] = useState(false);
  const state = joints?.state;
  const { held, limp, unknown } = torques(names, state?.joints);
  const bad = names.filter((name) => BAD.has(toneOf(state?.joints[name]))).length;
  const latched = names.filter((name) => state?.joints[name]?.latched?.length);
  const operates = may("operate") && state !== undefined;
  const all = (on: boolean): void => {
    ask(false);
    for (const owner of new Set(Object.values(joints?.owners ?? {}))) void command(owner, "torque", on ? { on } : { on, confirmed: true });
  };
  return (
    <section class="joints-summary" aria-label={t("joints.torque")}>
      <p class="joints-badges">
        {state && bad === 0 && held === names.length && <Badge tone="good" icon="check">{t("joints.all.held", { count: names.length })}</Badge>}
        {limp > 0 && <Badge tone="warn" icon="power">{t("joints.some.limp", { count: limp, of: names.length })}</Badge>}
        {state && unknown > 0 && <Badge tone="warn" icon="info">{t("joints.some.unknown", { count: unknown, of: names.length })}</Badge>}
        {bad > 0 && <Badge tone="bad" icon="warn">{t("joints.some.bad", { count: bad })}</Badge>}
        <Stale sample={joints} />
      </p>
      <div class="joints-actions">
        {latched.length > 0 && <Button icon="restart" disabled={!operates} onClick={() => onRecover(latched)}>{t("joints.recover.all")}</Button>}
        <Button icon="bolt" disabled={!operates || held === names.length} onClick={() => all(true)}>{t("joints.lock.all")}</Button>
        <Button kind="danger" icon="power" disabled={!operates || limp === names.length} onClick={() => ask(true)}>{t("joints.release.all")}</Button>
      </div>
      <Dialog
        title={t("joints.release.title")} open={asks} onClose={() => ask(false)}
        actions={<>
          <Button kind="quiet" autofocus onClick={() => ask(false)}>{t("dialog.cancel")}</Button>
          <Button kind="danger" icon="power" onClick={() => all(false)}>{t("joints.release.yes")}</Button>
        </>}
      >
        <p>{t("joints.release.text", { robot: model.robot })}</p>
      </Dialog>
    </section>
  );
}
