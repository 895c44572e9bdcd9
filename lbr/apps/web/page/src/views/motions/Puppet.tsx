// The body as a puppet: it takes the pose that it is given, and a limb that is dragged tells where it was put.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { Button, Icon } from "../../parts";
import { t } from "../../words";
import { stageColours } from "../joints/Body3d";
import type { BodyModel } from "../joints/model";
import { choose, solid } from "../joints/solid";
import type { Stage } from "../joints/stage";
import { Figure } from "./Figure";

interface Lean { roll_rad: number; pitch_rad: number }
/** `tilt` is how the simulated body leant, `live`: it is the robot's own pose. */
interface Props { model: BodyModel; pose: Record<string, number>; tilt: Lean | null; selected: string; drags: boolean; live: boolean; onPick: (joint: string) => void; onDrag: (joint: string, rad: number) => void }

export function Puppet(props: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const stage = useRef<Stage | null>(null);
  const newest = useRef(props);
  newest.current = props;
  const [failed, fail] = useState(false);
  const [ready, setReady] = useState(false);
  const { model, pose, selected, drags, tilt, live } = props;
  useEffect(() => {
    if (!solid.value) return undefined;
    let ended = false;
    void import("../joints/stage").then(({ Stage: Made }) => {
      if (ended || !canvas.current) return;
      stage.current = new Made(canvas.current, model, stageColours(), {
        onPick: (joint) => newest.current.onPick(joint),
        onDrag: (joint, rad) => { newest.current.onDrag(joint, rad); return true; },
        onDrop: () => undefined,
      });
      (canvas.current as HTMLCanvasElement & { stage?: Stage }).stage = stage.current;
      stage.current.setTones(Object.fromEntries(Object.keys(model.joints).map((name) => [name, "limp" as const])));
      setReady(true);
    }).catch(() => fail(true));
    return () => {
      ended = true;
      stage.current?.dispose();
      stage.current = null;
    };
  }, [model, solid.value]);
  const whole = useMemo(() => {
    const zero = Object.fromEntries(Object.entries(model.joints).map(([name, range]) => [name, Math.min(range.upper ?? 0, Math.max(range.lower ?? 0, 0))]));
    return { ...zero, ...pose };
  }, [model, pose]);
  useEffect(() => stage.current?.setPose(whole, {}), [whole, ready]);
  useEffect(() => stage.current?.setTilt(tilt?.roll_rad ?? null, tilt?.pitch_rad ?? null), [tilt?.roll_rad, tilt?.pitch_rad, ready]);
  useEffect(() => stage.current?.select(selected), [selected, ready]);
  useEffect(() => stage.current?.setDrag(drags), [drags, ready]);
  const flat = failed || !solid.value;
  return (
    <div class="joints-stage motions-puppet" data-ready={ready || flat}>
      {flat ? <Figure model={model} pose={whole} selected={selected} onPick={props.onPick} onDrag={drags ? props.onDrag : undefined} /> : <canvas ref={canvas} class="joints-canvas" role="img" aria-label={t("motions.puppet")} />}
      {live && <p class="motions-live"><Icon name="link" />{t("motions.live")}</p>}
      {flat && !failed && <div class="joints-stage-side"><Button kind="quiet" onClick={() => choose(true)}>{t("joints.solid")}</Button></div>}
      <p class="joints-stage-hint">{t(flat ? (drags ? "joints.flat.drag" : "joints.flat") : tilt ? "motions.puppet.simulated" : live ? "motions.puppet.live" : "motions.puppet.hint")}</p>
    </div>
  );
}
