import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { byPage, named } from "../src/handover";
import { language } from "../src/words";

test("who holds the robot is a token's name, or where a page without one is", () => {
  language.value = "en";
  assert.deepEqual(["web:ann", "web:127.0.0.1", "web:::1", "web:192.168.1.7"].map(named), ["ann", "Another page on the robot’s machine", "Another page on the robot’s machine", "192.168.1.7"]);
});

test("a program that holds the robot is told with its machine, without the number of its process", () => {
  assert.deepEqual(["lbr send@desk:31576", "ann@home"].map(named), ["lbr send (desk)", "ann@home"]);
});

test("a run that was ended on a page did not fail, one that something else ended did", () => {
  assert.deepEqual(["stopped by web:127.0.0.1: from the page", "stopped by beacon", "the way is blocked"].map((reason) => byPage({ reason })), [true, false, false]);
});
