import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { drawn, joined, quantities, table, type Past } from "../src/views/system/past";
import { robot } from "../src/robot";
import type { Robot } from "../src/messages";

const outputs = (type: string): object => ({ readings: { title: type }, state: { title: type } });
const of = (kinds: Record<string, string>, joints: object[] = []): void => {
  const capabilities = Object.entries(kinds).map(([name, type]) => ({ name, kind: name, outputs: { state: (outputs(type) as Record<string, object>)["state"] }, commands: {} }));
  robot.value = { capabilities, joints } as unknown as Robot;
};

test("a robot's history is of what it publishes", () => {
  of({ battery: "BatteryState", odometry: "OdometryState", ranges: "Ranges" });
  assert.deepEqual(quantities().map((one) => [one.key, one.unit]), [["battery", "V"], ["speed", "m/s"], ["nearest", "m"], ["current", "A"]]);
  of({ joints: "JointsState" }, [{ name: "neck" }, { name: "knee" }]);
  assert.deepEqual(quantities().map((one) => one.fields), [["joints/state.joints.neck.temperature_c", "joints/state.joints.knee.temperature_c"]]);
  robot.value = null;
});

test("the nearest of several sides is drawn, and a time without any has none", () => {
  of({ ranges: "Ranges" });
  const [nearest] = quantities();
  const past: Past = { at_ms: [1, 2, 3], values: { "ranges/state.forward_m": [2, null, null], "ranges/state.left_m": [0.5, 3, null] } };
  assert.deepEqual(drawn(nearest!, past), [0.5, 3, null]);
  assert.equal(table([nearest!], past).split("\n")[1], "1970-01-01T00:00:00.001Z,0.5");
  robot.value = null;
});

test("what comes is added once, and what is over goes", () => {
  const known: Past = { at_ms: [10, 20], values: { a: [1, 2] } };
  const all = joined(known, { at_ms: [20, 30], values: { a: [2, 3], b: [7, 8] } }, 15);
  assert.deepEqual(all, { at_ms: [20, 30], values: { a: [2, 3], b: [null, 8] } });
  assert.deepEqual(joined(all, { at_ms: [], values: {} }, 25), { at_ms: [30], values: { a: [3], b: [8] } });
  assert.deepEqual(joined(known, { at_ms: [], values: {} }, 99).at_ms, []);
});
