import "./stage";
import assert from "node:assert/strict";
import { test } from "node:test";
import { age, between, degrees, heading, metres, nameLetters, NONE, number, percent, plain, tickText, timeOfDay, wind } from "../src/format";

test("what is not known is a dash, never a number", () => {
  for (const nothing of [null, undefined, NaN, Infinity]) {
    for (const show of [number, metres, degrees, percent, age]) assert.equal(show(nothing), NONE);
  }
  assert.equal(timeOfDay(0), NONE);
});

test("numbers are written by the page's language, and minus nothing is nothing", () => {
  assert.equal(number(1234.5, 1, "en"), "1,234.5");
  assert.equal(number(1234.5, 1, "de"), "1.234,5");
  assert.equal(number(-0.004, 1, "en"), "0.0");
});

test("no two lines of an axis say the same", () => {
  const axis = (apart: number, language: string): string[] => [-1, 0, 1, 2].map((line) => tickText(line * apart, apart, language));
  assert.deepEqual(axis(0.0005, "de"), ["-0,0005", "0,0000", "0,0005", "0,0010"]);
  assert.deepEqual(axis(0.25, "en"), ["-0.25", "0.00", "0.25", "0.50"]);
  assert.deepEqual(axis(200, "en"), ["-200", "0", "200", "400"]);
});

test("lengths and ages have the unit that people would say", () => {
  assert.deepEqual([metres(0.5), metres(1.234), metres(12.34)], ["50 cm", "1.23 m", "12.3 m"]);
  assert.deepEqual([age(200), age(12_000), age(180_000), age(7_200_000), age(-5)], ["0.2 s", "12 s", "3 min", "2 h", "0.0 s"]);
});

test("headings stay on the compass, and turns take the shorter way", () => {
  assert.deepEqual([heading(-90), heading(720), wind(359), wind(46), wind(90, "de")], [270, 0, "N", "NE", "O"]);
  assert.deepEqual([between(350, 10), between(10, 350), between(0, 180)], [20, -20, -180]);
  assert.equal(plain("left_shoulder_roll"), "left shoulder roll");
});

test("a text keeps its letters where it becomes a name, without their accents", () => {
  assert.equal(nameLetters("Été à l'école"), "ete_a_l_ecole");
  assert.equal(nameLetters("walk_2"), "walk_2");
});
