// The body drawn flat, from the same model and as it was measured: without three dimensions, and until those are loaded.
import { Button } from "../../parts";
import { streamOfType } from "../../robot";
import { t } from "../../words";
import type { AttitudeState } from "../../messages";
import { useCalm, useJoints } from "./hooks";
import type { BodyModel } from "./model";
import { grounded, placed } from "./pose";
import { positions, tones } from "./state";
import { sketch, THREE_QUARTERS } from "./sketch";
import { choose } from "./solid";
import { BAD } from "./tone";

interface Props { model: BodyModel; streams: readonly string[]; selected: string; onPick: (joint: string) => void }

export function Outline({ model, streams, selected, onPick }: Props) {
  const state = useJoints(streams)?.state;
  const lean = useCalm<AttitudeState>(streamOfType("AttitudeState"))?.message;
  const all = state ? tones(state) : {};
  const angles = state ? positions(state) : {};
  const root = lean?.valid ? grounded(model, angles, lean.roll_rad ?? 0, lean.pitch_rad ?? 0) : undefined;
  const { patches, box } = sketch(model, angles, THREE_QUARTERS, placed(model, angles, root));
  return (
    <svg class="joints-outline" viewBox={box.join(" ")} role="img" aria-label={t("joints.body", { robot: model.robot })} preserveAspectRatio="xMidYMid meet">
      {patches.map((patch, at) => {
        const tone = all[patch.joint];
        const look = patch.joint && patch.joint === selected ? "picked" : tone && BAD.has(tone) ? "bad" : "";
        return <polygon key={at} points={patch.points} fill={patch.shade} class={look} stroke-width={box[3] / 500} onClick={() => onPick(patch.joint)} />;
      })}
    </svg>
  );
}

/** `failed`: this browser cannot draw in three dimensions at all. */
export function Flat({ failed, ...props }: Props & { failed: boolean }) {
  return (
    <div class="joints-stage joints-flat">
      <Outline {...props} />
      {!failed && <div class="joints-stage-side"><Button kind="quiet" onClick={() => choose(true)}>{t("joints.solid")}</Button></div>}
      <p class="joints-stage-hint">{t(failed ? "joints.flat.only" : "joints.flat")}</p>
    </div>
  );
}
