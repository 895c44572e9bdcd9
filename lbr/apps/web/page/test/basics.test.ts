// Settings for people: which there are, and what is written for one.
import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { basicsOf, groupsOf, isShare, valueAt, withValue } from "../src/views/system/basics";
import { choiceOf, fieldsOf, helpOf, problems, titleOf, type Schema } from "../src/views/system/schema";
import { language, learn } from "../src/words";
import { system } from "../src/words/system";

const SCHEMA: Schema = {
  $ref: "#/$defs/Settings",
  $defs: {
    Settings: {
      type: "object", required: [],
      properties: {
        rate_hz: { type: "number", default: 50 },
        max_power: { type: "number", title: "Top speed", exclusiveMinimum: 0, maximum: 1, default: 1, "x-basic": "speed" },
        reach_m: { type: "number", minimum: 0, maximum: 1, default: 1, "x-basic": "arm" },
        rules: { type: "array", items: { $ref: "#/$defs/Rule" }, default: [{ direction: "forward", stop_m: 0.25 }, { direction: "left", stop_m: 0.2 }] },
      },
    },
    Rule: { type: "object", properties: { direction: { enum: ["forward", "left"] }, stop_m: { type: "number", exclusiveMinimum: 0, default: 0.25, title: "Distance kept", "x-basic": "distances" } }, required: ["direction"] },
  },
};
const fields = fieldsOf(SCHEMA);

test("what is declared as basic is found, also of each thing in a list that was never written", () => {
  const found = basicsOf("drive", fields, {});
  assert.deepEqual(found.map((one) => [one.title, one.path]), [["Top speed", ["max_power"]], ["Reach", ["reach_m"]], ["Distance kept, forward", ["rules", 0, "stop_m"]], ["Distance kept, left", ["rules", 1, "stop_m"]]]);
  assert.deepEqual(groupsOf(found).map((one) => one.group), ["speed", "distances", "arm"]);
  assert.deepEqual(found.map((one) => [one.field.fallback, isShare(one.field)]), [[1, true], [1, false], [0.25, false], [0.2, false]]);
});

test("one thing of a list is another, and all others are written as they were", () => {
  assert.deepEqual(withValue(fields, { rate_hz: 60 }, ["rules", 1, "stop_m"], 0.3), { rate_hz: 60, rules: [{ direction: "forward", stop_m: 0.25 }, { direction: "left", stop_m: 0.3 }] });
  assert.deepEqual(withValue(fields, { max_power: 0.5 }, ["max_power"], undefined), {});
  assert.equal(valueAt(fields, {}, ["rules", 1, "stop_m"]), 0.2);
  assert.equal(valueAt(fields, { max_power: 0.5 }, ["max_power"]), 0.5);
  assert.deepEqual([...problems(fields, { rules: [{ direction: "forward", stop_m: 0 }, {}] }).keys()], ["rules.0.stop_m", "rules.1.direction"]);
});

test("a setting that people ask for first is called as the page's language says, also its choices; others as declared", () => {
  learn(system);
  const [power] = fields.slice(1), [field] = fieldsOf({ type: "object", properties: { on_estop: { enum: ["hold", "release", "sing"], title: "Emergency stop", description: "hold or release", "x-basic": "joints" } } });
  const said = () => [titleOf(power!), titleOf(fields[2]!), titleOf(field!), helpOf(field!), choiceOf(field!, "release"), choiceOf(field!, "sing")];
  language.value = "de";
  assert.deepEqual(said(), ["Höchstes Tempo", "Reach", "Notstopp", "Was die Gelenke dann tun", "Werden sofort schlaff", "sing"]);
  language.value = "en";
  assert.deepEqual(said(), ["Top speed", "Reach", "Emergency stop", "What the joints do then", "Go limp at once", "sing"]);
});
