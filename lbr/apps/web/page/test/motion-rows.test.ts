import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { move } from "../src/views/motions/rows";

const ROWS: Record<string, object[]> = {
  motion: [{ name: "bow", lead_in: "stand" }, { name: "nod", lead_in: "" }],
  motion_step: [{ motion: "bow", step: 1 }, { motion: "nod", step: 1 }],
};

test("a motion is renamed with its key frames and what leads to it, or deleted with them, in one change", async () => {
  const sent: { changes: object[]; write: boolean }[] = [];
  globalThis.fetch = (path, options) => {
    if (options?.body) sent.push(JSON.parse(String(options.body)) as (typeof sent)[0]);
    const rows = ROWS[String(path).split("/").at(-1)!] ?? [];
    return Promise.resolve(new Response(JSON.stringify({ accepted: true, data: { rows } })));
  };
  assert.ok(await move("bow", "greet"));
  assert.ok(await move("bow", null));
  const [whole, step] = [ROWS["motion"]![0]!, ROWS["motion_step"]![0]!];
  const gone = [{ table: "motion", before: whole, after: null }, { table: "motion_step", before: step, after: null }];
  assert.deepEqual(sent[1], { changes: gone, write: true });
  assert.deepEqual(sent[0], { changes: [gone[0], { table: "motion", before: null, after: { ...whole, name: "greet" } }, gone[1], { table: "motion_step", before: null, after: { ...step, motion: "greet" } }], write: true });
});
