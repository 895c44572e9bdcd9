// Dragging a limb of a body that is drawn flat: what is held, and the angle that brings it under the pointer.
import { useRef } from "preact/hooks";
import { draggedTo, type Held, type Screen } from "./drag";
import type { BodyModel } from "./model";
import { rotated, type Place } from "./pose";
import { seen, THREE_QUARTERS, unseen, type Patch } from "./sketch";

export type Angles = Record<string, number | null | undefined>;
export interface Grasp { joint: string; held: Held; from: number }
const TAP_PX = 6;

/** What a pointer at a point of the drawing takes hold of; null where no joint moves it, or its angle is unknown. */
export function grasp(model: BodyModel, angles: Angles, places: ReadonlyMap<string, Place>, patch: Patch, [x, y]: Screen): Grasp | null {
  const { joint } = patch;
  const range = model.joints[joint], link = model.links.find((one) => one.joint === joint), angle = angles[joint];
  const place = link && places.get(link.name);
  if (!range || !place || range.kind === "wheel" || angle == null) return null;
  const held = { axis: rotated(place.q, link.axis), centre: place.p, point: unseen([x, -y, patch.depth], THREE_QUARTERS), angle, lower: range.lower ?? -3.1, upper: range.upper ?? 3.1, slides: range.kind === "slide" };
  return { joint, held, from: angle };
}

/** The angle of the joint for a pointer at a point of the drawing. */
export const pulled = ({ held, from }: Grasp, pointer: Screen): number =>
  draggedTo(held, from, pointer, (at) => { const [across, up] = seen(at, THREE_QUARTERS); return [across, -up]; });

interface Hands { model: BodyModel; angles: Angles; places: ReadonlyMap<string, Place>; patches: Patch[]; selected: string; onPick?: (joint: string) => void; onDrag?: (joint: string, rad: number) => boolean | void; onDrop?: (joint: string) => void }
type Handler = (event: PointerEvent) => void;

/** The handlers of a drawing whose patches have their number as `data-at`. A finger drags the limb that is chosen: others scroll the page. */
export function useGrasp(given: Hands): Record<string, Handler> {
  const newest = useRef(given);
  newest.current = given;
  const one = useRef<{ grasp: Grasp; pointer: number; x: number; y: number; moved: boolean } | null>(null);
  if (!given.onDrag) return {};
  const at = (event: PointerEvent): Screen => {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform((event.currentTarget as SVGSVGElement).getScreenCTM()!.inverse());
    return [x, y];
  };
  const lift = (event: PointerEvent): void => {
    if (event.pointerId !== one.current?.pointer) return;
    const { grasp: { joint }, moved } = one.current;
    one.current = null;
    if (moved) newest.current.onDrop?.(joint);
  };
  return {
    onPointerDown: (event) => {
      const { model, angles, places, patches, selected } = newest.current;
      const patch = patches[Number((event.target as Element).getAttribute("data-at") ?? -1)];
      if (!event.isPrimary || event.button !== 0 || !patch || (event.pointerType === "touch" && patch.joint !== selected)) return;
      const found = grasp(model, angles, places, patch, at(event));
      one.current = found && { grasp: found, pointer: event.pointerId, x: event.clientX, y: event.clientY, moved: false };
    },
    onPointerMove: (event) => {
      const now = one.current;
      if (!now || event.pointerId !== now.pointer) return;
      if (!now.moved && Math.hypot(event.clientX - now.x, event.clientY - now.y) < TAP_PX) return;
      if (!now.moved) {
        now.moved = true;
        (event.currentTarget as Element).setPointerCapture(event.pointerId);
        newest.current.onPick?.(now.grasp.joint);
      }
      now.grasp.from = pulled(now.grasp, at(event));
      if (newest.current.onDrag!(now.grasp.joint, now.grasp.from) === false) lift(event);
    },
    onPointerUp: lift,
    onPointerCancel: lift,
    onLostPointerCapture: lift,
  };
}
