import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { noteBuild, outdated } from "../src/build";
import { drafts, keep } from "../src/views/system/drafts";
import { reloads } from "./stage";

test("what was typed is kept until it is saved or thrown away, and no page is loaded again under it", () => {
  keep(drafts, "phrase hello", { before: { text: "old" }, now: { text: "mine" } });
  assert.deepEqual(drafts.value["phrase hello"]?.now, { text: "mine" });
  noteBuild("another", "own");
  assert.equal(reloads, 0);
  assert.ok(outdated.value);
  keep(drafts, "phrase hello", null);
  assert.deepEqual(drafts.value, {});
  noteBuild("a third", "own");
  assert.equal(reloads, 1);
});
