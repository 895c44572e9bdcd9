// What is to be mended, and in which order.
import assert from "node:assert/strict";
import { test } from "node:test";
import type { CapabilityStatus } from "../src/messages";
import { feedsOf, lacks } from "../src/views/system/mending";

const part = (name: string, phase = "degraded", reason = ""): CapabilityStatus => ({ name, kind: name, phase, pid: null, restarts: 0, uptime_s: null, reason, rates_hz: {} });
const held = (about: string, name: string, text: string, todo = "") => ({ state: "held", text, code: "", do: todo, first: 1, links: [{ name: "row", about: "?" }, { name, about }] });

test("what holds most comes first, what waits for it is told there alone, and hardware is known as such", () => {
  const parts = [part("speech", "failed", "no loudspeaker"), part("drive"), part("odometry"), part("motors", "degraded", "/dev/ttyACM0 is not there"), part("box", "ready")];
  const chains = { drive: held("motors", "line", "motors are away"), odometry: held("motors", "input", "motors are away"), motors: held("motors", "line", "no such device", "look at the cable"), speech: held("speech", "process", "ended", "/restart/speech") };
  const found = lacks(parts, chains);
  assert.deepEqual(found.map((one) => [one.root, one.waits, one.device]), [["motors", ["drive", "odometry"], true], ["speech", [], false]]);
  assert.deepEqual(found.map((one) => [one.reason, one.do]), [["/dev/ttyACM0 is not there", "look at the cable"], ["no loudspeaker", "/restart/speech"]]);
});

test("a part whose reason nobody asked for yet, or whose root is well again, is told by itself", () => {
  assert.deepEqual(lacks([part("drive", "degraded", "waits")], {}).map((one) => [one.root, one.reason]), [["drive", "waits"]]);
  assert.deepEqual(lacks([part("drive", "degraded", "waits")], { drive: held("elsewhere", "line", "away") }).map((one) => one.root), ["drive"]);
});

test("what hears of a part without its device waits for that, also by way of others and in circles", () => {
  const parts = [part("motors"), part("ranges"), part("odometry"), part("drive"), part("behaviour"), part("speech", "ready")];
  const away = { ...held("range_board", "port", "is missing"), code: "unreachable" };
  const feeds = feedsOf([["motors.state", "odometry.motors"], ["odometry.state", "drive.odometry"], ["drive.setpoint", "motors.setpoint"], ["ranges.readings", "drive.ranges"], ["drive.state", "behaviour.drive"], ["speech.state", "behaviour.speech"]].map(([source, target]) => ({ source, target, enabled: true })));
  const found = lacks(parts, { motors: away, ranges: away }, feeds);
  assert.deepEqual(found.map((one) => [one.root, one.waits, one.device]), [["motors", ["odometry", "drive", "behaviour"], true], ["ranges", ["drive", "behaviour"], true]]);
  assert.deepEqual(lacks([{ ...part("a"), code: "unreachable" }, { ...part("b"), code: "unreachable" }], {}, { b: ["a"] }).map((one) => one.root), ["a", "b"], "before anybody was asked why");
  assert.deepEqual(lacks([part("a"), part("b")], {}, { a: ["b"], b: ["a"] }).map((one) => one.root), ["a", "b"], "each by itself, and none is lost");
});
