import assert from "node:assert/strict";
import { test } from "node:test";
import { level, missed } from "../src/views/drive/geometry";
import type { BodyModel } from "../src/views/joints/model";
import { extent, grounded, placed } from "../src/views/joints/pose";

const below = { name: "bottom", kind: "ultrasonic", pitch_rad: Math.PI / 2 };

test("a sensor that is not there is a warning only where the robot would need it", () => {
  const rows = [{ name: "forward", kind: "ultrasonic" }, { ...below, stop_m: null }];
  assert.ok(missed(rows, "forward") && !missed(rows, "bottom"), "what looks down stops nothing by itself");
  assert.ok(missed([{ ...below, stop_m: 0.4 }], "bottom"), "a row that stops the base makes it one that is missed");
  assert.ok(missed([], "left") && !missed([], "bottom") && level(rows, "forward") && !level(rows, "bottom"));
});

test("a body that lies is on the floor and in the middle of the view, as one that stands is", () => {
  const box = { kind: "box" as const, size: [0.1, 0.2, 0.6], xyz: [0.02, 0, 0.3] as [number, number, number], rpy: [0, 0, 0] as [number, number, number], rgba: [1, 1, 1, 1] as [number, number, number, number] };
  const link = { name: "trunk", parent: "", joint: "", axis: [0, 0, 1] as [number, number, number], origin_xyz: [0, 0, 0.05] as [number, number, number], origin_rpy: [0, 0, 0] as [number, number, number], shapes: [box] };
  const model: BodyModel = { robot: "one", links: [link], joints: {}, sensors: [], left_out: [], reason: "" };
  const near = (is: number[], expected: number[]): void => is.forEach((value, axis) => assert.ok(Math.abs(value - expected[axis]!) < 1e-9, `${is} is not ${expected}`));
  near(grounded(model, {}, 0, 0).p, [0, 0, -0.05]);
  for (const [roll, pitch] of [[0, Math.PI / 2], [0, -Math.PI / 2], [Math.PI / 2, 0], [-1.2, 0.4]] as const) {
    const { low, high } = extent(model, placed(model, {}, grounded(model, {}, roll, pitch)));
    assert.ok(high[2] < 0.5);
    near([low[0] + high[0], low[1] + high[1], low[2]], [0.04, 0, 0]);
  }
});
