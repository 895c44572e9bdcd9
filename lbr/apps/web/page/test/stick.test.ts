import assert from "node:assert/strict";
import { test } from "node:test";
import { aim, alike, CURVE, DEAD, ofKeys, SNAP_DEG, together, twist } from "../src/stick";

test("a thumb that only lies there moves nothing, and nothing moves by what is no number", () => {
  for (const [x, y] of [[0, 0], [DEAD * 0.99, 0], [NaN, 0.5], [0.5, Infinity]] as const) assert.equal(aim(x, y), null);
  assert.equal(aim(1, 0, NaN), null);
  assert.equal(aim(1, 0, 0), null);
});

test("power grows with the way, never above what is allowed", () => {
  let before = 0;
  for (let way = DEAD; way <= 1.5; way += 0.01) {
    const { power } = aim(0, way, 0.6)!;
    assert.ok(power >= before && power <= 0.6 && power >= 0.02);
    before = power;
  }
  assert.equal(before, 0.6);
  assert.ok(CURVE > 1, "fine near the middle");
});

test("each way has its angle, clockwise from ahead, and the axes are easy to hit", () => {
  for (let degrees = 0; degrees < 360; degrees += 1) {
    const angle = (degrees * Math.PI) / 180;
    const found = aim(Math.sin(angle), Math.cos(angle))!.angle_deg;
    const off = Math.min(...[0, 90, 180, 270, 360].map((axis) => Math.abs(degrees - axis)));
    const wanted = off <= SNAP_DEG ? (Math.round(degrees / 90) * 90) % 360 : degrees;
    assert.equal(found, wanted, `${degrees}`);
  }
});

test("keys stand for a stick, and opposite ones cancel one another", () => {
  assert.deepEqual(ofKeys(new Set(["ArrowUp"])), { x: 0, y: 1, turn: 0 });
  assert.deepEqual(ofKeys(new Set(["KeyA", "KeyD", "KeyS"])), { x: 0, y: -1, turn: 0 });
  assert.deepEqual(ofKeys(new Set(["ArrowUp", "KeyS"])), { x: 0, y: 0, turn: 0 });
  assert.equal(ofKeys(new Set(["KeyE", "KeyQ"])).turn, 0);
  assert.equal(ofKeys(new Set(["KeyE"])).turn, 1);
  const { x, y } = ofKeys(new Set(["KeyW", "ArrowRight"]));
  assert.ok(Math.abs(Math.hypot(x, y) - 1) < 1e-9);
});

test("what is alike is told once", () => {
  assert.ok(alike(null, null));
  assert.ok(!alike(null, aim(0, 1)));
  assert.ok(alike(aim(0, 1), aim(0.01, 1)));
});

test("a base that goes sideways goes left for minus, turns clockwise for plus, and stands for what is no number", () => {
  const most = { max_speed_mps: 0.5, max_turn_rps: 2 };
  assert.deepEqual(twist({ x: 1, y: 0, turn: 0 }, most), { vx_mps: 0, vy_mps: -0.5, wz_rps: 0 });
  assert.deepEqual(twist({ x: 0, y: 1, turn: 1 }, most), { vx_mps: 0.5, vy_mps: 0, wz_rps: -2 });
  assert.equal(twist({ x: 0, y: 0, turn: NaN }, most), null);
  assert.equal(twist({ x: DEAD / 2, y: 0, turn: DEAD / 2 }, most), null);
  assert.deepEqual(together([{ x: 0.2, y: 0, turn: 0 }, { x: 0, y: 0.9, turn: -1 }]), { x: 0, y: 0.9, turn: -1 });
  assert.deepEqual(together([{ x: 1, y: 0, turn: 0 }, { x: NaN, y: 0, turn: 0 }]), { x: 0, y: 0, turn: 0 });
});
