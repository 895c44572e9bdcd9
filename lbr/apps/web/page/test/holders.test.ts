import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { named } from "../src/handover";
import { language } from "../src/words";

test("who holds the robot is a token's name, or where a page without one is", () => {
  language.value = "en";
  assert.deepEqual(["web:ann", "web:127.0.0.1", "web:::1", "web:192.168.1.7"].map(named), ["ann", "Another page on the robot’s machine", "Another page on the robot’s machine", "192.168.1.7"]);
});
