// The body drawn flat, from the same model and as it was measured: without three dimensions, and until those are loaded.
import { useMemo } from "preact/hooks";
import { Button } from "../../parts";
import { streamOfType } from "../../robot";
import { t } from "../../words";
import type { AttitudeState } from "../../messages";
import { useGrasp } from "./grasp";
import { useCalm, useJoints } from "./hooks";
import type { BodyModel } from "./model";
import { grounded, placed } from "./pose";
import { positions, tones } from "./state";
import { sketch, THREE_QUARTERS } from "./sketch";
import { choose } from "./solid";
import { BAD } from "./tone";

interface Props { model: BodyModel; streams: readonly string[]; selected: string; onPick: (joint: string) => void; onDrag?: (joint: string, rad: number) => boolean; onDrop?: (joint: string) => void }

export function Outline({ model, streams, selected, onPick, onDrag, onDrop }: Props) {
  const state = useJoints(streams)?.state;
  const lean = useCalm<AttitudeState>(streamOfType("AttitudeState"))?.message;
  const all = state ? tones(state) : {};
  const { angles, places, patches, box } = useMemo(() => {
    const angles = state ? positions(state) : {};
    const root = lean?.valid ? grounded(model, angles, lean.roll_rad ?? 0, lean.pitch_rad ?? 0) : undefined;
    const places = placed(model, angles, root);
    return { angles, places, ...sketch(model, angles, THREE_QUARTERS, places) };
  }, [model, state, lean]);
  const hands = useGrasp({ model, angles, places, patches, selected, onPick, onDrag, onDrop });
  return (
    <svg class="joints-outline" data-drags={onDrag ? true : undefined} {...hands} viewBox={box.join(" ")} role="img" aria-label={t("joints.body", { robot: model.robot })} preserveAspectRatio="xMidYMid meet">
      {patches.map((patch, at) => {
        const tone = all[patch.joint];
        const look = patch.joint && patch.joint === selected ? "picked" : tone && BAD.has(tone) ? "bad" : "";
        return <polygon key={at} data-at={at} data-joint={patch.joint} points={patch.points} fill={patch.shade} class={look} stroke-width={box[3] / 500} onClick={() => onPick(patch.joint)} />;
      })}
    </svg>
  );
}

/** `failed`: this browser cannot draw in three dimensions at all. Limbs are dragged where `onDrag` is given. */
export function Flat({ failed, ...props }: Props & { failed: boolean }) {
  return (
    <div class="joints-stage joints-flat">
      <Outline {...props} />
      {!failed && <div class="joints-stage-side"><Button kind="quiet" onClick={() => choose(true)}>{t("joints.solid")}</Button></div>}
      <p class="joints-stage-hint">{[failed && t("joints.flat.only"), t(props.onDrag ? "joints.flat.drag" : "joints.flat")].filter(Boolean).join(" ")}</p>
    </div>
  );
}
