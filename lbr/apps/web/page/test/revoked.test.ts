import { kept, pass, Socket } from "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { revoked, signIn, token, unknown } from "../src/access";
import { connect, link } from "../src/live";
import { look, robot } from "../src/robot";

const answers = (status: number) => (): Promise<Response> => Promise.resolve(new Response(status === 200 ? '{"robot": "lbr"}' : "{}", { status }));
const settled = async (): Promise<void> => { for (let left = 30; left > 0; left -= 1) await new Promise((done) => { setImmediate(done); }); };

test("a page whose token was revoked says so, and tries no more", async () => {
  token.value = "ann.secret";
  kept.set("lbr.token", '"ann.secret"');
  globalThis.fetch = answers(200);
  connect();
  Socket.all.at(-1)!.open();
  globalThis.fetch = answers(401);
  Socket.all.at(-1)!.cut();
  await settled();
  assert.deepEqual([revoked.value, robot.value, token.value, kept.has("lbr.token")], [true, null, "", false]);
  const opened = Socket.all.length;
  pass(5000);
  assert.deepEqual([Socket.all.length, link.value], [opened, "refused"]);
});

test("a refusal of what was asked before this device signed in takes no token away", async () => {
  token.value = "";
  revoked.value = false;
  let refuse = (): void => undefined;
  const late = new Promise<Response>((done) => { refuse = () => { done(new Response("{}", { status: 401 })); }; });
  globalThis.fetch = () => late;
  const looking = look();
  globalThis.fetch = answers(200);
  await signIn("ann.secret");
  refuse();
  await looking;
  assert.deepEqual([token.value, revoked.value, unknown.value, robot.value?.robot], ["ann.secret", false, false, "lbr"]);
});
