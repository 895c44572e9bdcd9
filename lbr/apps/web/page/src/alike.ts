// Whether two messages look the same to a person. A message that looks like the shown one is not drawn again. Pure.

/** The smallest change of a number that is drawn, by its name or by the unit at the end of its name. It is the last digit shown, or the noise of a sensor at rest. */
const SEEN: Readonly<Record<string, number>> = { m: 0.02, mps: 0.01, mps2: 0.2, rad: 0.002, rps: 0.02, dps: 1, deg: 0.8, v: 0.06, a: 0.06, c: 0.6, percent: 1, hz: 1, roll_rad: 0.009, pitch_rad: 0.009, yaw_rad: 0.014 };
/** The same for numbers without a unit: fractions and counts. */
const OTHERS = 0.01;
/** Fields that no view shows: times and numbers of measurements, and raw values. */
const UNSEEN = new Set(["sequence", "measured_s", "counted_s", "time_s", "cycle_s", "age_s", "ages_s", "span_s", "raw", "mag_ut", "loop"]);

/** The smallest drawn change of a field. A field named by the robot, such as a sensor, has that of its list. */
const least = (field: string, list: number): number => SEEN[field] ?? SEEN[field.slice(field.lastIndexOf("_") + 1)] ?? list;

export function alike(one: unknown, other: unknown, seen = OTHERS): boolean {
  if (one === other) return true;
  if (typeof one === "number" && typeof other === "number") return Math.abs(one - other) < seen;
  if (typeof one !== "object" || typeof other !== "object" || !one || !other) return false;
  const fields = Object.keys(one);
  if (fields.length !== Object.keys(other).length) return false;
  return fields.every((field) => UNSEEN.has(field) || alike(one[field as never], other[field as never], least(field, seen)));
}
