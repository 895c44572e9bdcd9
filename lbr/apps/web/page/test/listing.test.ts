import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { gathered, lineOf } from "../src/views/system/minute";
import { dayOf, matches, merged } from "../src/views/system/listing";
import type { Event } from "../src/messages";

const event = (wall_ns: number, text: string, more: Partial<Event> = {}): Event => ({ kind: "crashed", subject: "drive", text, wall_ns, ...more });

test("what was written and is heard too stands there once, the newest first", () => {
  const both = event(20, "again", { code: "timeout" });
  const list = merged([event(30, "now"), both], [event(20, "again"), event(10, "long ago")], 10);
  assert.deepEqual(list.map((one) => one.event.text), ["now", "again", "long ago"]);
  assert.equal(list[1]!.event.code, "timeout");
  assert.equal(new Set(list.map((one) => one.key)).size, 3);
  assert.equal(merged([], [event(1, "a"), event(2, "b")], 1)[0]!.event.text, "b");
});

test("a level shows what matters more, too, and a part shows its own", () => {
  assert.equal(matches(event(1, "a"), "", "info"), true);
  assert.equal(matches(event(1, "a"), "", "warning"), false);
  assert.equal(matches(event(1, "a", { level: "error" }), "drive", "warning"), true);
  assert.equal(matches(event(1, "a", { level: "error" }), "motors", "warning"), false);
});

test("of today only the time is said", () => {
  const now = new Date(2026, 10, 23, 12);
  assert.equal(dayOf(now.getTime() * 1e6, now, "en"), "");
  assert.match(dayOf(new Date(2026, 10, 21, 12).getTime() * 1e6, now, "en"), /21/);
  assert.equal(dayOf(0, now, "en"), "");
});

test("a minute of what a part takes is kept, and forgotten with the part", () => {
  let known = {};
  for (let second = 0; second < 70; second++) known = gathered(known, [{ name: "drive", cpu_percent: second }, { name: "box", cpu_percent: null }]);
  assert.deepEqual(known, { drive: Array.from({ length: 60 }, (_, at) => at + 10), box: [] });
  assert.deepEqual(gathered(known, [{ name: "box", cpu_percent: 2 }]), { box: [2] });
  assert.equal(lineOf([]), "");
  assert.equal(lineOf([0, 5, 10]), "M57 20.0L58 10.5L59 1.0");
});
