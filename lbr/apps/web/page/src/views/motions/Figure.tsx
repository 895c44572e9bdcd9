// A small picture of a pose: the robot's own body, drawn flat.
import { useMemo } from "preact/hooks";
import { useGrasp } from "../joints/grasp";
import type { BodyModel } from "../joints/model";
import { placed } from "../joints/pose";
import { sketch, THREE_QUARTERS } from "../joints/sketch";

interface Props { model: BodyModel; pose: Record<string, number>; moved?: Record<string, number>; selected?: string; onPick?: (joint: string) => void; onDrag?: (joint: string, rad: number) => void }

/** `onPick` receives the joint whose limb is pressed, `onDrag` the angle to which a limb is dragged. */
export function Figure({ model, pose, moved, selected = "", onPick, onDrag }: Props) {
  const places = useMemo(() => placed(model, pose), [model, pose]);
  const { patches, box } = useMemo(() => sketch(model, pose, THREE_QUARTERS, places), [places]);
  const hands = useGrasp({ model, angles: pose, places, patches, selected, onPick, onDrag });
  const going = moved ?? pose;
  return (
    <svg class="motions-figure" data-drags={onDrag ? true : undefined} {...hands} viewBox={box.map((value) => value.toFixed(4)).join(" ")} preserveAspectRatio="xMidYMid meet" aria-hidden="true">
      {patches.map((patch, at) => <polygon key={at} data-at={at} points={patch.points} fill={patch.shade} class={patch.joint && patch.joint === selected ? "picked" : patch.joint in going ? "moved" : ""} onClick={onPick && (() => onPick(patch.joint))} stroke-width={box[3] / 220} />)}
    </svg>
  );
}
