// Forms from schemas: which fields there are, what is typed, what is wrong, what has changed.
import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { changes, fieldsOf, kept, problems, read, shown, titleOf, unitOf, writtenSince, type FieldOf, type Schema } from "../src/views/system/schema";

const SCHEMA: Schema = {
  $ref: "#/$defs/Settings",
  $defs: {
    Settings: {
      type: "object", required: ["device"],
      properties: {
        device: { type: "string" },
        power: { type: "number", minimum: 0, maximum: 1, default: 0.5, description: "how much" },
        count: { anyOf: [{ type: "integer", exclusiveMinimum: 0 }, { type: "null" }], default: null },
        mode: { enum: ["a", "b"], default: "a" }, baud: { enum: [9600, 115200] },
        on: { type: "boolean", default: true }, rules: { type: "array", default: [] },
        left: { $ref: "#/$defs/Wheel" },
      },
    },
    Wheel: { type: "object", properties: { channel: { enum: [1, 2] }, trim: { type: "number", minimum: 0.5 } }, required: ["channel"] },
  },
};
const fields = fieldsOf(SCHEMA);
const of = (name: string) => fields.find((one) => one.name === name)!;

test("each column has its kind, its bounds and its help", () => {
  assert.deepEqual(fields.map((one) => [one.name, one.kind]), [["device", "text"], ["power", "number"], ["count", "integer"], ["mode", "choice"], ["baud", "choice"], ["on", "flag"], ["rules", "json"], ["left", "object"]]);
  assert.deepEqual([of("power").least, of("power").most, of("power").help, of("power").fallback], [0, 1, "how much", 0.5]);
  assert.ok(of("count").nullable && of("device").needed && !of("power").needed);
  assert.deepEqual(of("left").fields.map((one) => one.name), ["channel", "trim"]);
});

test("what is typed becomes a value, and rubbish stays as it was typed", () => {
  assert.equal(read(of("power"), "0,25"), 0.25);
  assert.equal(read(of("power"), "much"), "much");
  assert.equal(read(of("power"), " "), undefined);
  assert.equal(read(of("device"), " x"), " x");
  assert.equal(read(of("baud"), "9600"), 9600);
  assert.deepEqual(read(of("rules"), '[{"a": 1}]'), [{ a: 1 }]);
  assert.equal(read(of("rules"), "[1,"), "[1,");
  assert.equal(shown(of("rules"), [1]), "[1]");
});

test("what is wrong is told by the path of its field", () => {
  const told = problems(fields, { power: 7, count: 0.5, rules: "[1,", left: { trim: 0.1 } });
  assert.deepEqual([...told].map(([path, one]) => [path, one.key]), [["device", "form.needed"], ["power", "form.most"], ["count", "form.whole"], ["rules", "form.json"], ["left.channel", "form.needed"], ["left.trim", "form.least"]]);
  assert.equal(problems(fields, { device: "a", power: 1, count: 3 }).size, 0);
});

test("only what is another is sent", () => {
  assert.deepEqual(changes({ a: 1, b: { c: [1] } }, { a: 1, b: { c: [2] }, d: undefined }), { b: { c: [2] } });
  assert.deepEqual(changes(null, { a: 1, d: undefined }), { a: 1 });
});

test("a number's unit stands beside it, and a text's name has none", () => {
  assert.deepEqual(unitOf({ name: "watchdog_ms", kind: "integer" }), { stem: "watchdog", unit: "ms" });
  assert.deepEqual(unitOf({ name: "max_speed_mps", kind: "number" }), { stem: "max_speed", unit: "m/s" });
  assert.deepEqual(unitOf({ name: "accel_per_s", kind: "number" }), { stem: "accel", unit: "/ s" });
  assert.deepEqual(unitOf({ name: "mode_s", kind: "text" }), { stem: "mode_s", unit: "" });
  assert.deepEqual(unitOf({ name: "max_power", kind: "number" }), { stem: "max_power", unit: "" });
});

test("a name in short words is shown in full ones", () => {
  const named = (name: string): string => titleOf({ name, kind: "number", title: "", basic: "" } as FieldOf);
  assert.deepEqual(["ttl_s", "accel_per_s", "camera_fov_deg", "max_power"].map(named), ["Lifetime", "Acceleration", "Camera field of view", "Max power"]);
});

test("what another wrote is shown beside mine, and stays where I changed nothing", () => {
  const before = { name: "drive", help: "old", settings: { power: 0.5, rest: 1, odd: 2 } };
  const there = { name: "drive", help: "theirs", settings: { power: 0.7, rest: 9, odd: 2 } };
  assert.deepEqual(writtenSince(before, there), { help: "theirs", settings: { power: 0.7, rest: 9 } });
  assert.deepEqual(writtenSince(before, before), {});
  assert.deepEqual(kept(there, before, { settings: { power: 0.6, rest: 1 } }), { name: "drive", help: "theirs", settings: { power: 0.6, rest: 9 } });
  assert.deepEqual(kept(there, before, { help: "mine" }), { ...there, help: "mine" });
});
