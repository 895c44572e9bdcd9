import "./stage";
import assert from "node:assert/strict";
import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { language, maybe, TABLE, t } from "../src/words";

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
