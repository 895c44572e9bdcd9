// The body as a puppet: it takes the pose that it is given, and a limb that is dragged tells where it was put.
import { useEffect, useRef, useState } from "preact/hooks";
import { t } from "../../words";
import { stageColours } from "../joints/Body3d";
import type { BodyModel } from "../joints/model";
import type { Stage } from "../joints/stage";
import { Figure } from "./Figure";

interface Props { model: BodyModel; pose: Record<string, number>; selected: string; drags: boolean; onPick: (joint: string) => void; onDrag: (joint: string, rad: number) => void }

export function Puppet(props: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const stage = useRef<Stage | null>(null);
  const newest = useRef(props);
  newest.current = props;
  const [flat, goFlat] = useState(false);
  const [ready, setReady] = useState(false);
  const { model, pose, selected, drags } = props;
  useEffect(() => {
    let ended = false;
    void import("../joints/stage").then(({ Stage: Made, drawable }) => {
      if (ended || !canvas.current) return;
      if (!drawable()) return goFlat(true);
      stage.current = new Made(canvas.current, model, stageColours(), {
        onPick: (joint) => newest.current.onPick(joint),
        onDrag: (joint, rad) => { newest.current.onDrag(joint, rad); return true; },
        onDrop: () => undefined,
      });
      (canvas.current as HTMLCanvasElement & { stage?: Stage }).stage = stage.current;
      stage.current.setTones(Object.fromEntries(Object.keys(model.joints).map((name) => [name, "limp" as const])));
      setReady(true);
    }).catch(() => goFlat(true));
    return () => {
      ended = true;
      stage.current?.dispose();
      stage.current = null;
    };
  }, [model]);
  useEffect(() => {
    const zero = Object.fromEntries(Object.entries(model.joints).map(([name, range]) => [name, Math.min(range.upper ?? 0, Math.max(range.lower ?? 0, 0))]));
    stage.current?.setPose({ ...zero, ...pose }, {});
  }, [pose, ready]);
  useEffect(() => stage.current?.select(selected), [selected, ready]);
  useEffect(() => stage.current?.setDrag(drags), [drags, ready]);
  return (
    <div class="joints-stage motions-puppet" data-ready={ready || flat}>
      {flat ? <Figure model={model} pose={pose} /> : <canvas ref={canvas} class="joints-canvas" role="img" aria-label={t("motions.puppet")} />}
      {!flat && <p class="joints-stage-hint">{t("motions.puppet.hint")}</p>}
    </div>
  );
}
