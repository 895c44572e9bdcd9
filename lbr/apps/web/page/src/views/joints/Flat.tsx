// The body drawn flat, from the same model: for browsers without WebGL.
import { t } from "../../words";
import { useJoints } from "./hooks";
import type { BodyModel } from "./model";
import { positions, tones } from "./state";
import { sketch } from "./sketch";
import { BAD } from "./tone";

export function Flat({ model, streams, selected, onPick }: { model: BodyModel; streams: readonly string[]; selected: string; onPick: (joint: string) => void }) {
  const state = useJoints(streams)?.state;
  const all = state ? tones(state) : {};
  const { patches, box } = sketch(model, state ? positions(state) : {});
  return (
    <div class="joints-stage joints-flat">
      <svg viewBox={box.join(" ")} role="img" aria-label={t("joints.body", { robot: model.robot })} preserveAspectRatio="xMidYMid meet">
        {patches.map((patch, at) => {
          const tone = all[patch.joint];
          const look = patch.joint && patch.joint === selected ? "picked" : tone && BAD.has(tone) ? "bad" : "";
          return <polygon key={at} points={patch.points} fill={patch.shade} class={look} stroke-width={box[3] / 500} onClick={() => onPick(patch.joint)} />;
        })}
      </svg>
      <p class="joints-stage-hint">{t("joints.flat")}</p>
    </div>
  );
}
