import { kept, pass, Socket } from "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { holding } from "../src/holding";
import { connect, disconnect } from "../src/live";
import type { Robot } from "../src/messages";
import { robot } from "../src/robot";
import { first } from "../src/views/drive/line";
import { toneOf, torques } from "../src/views/joints/tone";
import { deedName, learn } from "../src/words";
import { motions } from "../src/words/motions";

void kept;
learn(motions);
const REST = { moving: false, holds: false, code: "" };
const MOVING = { moving: true, limited_by: "" };

test("torque that is not known is neither held nor released", () => {
  const joints = { a: { id: 1, torque: null }, b: { id: 2 }, c: { id: 3, torque: 0 }, d: { id: 4, torque: 0.5 } };
  assert.deepEqual(torques(["a", "b", "c", "d", "e"], joints), { held: 1, limp: 1, unknown: 3 });
  assert.deepEqual(torques(["a"], undefined), { held: 0, limp: 0, unknown: 1 });
  assert.equal(toneOf({ id: 1, position_rad: 0.1, torque: null }), "doubt");
  assert.equal(toneOf({ id: 1, position_rad: 0.1, torque: 1 }), "held");
  assert.equal(toneOf({ id: 1, position_rad: 0.1, torque: 0 }), "limp");
});

test("what goes on beats what went wrong", () => {
  const slow = { ...REST, code: "lapsed" };
  assert.equal(first(slow, { moving: false, limited_by: "" }, false), "ended");
  assert.equal(first(slow, MOVING, false), "other");
  assert.equal(first({ ...slow, code: "held" }, MOVING, false), "ended");
  assert.equal(first({ moving: true, holds: true, code: "" }, MOVING, false), "mine");
  assert.equal(first(REST, { moving: true, limited_by: "front" }, false), "limited");
  assert.equal(first(REST, { moving: false, limited_by: "" }, false), "rest");
  assert.equal(first(REST, MOVING, true), "ended");
});

test("why a hand's motion ended is shown for 5 s, and the hand still has to come to rest", () => {
  disconnect();
  connect();
  const socket = Socket.all.at(-1)!;
  socket.open();
  socket.tell({});
  assert.ok(holding.move("drive/command", { power: 0.3 }));
  const told = socket.said.filter((one) => "hold" in one).at(-1)!.hold as { n: number };
  socket.tell({ hold: { n: told.n, holds: false, code: "fault", reason: "a motor is stuck", holder: "" } });
  assert.equal(holding.state.value.code, "fault");
  for (let left = 5100; left > 0; left -= 100) {
    pass(100);
    socket.tell({});
  }
  assert.equal(holding.state.value.code, "");
  assert.equal(holding.move("drive/command", { power: 0.3 }), false);
  holding.release();
  assert.ok(holding.move("drive/command", { power: 0.3 }));
  disconnect();
});

test("what the robot is is asked anew until it is of the rows that the robot runs by", async () => {
  disconnect();
  connect();
  const socket = Socket.all.at(-1)!;
  socket.open();
  robot.value = { revision: 1 } as Robot;
  const revisions = [1, 2, 2];
  globalThis.fetch = () => Promise.resolve(new Response(JSON.stringify({ revision: revisions.shift() })));
  for (let count = 3; count > 0; count -= 1) {
    socket.tell({ streams: { "@status": { age_ms: 0, message: { revision: 2 } } } });
    for (let left = 30; left > 0; left -= 1) await new Promise((done) => { setImmediate(done); });
  }
  assert.deepEqual([robot.value?.revision, revisions], [2, [2]]);
  disconnect();
});

test("a motion says what it does, and not what it is called elsewhere", () => {
  const [key, other] = ["reset", "my_bow"].map(deedName);
  assert.ok(key && !/reset|stop/i.test(key));
  assert.equal(other, "my bow");
});
