import { pass, Socket } from "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { alike } from "../src/alike";
import { connect, disconnect, watch } from "../src/live";

test("what differs by less than is shown looks alike, by the unit in the field's name", () => {
  assert.ok(alike({ roll_rad: 0.001, voltage_v: 12.01 }, { roll_rad: 0.006, voltage_v: 11.98 }));
  assert.ok(!alike({ position_rad: 0.001 }, { position_rad: 0.006 }));
  assert.ok(!alike({ position_rad: null }, { position_rad: 0 }));
  assert.ok(alike({ others_m: { nose: 1 } }, { others_m: { nose: 1.01 } }));
  assert.ok(!alike({ others_m: { nose: 1 } }, { others_m: { nose: 1.03 } }));
  assert.ok(alike({ gyro_rps: [0.01, 0, 0] }, { gyro_rps: [0.02, 0, 0] }));
});

test("words, counts, fields that come and readings that fail are seen", () => {
  const state = { moving: false, frames: 3, status: { forward: "ok" } };
  assert.ok(alike(state, structuredClone(state)));
  for (const other of [{ ...state, moving: true }, { ...state, frames: 4 }, { ...state, status: { forward: "missing" } }, { ...state, reason: "" }, { ...state, frames: NaN }]) assert.ok(!alike(state, other));
});

test("when a message was made is not seen", () => {
  assert.ok(alike({ sequence: 1, measured_s: 2, loop: { rate_hz: 50 } }, { sequence: 9, measured_s: 8, loop: null }));
});

test("a stream that looks the same is not drawn again and stays young; after a silence it is", () => {
  disconnect();
  connect();
  const socket = Socket.all.at(-1)!;
  socket.open();
  const drawn: { message: unknown; ageMs(): number; stale(): boolean }[] = [];
  const end = watch("imu/state", (sample) => drawn.push(sample));
  const tell = (roll_rad: number): void => socket.tell({ streams: { "imu/state": { age_ms: 0, message: { roll_rad } } } });
  for (let count = 20; count > 0; count -= 1) {
    pass(100);
    tell(count % 2 === 0 ? 0.001 : 0.003);
  }
  assert.deepEqual(drawn.map((one) => [one.message, one.ageMs()]), [[{ roll_rad: 0.001 }, 0]]);
  tell(0.1);
  assert.equal(drawn.length, 2);
  pass(1600);
  assert.ok(drawn[1]!.stale());
  tell(0.1);
  assert.equal(drawn.length, 3);
  end();
  disconnect();
});
