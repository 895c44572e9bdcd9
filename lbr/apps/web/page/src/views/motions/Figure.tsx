// A small picture of a pose: the robot's own body, drawn flat.
import { useMemo } from "preact/hooks";
import type { BodyModel } from "../joints/model";
import { sketch } from "../joints/sketch";

interface Props { model: BodyModel; pose: Record<string, number>; moved?: Record<string, number>; selected?: string; onPick?: (joint: string) => void }

/** `onPick` hears of the joint whose limb is pressed. */
export function Figure({ model, pose, moved, selected = "", onPick }: Props) {
  const { patches, box } = useMemo(() => sketch(model, pose), [model, pose]);
  const going = moved ?? pose;
  return (
    <svg class="motions-figure" viewBox={box.map((value) => value.toFixed(4)).join(" ")} preserveAspectRatio="xMidYMid meet" aria-hidden="true">
      {patches.map((patch, at) => <polygon key={at} points={patch.points} fill={patch.shade} class={patch.joint && patch.joint === selected ? "picked" : patch.joint in going ? "moved" : ""} onClick={onPick && (() => onPick(patch.joint))} stroke-width={box[3] / 220} />)}
    </svg>
  );
}
