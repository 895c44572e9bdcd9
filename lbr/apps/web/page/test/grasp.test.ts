import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { grasp, pulled } from "../src/views/joints/grasp";
import type { BodyModel, Vec } from "../src/views/joints/model";
import { placed } from "../src/views/joints/pose";
import { seen, sketch, THREE_QUARTERS, unseen } from "../src/views/joints/sketch";

const NONE: Vec = [0, 0, 0];
const MODEL: BodyModel = {
  robot: "arm", sensors: [], left_out: [], reason: "",
  joints: { elbow: { lower: -1, upper: 1, kind: "hinge", side: "centre", speed_rps: null, drawn: true } },
  links: [
    { name: "base", parent: "", joint: "", axis: [0, 0, 1], origin_xyz: NONE, origin_rpy: NONE, shapes: [{ kind: "box", size: [0.1, 0.1, 0.1], xyz: NONE, rpy: NONE, rgba: [1, 1, 1, 1] }] },
    { name: "arm", parent: "base", joint: "elbow", axis: [1, 0, 0], origin_xyz: [0, 0, 0.1], origin_rpy: NONE, shapes: [{ kind: "box", size: [0.04, 0.04, 0.3], xyz: [0, 0, 0.15], rpy: NONE, rgba: [1, 1, 1, 1] }] },
  ],
};

test("a point that is seen is found again", () => {
  const point: Vec = [0.1, -0.2, 0.3];
  unseen(seen(point, THREE_QUARTERS), THREE_QUARTERS).forEach((value, axis) => assert.ok(Math.abs(value - point[axis]!) < 1e-9));
});

test("a limb follows the pointer, and no further than its joint goes", () => {
  const angles = { elbow: 0.2 };
  const places = placed(MODEL, angles);
  const patch = sketch(MODEL, angles, THREE_QUARTERS, places).patches.find((one) => one.joint === "elbow")!;
  const tip = (angle: number): [number, number] => {
    const [across, up] = seen([0, -0.25 * Math.sin(angle), 0.1 + 0.25 * Math.cos(angle)], THREE_QUARTERS);
    return [across, -up];
  };
  const held = grasp(MODEL, angles, places, patch, tip(0.2))!;
  assert.equal(held.joint, "elbow");
  assert.ok(Math.abs(pulled(held, tip(0.5)) - 0.5) < 0.12);
  held.from = 0.9;
  assert.ok(pulled(held, tip(1.4)) <= 1);
});

test("what no joint moves, or whose angle nobody has read, is not held", () => {
  const places = placed(MODEL, {});
  const { patches } = sketch(MODEL, {}, THREE_QUARTERS, places);
  assert.ok(patches.every((patch) => grasp(MODEL, {}, places, patch, [0, 0]) === null));
});
