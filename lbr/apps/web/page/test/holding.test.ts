import { doc, kept, now, pass, reloads, Socket, win } from "./stage";
import assert from "node:assert/strict";
import { beforeEach, test } from "node:test";
import { compare, noteBuild, outdated, unsaved } from "../src/build";
import { holding, refused, SHOWN_MS } from "../src/holding";
import { connect, disconnect, link, pace, status } from "../src/live";

const TO = "drive/command";
let socket: Socket;
const said = (kind: string): Record<string, unknown>[] => socket.said.filter((one) => kind in one);
const hold = (n: number, more: object = {}): void => socket.tell({ hold: { n, holds: true, code: "", reason: "", holder: "", ...more } });
/** Time in which the robot speaks, as it does five times a second. */
const live = (ms: number): void => {
  for (let left = ms; left > 0; left -= 100) {
    pass(Math.min(100, left));
    socket.tell({});
  }
};

beforeEach(() => {
  outdated.value = false;
  doc.hidden = false;
  disconnect();
  connect();
  socket = Socket.all.at(-1)!;
  socket.open();
  socket.tell({});
});

test("a hand is told at once, kept well within 0.25 s, and quotes the newest time that was heard", () => {
  assert.ok(holding.move(TO, { power: 0.3 }));
  assert.deepEqual(said("hold")[0]!.hold, { to: TO, message: { power: 0.3 }, n: (said("hold")[0]!.hold as { n: number }).n });
  const before = now;
  live(2000);
  const times = said("keep").length;
  assert.ok(times >= 20 && times <= 26, `${times}`);
  const quoted = said("keep").map((one) => one.t as number);
  assert.ok(quoted.every((t) => Number.isInteger(t)) && quoted.at(-1)! > before);
});

test("how long a hand has not changed what it asks for is known, so that its end can be told beforehand", () => {
  holding.move(TO, { power: 0.3 });
  live(5000);
  holding.move(TO, { power: 0.3 });
  assert.equal(Math.round(holding.unchangedMs() / 1000), 5);
  holding.move(TO, { power: 0.4 });
  assert.equal(holding.unchangedMs(), 0);
  holding.release();
  live(2000);
  assert.equal(holding.unchangedMs(), 0);
});

test("a change is told within 16 ms, the newest only", () => {
  holding.move(TO, { power: 0.1 });
  live(100);
  socket.said.length = 0;
  holding.move(TO, { power: 0.2 });
  assert.equal(said("hold").length, 1);
  for (let power = 3; power < 9; power += 1) {
    pass(2);
    holding.move(TO, { power: power / 10 });
  }
  pass(16);
  assert.deepEqual(said("hold").map((one) => (one.hold as { message: { power: number } }).message.power).at(-1), 0.8);
  assert.ok(said("hold").length <= 3);
});

test("a thousand changes a second stay within what the server bears", () => {
  for (let at = 0; at < 1000; at += 1) {
    holding.move(TO, { power: (at % 90) / 100 });
    pass(1);
    if (at % 100 === 0) socket.tell({});
  }
  assert.ok(socket.said.length <= 70, `${socket.said.length}`);
});

for (const [how, act] of Object.entries({
  "its window loses the focus": () => win.dispatchEvent(new Event("blur")),
  "its tab is hidden": () => { doc.hidden = true; doc.dispatchEvent(new Event("visibilitychange")); },
  "its phone is frozen": () => doc.dispatchEvent(new Event("freeze")),
  "it is released": () => holding.release(),
})) {
  test(`the hand is off the stick when ${how}`, () => {
    holding.move(TO, { power: 0.3 });
    hold((said("hold")[0]!.hold as { n: number }).n);
    act();
    assert.equal(said("release").length, 1);
    assert.ok(!holding.state.value.moving);
    socket.said.length = 0;
    pass(1000);
    assert.deepEqual([...said("hold"), ...said("keep")], []);
  });
}

const lapsed = { holds: false, code: "lapsed", reason: "silence" };

test("a hand that stays through a lapse begins again from rest, once the link is back", () => {
  holding.move(TO, { power: 0.3 });
  live(200);
  const before = (said("hold").at(-1)!.hold as { n: number }).n;
  pass(800);
  hold(before, lapsed);
  const { n, message } = said("hold").at(-1)!.hold as { n: number; message: object };
  assert.ok(n > before);
  assert.deepEqual(message, { power: 0.3 });
  hold(n);
  assert.ok(holding.state.value.moving);
});

test("a push that comes late is told again with the newest time, for a second, and ends what it began after that", () => {
  const late = { holds: false, code: "late", reason: "late" };
  holding.move(TO, { power: 0.3 });
  const n = (): number => (said("hold").at(-1)!.hold as { n: number }).n;
  hold(n());
  live(200);
  const before = n();
  hold(before, late);
  assert.equal(n(), before + 1);
  live(500);
  hold(n(), late);
  assert.equal(n(), before + 2);
  live(600);
  hold(n(), late);
  assert.equal(n(), before + 2);
  assert.deepEqual([holding.state.value.moving, holding.state.value.code], [false, "late"]);
});

test("a lapse after a worse link, or in a page that slept, ends what the hand moved", () => {
  holding.move(TO, { power: 0.3 });
  live(200);
  pass(1300);
  const { n } = said("hold").at(-1)!.hold as { n: number };
  const before = said("hold").length;
  hold(n, lapsed);
  assert.equal(said("hold").length, before);
  assert.deepEqual([holding.state.value.moving, holding.state.value.code], [false, "lapsed"]);
  holding.release();
  socket.tell({});
  holding.move(TO, { power: 0.3 });
  live(200);
  pass(300, true);
  const asleep = said("hold").length;
  hold((said("hold").at(-1)!.hold as { n: number }).n, lapsed);
  assert.equal(said("hold").length, asleep);
  assert.deepEqual([holding.state.value.moving, holding.state.value.code], [false, "asleep"]);
});

test("a page that slept takes its own hand off, and begins nothing until the hand has rested", () => {
  holding.move(TO, { power: 0.3 });
  live(200);
  socket.said.length = 0;
  pass(2000, true);
  assert.deepEqual(said("keep"), []);
  assert.equal(said("release").length, 1);
  assert.equal(holding.state.value.code, "lapsed");
  assert.ok(!holding.move(TO, { power: 0.4 }));
  holding.release();
  socket.tell({});
  assert.ok(holding.move(TO, { power: 0.4 }));
});

test("what ends by itself outlasts a page that draws slowly, and no page that sleeps", () => {
  holding.play("joints/play", { motion: "wave" });
  live(200);
  pass(2000, true);
  socket.tell({});
  assert.ok(holding.state.value.moving);
  pass(3500, true);
  assert.ok(!holding.state.value.moving);
});

test("a line that is half open is noticed: the hand comes off, the sign says so, and it is opened again", () => {
  holding.move(TO, { power: 0.3 });
  pass(1100);
  assert.equal(holding.state.value.moving, false);
  pass(300);
  assert.equal(link.value, "quiet");
  pass(3500);
  assert.equal(link.value, "lost");
  pass(400);
  assert.notEqual(Socket.all.at(-1), socket);
});

test("a cut line takes the hand off, and a new one moves nothing by itself", () => {
  holding.move(TO, { power: 0.3 });
  socket.cut();
  assert.ok(!holding.state.value.moving);
  pass(400);
  const next = Socket.all.at(-1)!;
  next.open();
  next.tell({});
  pass(1000);
  assert.deepEqual(next.said.filter((one) => "hold" in one || "keep" in one), []);
});

test("how old what is driven by is, and what that leaves of the speed, is known while the hand is on", () => {
  holding.move(TO, { power: 0.3 });
  socket.tell({ link: { age_ms: 310, speed: 0.5 } });
  assert.deepEqual(pace.value, { age_ms: 310, speed: 0.5 });
  live(500);
  assert.equal(pace.value?.speed, 0.5);
  holding.release();
  assert.equal(pace.value, null);
});

test("a refusal ends it until the hand has rested, and says who has it", () => {
  holding.move(TO, { power: 0.3 });
  const { n } = said("hold")[0]!.hold as { n: number };
  hold(n, { holds: false, code: "held", reason: "another has it", holder: "web:tablet" });
  assert.deepEqual({ ...holding.state.value, reason: "" }, { moving: false, to: TO, holds: false, code: "held", reason: "", holder: "web:tablet" });
  assert.ok(!holding.move(TO, { power: 0.4 }));
});

test("the reason of a refusal is shown until the hand that has to rest is off, and some seconds more", () => {
  holding.move(TO, { power: 0.3 });
  hold((said("hold")[0]!.hold as { n: number }).n, { holds: false, code: "obstacle", reason: "something is in the way" });
  refused.value = true;
  live(3 * SHOWN_MS);
  assert.equal(holding.state.value.code, "obstacle");
  holding.release();
  refused.value = false;
  live(SHOWN_MS / 2);
  assert.equal(holding.state.value.code, "obstacle");
  live(SHOWN_MS);
  assert.equal(holding.state.value.code, "");
});

test("what cannot be read changes nothing, and a wall clock that jumps neither", () => {
  holding.move(TO, { power: 0.3 });
  const real = Date.now;
  Date.now = () => real() + 1e9;
  socket.onmessage?.({ data: "{" });
  live(500);
  Date.now = real;
  assert.ok(holding.state.value.moving);
  assert.equal(status.value, null);
});

test("a page of another build loads itself once, then moves nothing", () => {
  assert.equal(compare("a", "a", ""), "same");
  assert.equal(compare("a", "", ""), "same");
  assert.equal(compare("a", "b", ""), "load");
  assert.equal(compare("a", "b", "b"), "old");
  assert.equal(compare("a", "c", "b"), "load");
  unsaved.add(1);
  noteBuild("b", "a");
  assert.deepEqual([reloads, outdated.value], [0, true], "what was typed is not lost");
  unsaved.add(-1);
  noteBuild("b", "a");
  assert.equal(reloads, 1);
  noteBuild("b", "a");
  assert.equal(reloads, 1);
  assert.ok(outdated.value);
  assert.ok(!holding.move(TO, { power: 0.3 }));
  assert.equal(holding.state.value.code, "old_page");
  assert.deepEqual([...said("hold")], []);
  kept.clear();
});

test("what was refused because another holds it is taken over: a motion at once, a hand with its next push", () => {
  holding.release();
  const n = (): number => (said("hold").at(-1)!.hold as { n: number }).n;
  const message = (): object => (said("hold").at(-1)!.hold as { message: object }).message;
  holding.play("motions/play", { motion: "wave" });
  hold(n(), { holds: false, code: "held", holder: "console" });
  holding.takeOver();
  assert.deepEqual(message(), { motion: "wave", take_over: true });
  hold(n());
  holding.release();
  assert.equal(holding.takesOver.value, false);
  holding.move(TO, { power: 0.3 });
  hold(n(), { holds: false, code: "held", holder: "console" });
  holding.release();
  const before = said("hold").length;
  holding.takeOver();
  assert.equal(said("hold").length, before);
  holding.move(TO, { power: 0.3 });
  assert.deepEqual(message(), { power: 0.3, take_over: true });
  holding.release();
});
