import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { deeds, isThere, ordered, type MotionRow } from "../src/views/motions/data";

const of = (...names: string[]): string[] => deeds(names.map((name) => ({ name, help: "" }))).map((one) => one.name);

test("a humanoid offers the quickest motion of each kind first, and none that only gets it up", () => {
  assert.deepEqual(of("get_up_back", "initial", "ready", "sit", "stand_up", "turn_left", "walk_ahead", "wave"), ["stand_up", "wave", "walk_ahead", "sit", "turn_left"]);
  assert.deepEqual(of("basic_motion", "kick_right", "reset", "sit_down", "walk_forward_4step"), ["reset", "walk_forward_4step", "sit_down", "kick_right", "basic_motion"]);
  assert.deepEqual(of("get_up_face"), []);
  assert.deepEqual(ordered(["get_up_face", "nod", "wave"].map((name) => ({ name, help: "" }))).map((one) => one.name), ["wave", "nod", "get_up_face"]);
  assert.deepEqual(deeds([["walk_forward_4step", 3.1], ["walk_forward_short", 1.9]].map(([name, duration_s]) => ({ name, help: "", duration_s }) as MotionRow))[0]!.name, "walk_forward_short");
});

test("a robot that stands is not offered to stand up, whatever its arms do", () => {
  const end = { left_knee: 0, right_knee: 0, left_hip: 0, right_hip: 0, left_elbow: 0 };
  assert.ok(isThere(end, { ...end, left_elbow: -0.4 }));
  assert.ok(!isThere(end, { ...end, left_knee: -1.2, right_knee: -1.2 }));
  assert.ok(!isThere(end, { left_knee: 0 }));
  assert.ok(!isThere(undefined, {}));
});
