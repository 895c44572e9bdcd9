import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { calledOf, inOrder, rename, type Token } from "../src/views/system/manage";

const token = (name: string, called: string | null = null, revoked_at: string | null = null): Token => ({ name, called, revoked_at, role: "view", created_at: "", expires_at: null, good_for: "web", paired_from: null });

test("tokens stand in the order of what people call them, those that are locked out last", () => {
  const all = [token("a-tablet", null, "2026-01-01"), token("phone", "Zoe"), token("z-phone", "Ann"), token("desk")];
  assert.deepEqual(inOrder(all).map(calledOf), ["Ann", "desk", "Zoe", "a-tablet"]);
});

test("a token is renamed by its own name, which it keeps", async () => {
  const sent: [string, unknown][] = [];
  globalThis.fetch = (url, options) => {
    sent.push([String(url), JSON.parse(String(options?.body))]);
    return Promise.resolve(new Response("{}", { status: 200 }));
  };
  await rename("phone", "Ann");
  assert.deepEqual(sent.map(([url, body]) => [new URL(url, "http://robot/").pathname, body]), [["/api/tokens/rename", { name: "phone", called: "Ann" }]]);
});
