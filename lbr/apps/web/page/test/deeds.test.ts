import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { deeds } from "../src/views/motions/data";

const of = (...names: string[]): string[] => deeds(names.map((name) => ({ name, help: "" }))).map((one) => one.name);

test("a humanoid offers one motion of each kind first, and none that only gets it up", () => {
  assert.deepEqual(of("get_up_back", "initial", "ready", "sit", "stand_up", "turn_left", "walk_ahead", "wave"), ["stand_up", "initial", "wave", "walk_ahead", "sit"]);
  assert.deepEqual(of("basic_motion", "kick_right", "reset", "sit_down", "walk_forward_4step"), ["reset", "walk_forward_4step", "sit_down", "kick_right", "basic_motion"]);
  assert.deepEqual(of("get_up_face"), []);
});
