// Where the states of a table are drawn: in layers by how many steps they are from the start, ways between them as curves.
import type { Step } from "./data";

export interface Box { state: string; kind: "" | "start" | "end" | "fail"; reached: boolean; x: number; y: number }
/** A way from a state to another: one curve, whose `texts` say what each row that leads there waits for. */
export interface Way { from: string; to: string; path: string; x: number; y: number; beside: boolean; texts: string[] }
export interface Drawing { width: number; height: number; boxes: Box[]; ways: Way[] }

export const WIDE = 148, HIGH = 40;
const ACROSS = 44, DOWN = 58, EDGE = 18, BOW = 26;

export function draw(rows: Step[]): Drawing {
  const used = rows.filter((row) => row.type !== "#" && row.state !== "");
  const order = [...new Set(used.map((row) => row.state))];
  const kinds = new Map<string, Box["kind"]>();
  for (const row of [...used].reverse()) if (row.type === "start" || row.type === "end" || row.type === "fail") kinds.set(row.state, row.type);
  const start = used.find((row) => row.type === "start")?.state ?? order[0];
  const depth = depths(used, order, start);
  const failure = used.find((row) => row.type === "fail")?.state;
  const last = Math.max(0, ...depth.values());
  const layers: string[][] = [];
  for (const state of order) (layers[depth.get(state) ?? last + 1] ??= []).push(state);
  const full = layers.filter((one) => one !== undefined);
  const most = Math.max(1, ...full.map((layer) => layer.length));
  const loops = used.some((row) => row.next_state !== "" && !isBelow(depth, row.state, row.next_state));
  const width = most * (WIDE + ACROSS) - ACROSS + 2 * EDGE + (loops ? 6.6 * BOW : 0);
  const middle = EDGE + (most * (WIDE + ACROSS) - ACROSS) / 2;
  const boxes: Box[] = full.flatMap((layer, row) => layer.map((state, at) => ({
    state, kind: kinds.get(state) ?? "", reached: depth.has(state) || state === failure,
    x: middle + (at - (layer.length - 1) / 2) * (WIDE + ACROSS), y: EDGE + HIGH / 2 + row * (HIGH + DOWN),
  })));
  const places = new Map(boxes.map((box) => [box.state, box]));
  const ways = new Map<string, Way>();
  for (const row of used) {
    const from = places.get(row.state), to = places.get(row.next_state), pair = `${row.state}\n${row.next_state}`;
    if (!from || !to || row.type === "end" || row.type === "fail" || row.type === "entry") continue;
    const way = ways.get(pair) ?? { from: row.state, to: row.next_state, texts: [], ...curve(from, to) };
    way.texts.push(said(row));
    ways.set(pair, way);
  }
  return { width, height: full.length * (HIGH + DOWN) - DOWN + 2 * EDGE, boxes, ways: [...ways.values()] };
}

function depths(used: Step[], order: string[], start: string | undefined): Map<string, number> {
  const depth = new Map<string, number>(start === undefined ? [] : [[start, 0]]), waiting = start === undefined ? [] : [start];
  while (waiting.length > 0) {
    const state = waiting.shift()!;
    for (const row of used) {
      if (row.state !== state || !order.includes(row.next_state) || depth.has(row.next_state)) continue;
      depth.set(row.next_state, depth.get(state)! + 1);
      waiting.push(row.next_state);
    }
  }
  return depth;
}

const isBelow = (depth: Map<string, number>, from: string, to: string): boolean => (depth.get(to) ?? 0) > (depth.get(from) ?? 0);

/** Down a layer nearly straight, its text above where it ends; to itself as a loop; up, or past a layer, in a bow to the right. */
function curve(a: Box, b: Box): Pick<Way, "path" | "x" | "y" | "beside"> {
  const half = HIGH / 2;
  if (a.state === b.state) {
    const x = a.x + WIDE / 2, out = x + BOW;
    return { path: `M${x} ${a.y - 8} C${out} ${a.y - 24} ${out} ${a.y + 24} ${x} ${a.y + 8}`, x: out + 22, y: a.y - 12, beside: true };
  }
  if (b.y > a.y && b.y - a.y <= HIGH + DOWN) {
    const y1 = a.y + half, y2 = b.y - half;
    return { path: `M${a.x} ${y1} C${a.x} ${y1 + 30} ${b.x} ${y2 - 30} ${b.x} ${y2}`, x: b.x, y: y2 - 19, beside: false };
  }
  const x1 = a.x + WIDE / 2, x2 = b.x + WIDE / 2, far = Math.max(x1, x2) + BOW + Math.min(24, 0.06 * Math.abs(a.y - b.y));
  return { path: `M${x1} ${a.y} C${far} ${a.y} ${far} ${b.y} ${x2} ${b.y}`, x: 0.25 * (x1 + x2) / 2 + 0.75 * far, y: (a.y + b.y) / 2, beside: false };
}

export const said = (row: Step): string => Object.entries(row.conditions).filter(([, cell]) => cell.trim() !== "").map(([column, cell]) => `${column} ${cell}`).join(", ");
