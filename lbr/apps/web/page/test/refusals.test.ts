import { pass } from "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { told } from "../src/access";
import { status } from "../src/live";
import { mendable } from "../src/mend";
import { dismiss, notice, notices, toldLately } from "../src/notices";
import { command, robot } from "../src/robot";
import type { Capability, CapabilityStatus, Robot, Status } from "../src/messages";
import { language, TABLE } from "../src/words";

const capability = (name: string, commands: Record<string, boolean>): Capability =>
  ({ name, kind: name, family: "operation", summary: "", outputs: {}, commands: Object.fromEntries(Object.entries(commands).map(([key, leased]) => [key, { schema: {}, role: "operate", leased }])) });

test("a code with a sentence of the page's own is told by it alone, others with the robot's reason", () => {
  language.value = "en";
  assert.equal(told({ code: "no_torque", reason: "18 joints have no torque: /torque/on first" }), "Joints are off.");
  assert.equal(told({ code: "estop", reason: "latched: reset releases it" }), "Emergency stop is pressed.");
  assert.equal(told({ code: "obstacle", reason: "forward reads 18 cm" }), "Something is in the way: forward reads 18 cm");
  language.value = "de";
  assert.equal(told({ code: "obstacle", reason: "forward reads 18 cm" }), "Etwas ist im Weg");
  assert.equal(told({ code: "bad_value", reason: "speed is above 1" }), "Ein Wert passt nicht: speed is above 1");
  assert.equal(told({ code: "its_own", reason: "no such light" }), "no such light");
  language.value = "en";
  for (const key of Object.keys(TABLE).filter((one) => one.startsWith("refused."))) assert.doesNotMatch(TABLE[key as keyof typeof TABLE]!.join(), /\//, key);
});

test("what was accepted and left undone in part is told", async () => {
  globalThis.fetch = () => Promise.resolve(new Response(JSON.stringify({ accepted: true, code: "limit", reason: "left_knee is outside its limits" })));
  assert.ok((await command("joints", "torque", { on: true })).ok);
  assert.deepEqual(notices.value.map((one) => one.text), [TABLE["undone.limit"]![0]]);
  notices.value.forEach((one) => dismiss(one.id));
});

test("a refusal has a button where this robot, and this person, can mend it so", () => {
  const base = { role: "operate", capabilities: [capability("drive", { command: true }), capability("speech", { say: false })] } as unknown as Robot;
  robot.value = base;
  assert.deepEqual(["estop", "no_torque", "latched", "obstacle"].map((code) => mendable(code)), [true, false, false, false]);
  assert.deepEqual(["drive", "speech", "console"].map((about) => mendable("held", about)), [true, false, false]);
  assert.deepEqual(["drive", "speech"].map((about) => mendable("held_by_part", about)), [true, false]);
  robot.value = { ...base, capabilities: [capability("joints", { command: true, torque: false, recover: false })] };
  assert.deepEqual(["no_torque", "latched"].map((code) => mendable(code)), [true, true]);
  robot.value = { ...robot.value, role: "view" };
  assert.equal(mendable("estop"), false);
  robot.value = null;
});

test("what is missing is listed behind a refusal that it causes, once the robot has had time to start", () => {
  robot.value = { role: "operate", capabilities: [] } as unknown as Robot;
  const parts = (phase: string): CapabilityStatus[] => [{ name: "motors", phase } as CapabilityStatus];
  const told = (phase: string, uptime_s: number): void => { status.value = { uptime_s, capabilities: parts(phase) } as Status; };
  const offered = (): boolean[] => ["not_armed", "unwell", "obstacle"].map((code) => mendable(code));
  told("degraded", 60);
  assert.deepEqual(offered(), [true, true, false]);
  told("degraded", 3);
  assert.deepEqual(offered(), [false, false, false]);
  told("ready", 60);
  assert.deepEqual(offered(), [false, false, false]);
  [robot.value, status.value] = [null, null];
});

test("a refusal that a notice told is not told once more beside it, until some time has passed", () => {
  notice("Joints are off.", "warn", { code: "no_torque" });
  assert.ok(toldLately("Joints are off."));
  dismiss(notices.value.at(-1)!.id);
  assert.ok(toldLately("Joints are off."));
  assert.ok(!toldLately("It has fallen."));
  pass(7000);
  assert.ok(!toldLately("Joints are off."));
});
