import assert from "node:assert/strict";
import { test } from "node:test";
import { level, missed } from "../src/views/drive/geometry";

const below = { name: "bottom", kind: "ultrasonic", pitch_rad: Math.PI / 2 };

test("a sensor that is not there is a warning only where the robot would need it", () => {
  const rows = [{ name: "forward", kind: "ultrasonic" }, { ...below, stop_m: null }];
  assert.ok(missed(rows, "forward") && !missed(rows, "bottom"), "what looks down stops nothing by itself");
  assert.ok(missed([{ ...below, stop_m: 0.4 }], "bottom"), "a row that stops the base makes it one that is missed");
  assert.ok(missed([], "left") && !missed([], "bottom") && level(rows, "forward") && !level(rows, "bottom"));
});
