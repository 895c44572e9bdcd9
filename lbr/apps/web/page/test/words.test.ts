import "./stage";
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { dirname, join, relative } from "node:path";
import { test } from "node:test";
import { jointName, language, learn, maybe, TABLE, t } from "../src/words";
import { behaviours } from "../src/words/behaviours";
import { below } from "../src/words/below";
import { call } from "../src/words/call";
import { joints } from "../src/words/joints";
import { motions } from "../src/words/motions";
import { system } from "../src/words/system";

const OF_VIEWS: Record<string, object> = { behaviours, below, call, joints, motions, system };
const FIRST = { ...TABLE };
Object.values(OF_VIEWS).forEach(learn);
const SOURCES = join(process.cwd(), "src");
const names = (text: string): string[] => [...text.matchAll(/\{(\w+)\}/g)].map((found) => found[1]!).sort();
const files = readdirSync(SOURCES, { recursive: true, encoding: "utf8" }).filter((name) => /\.tsx?$/.test(name));
const texts = files.map((name) => readFileSync(join(SOURCES, name), "utf8"));
const said = texts.join("\n");

test("each text is there in both languages, with the same places to fill", () => {
  for (const [key, both] of Object.entries(TABLE)) {
    assert.equal(both.length, 2, key);
    const [english, german] = both;
    assert.ok(english.trim() && german.trim(), key);
    assert.deepEqual(names(english), names(german), key);
    assert.ok(!/\s$|^\s| {2}/.test(english + german), key);
  }
});

test("no two tables say the same key", () => {
  const keys = files.map((name, at) => ({ name, at })).filter(({ name }) => name.startsWith("words")).flatMap(({ at }) => [...texts[at]!.matchAll(/^\s{2}"([^"]+)":/gm)].map((found) => found[1]!));
  assert.deepEqual(keys.filter((key, at) => keys.indexOf(key) !== at), []);
});

test("what the page says is in the table", () => {
  const used = [...said.matchAll(/\bt\("([^"]+)"/g)].map((found) => found[1]!);
  assert.ok(used.length > 50);
  assert.deepEqual(used.filter((key) => !(key in TABLE)), []);
});

test("a text is filled, and a key that the table lacks is nothing", () => {
  language.value = "en";
  assert.equal(t("age.stale", { age: "2 s" }), "2 s old");
  language.value = "de";
  assert.equal(t("age.stale", { age: "2 s" }), "2 s alt");
  assert.equal(maybe("code.of_tomorrow"), "");

});

/** A module and all that it imports at once, by their names. */
function closure(name: string, found = new Set<string>()): Set<string> {
  if (found.has(name)) return found;
  found.add(name);
  for (const [, path] of texts[files.indexOf(name)]!.matchAll(/^import (?!type).*?from "(\.[^"]+)"/gm)) {
    const wanted = relative(SOURCES, join(SOURCES, dirname(name), path!));
    const there = [`${wanted}.ts`, `${wanted}.tsx`, `${wanted}/index.tsx`].find((one) => files.includes(one));
    if (there) closure(there, found);
  }
  return found;
}

test("a view brings the words that it says, and the first load none of the others'", () => {
  const main = closure("main.tsx");
  const views = [...said.matchAll(/import\("\.\/(views\/[^"]+)"\)/g)].map((found) => `${found[1]}.tsx`);
  assert.ok(views.length > 5);
  for (const view of views) {
    const all = closure(view, new Set(main));
    const brought: object = Object.assign({ ...FIRST }, ...[...all].filter((name) => name.startsWith("words/")).map((name) => OF_VIEWS[name.slice(6, -3)]));
    const lacking = [...all].filter((name) => !name.startsWith("words")).flatMap((name) => [...texts[files.indexOf(name)]!.matchAll(/"([a-z0-9_]+(?:\.[a-z0-9_]+)+)"/g)].map((found) => found[1]!).filter((key) => key in TABLE && !(key in brought)).map((key) => `${name}: ${key}`));
    assert.deepEqual(lacking, [], view);
  }
  assert.deepEqual([...main].filter((name) => Object.keys(OF_VIEWS).some((one) => name === `words/${one}.ts`)), []);
});

test("a joint is named in the page's language, and as its row where a word is unknown", () => {
  language.value = "de";
  assert.deepEqual(["left_shoulder_pitch", "head_pitch", "right_knee", "gripper"].map(jointName), ["Schulter vor und zurück links", "Kopf vor und zurück", "Knie rechts", "gripper"]);
  language.value = "en";
  assert.equal(jointName("left_shoulder_pitch"), "left shoulder pitch");
});
