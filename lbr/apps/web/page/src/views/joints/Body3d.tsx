// The body on a canvas: three is loaded when this is first shown. Until then, and without a graphics card, the same body is drawn flat.
import { useEffect, useRef, useState } from "preact/hooks";
import { watch } from "../../live";
import { Button, Segments } from "../../parts";
import { streamOfType } from "../../robot";
import { t } from "../../words";
import type { AttitudeState } from "../../messages";
import { Flat, Outline } from "./Flat";
import { listenJoints } from "./hooks";
import type { BodyModel, JointsState } from "./model";
import { aims } from "./mover";
import { choose, hasCard, solid } from "./solid";
import type { Colours, Stage } from "./stage";
import { goals, positions, tones } from "./state";

interface Props {
  model: BodyModel;
  streams: readonly string[];
  selected: string;
  may: boolean;
  onPick: (joint: string) => void;
  onDrag: (joint: string, rad: number) => boolean;
  onDrop: (joint: string) => void;
}

const coarse = (): boolean => matchMedia("(pointer: coarse)").matches;

/** The page's colours, for what is drawn on a canvas. */
export function stageColours(): Colours {
  const style = getComputedStyle(document.documentElement);
  const read = (name: string): string => style.getPropertyValue(name).trim() || "#888888";
  return { accent: read("--accent"), good: read("--good"), warn: read("--warn"), bad: read("--bad"), muted: read("--muted"), line: read("--line"), dark: style.colorScheme !== "light" };
}

export function Body3d(props: Props) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const stage = useRef<Stage | null>(null);
  const newest = useRef(props);
  newest.current = props;
  const [failed, fail] = useState(false);
  const [ready, setReady] = useState(false);
  const [mode, setMode] = useState<"look" | "pose">(() => (coarse() ? "look" : "pose"));
  const { model, streams, selected, may } = props;
  const key = streams.join(" ");
  const drags = may && mode === "pose";

  useEffect(() => {
    if (!solid.value) return undefined;
    let ended = false;
    const ends: (() => void)[] = [];
    void import("./stage").then(({ Stage: Made }) => {
      if (ended || !canvas.current) return;
      const made = new Made(canvas.current, model, stageColours(), {
        onPick: (joint) => newest.current.onPick(joint),
        onDrag: (joint, rad) => newest.current.onDrag(joint, rad),
        onDrop: (joint) => newest.current.onDrop(joint),
      });
      stage.current = made;
      (canvas.current as HTMLCanvasElement & { stage?: Stage }).stage = made;
      setReady(true);
      let measured: JointsState | null = null;
      const pose = (): void => {
        if (!measured) return;
        made.setPose(positions(measured), goals(measured, aims.value));
        made.setTones(tones(measured));
      };
      ends.push(listenJoints(streams, ({ state }) => { measured = state; pose(); }));
      ends.push(aims.subscribe(pose));
      const tilt = streamOfType("AttitudeState");
      if (tilt) ends.push(watch(tilt, (sample) => lean(made, sample.message as AttitudeState)));
      const look = new MutationObserver(() => made.setColours(stageColours()));
      look.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
      const scheme = matchMedia("(prefers-color-scheme: dark)");
      const changed = (): void => made.setColours(stageColours());
      scheme.addEventListener("change", changed);
      ends.push(() => look.disconnect(), () => scheme.removeEventListener("change", changed), () => made.dispose());
    }).catch(() => fail(true));
    return () => {
      ended = true;
      ends.forEach((end) => end());
      stage.current = null;
      setReady(false);
    };
  }, [model, key, solid.value]);
  useEffect(() => stage.current?.select(selected), [selected, ready]);
  useEffect(() => stage.current?.setDrag(drags), [drags, ready]);

  const outline = { model, streams, selected, onPick: props.onPick };
  if (failed || !solid.value) return <Flat {...outline} failed={failed} {...(may ? { onDrag: props.onDrag, onDrop: props.onDrop } : {})} />;
  return (
    <div class="joints-stage" data-ready={ready}>
      <canvas ref={canvas} class="joints-canvas" role="img" aria-label={t("joints.body", { robot: model.robot })} />
      {!ready && <div class="joints-flat joints-loading"><Outline {...outline} /></div>}
      <div class="joints-stage-top">
        {may && <Segments
          label={t("joints.mode")} value={mode} onChange={setMode}
          options={[{ value: "look", text: t("joints.look"), icon: "turn" }, { value: "pose", text: t("joints.pose"), icon: "joints" }]}
        />}
      </div>
      <div class="joints-stage-side" role="group" aria-label={t("joints.sides")}>
        {(["front", "left", "back"] as const).map((side) => <Button key={side} kind="quiet" onClick={() => stage.current?.look(side)}>{t(`joints.from.${side}`)}</Button>)}
        {!hasCard && <Button kind="quiet" onClick={() => choose(false)}>{t("joints.unsolid")}</Button>}
      </div>
      <p class="joints-stage-hint">{drags ? t("joints.hint.pose") : t("joints.hint.look")}</p>
    </div>
  );
}

function lean(stage: Stage, state: AttitudeState): void {
  if (state.valid) stage.setTilt(state.roll_rad ?? null, state.pitch_rad ?? null);
}
