import assert from "node:assert/strict";
import { test } from "node:test";
import { SURE, WorldMap } from "../src/views/drive/map";

test("a map of a base that stands changes until what it sees is sure, and no more", () => {
  const world = new WorldMap();
  const look = (x: number): number => {
    const before = world.changes;
    world.move({ x, y: 0, yaw: 0.001 * x }, "one");
    world.see([{ x: 1, y: 0 }]);
    return world.changes - before;
  };
  look(0);
  for (let count = 1; count < SURE; count += 1) assert.equal(look(count % 2 ? 0.001 : 0), 1);
  assert.equal(look(0.001), 0);
  assert.equal(look(0.1), 2);
  assert.equal(world.cells.size, 2);
});
