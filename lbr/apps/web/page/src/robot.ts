// What the robot is: GET /api, asked again when its rows change; and what a page asks of it.
import { computed, signal } from "@preact/signals";
import { ask, forget, revoked, token, type Answer } from "./access";
import { OLD, outdated } from "./build";
import { notice } from "./notices";
import { maybe, t } from "./words";
import type { Capability, CommandReply, Role, Robot, Schema } from "./messages";

export { ask as fetchJson } from "./access";
export const robot = signal<Robot | null>(null);
export const role = computed<Role | null>(() => robot.value?.role ?? null);

const RANK: Record<Role, number> = { view: 0, operate: 1, admin: 2 };
const LISTS = ["capabilities", "words", "joints", "motions", "cameras", "wheels", "ranges", "buttons", "phrases"] as const;
const AGAIN_MS = 2000;
let asking: Promise<void> | null = null;
let again: ReturnType<typeof setTimeout> | undefined;
/** Nothing answered where the robot was asked what it is; it is asked again. */
export const away = signal(false);

/** Asks what the robot is; asks again until it answers. */
export function look(): Promise<void> {
  clearTimeout(again);
  asking ??= looked().finally(() => { asking = null; });
  return asking;
}

async function looked(): Promise<void> {
  const shown = token.value;
  const answer = await ask<Robot>("api", { quiet: true });
  away.value = answer.status === 0;
  if (answer.ok && answer.data) robot.value = whole(answer.data);
  else if (answer.status === 401) await (token.value === shown ? refused() : looked()); // else it signed in meanwhile
  else again = setTimeout(() => void look(), AGAIN_MS);
}

/** Without its token a browser may look where its place is trusted; elsewhere it is a stranger, and signs in. */
async function refused(): Promise<void> {
  if (!forget()) {
    robot.value = null;
    return;
  }
  revoked.value = true;
  await looked();
  if (robot.value) notice(t("sign.revoked"), "warn");
}

/** An older robot may lack lists that this page knows. */
function whole(told: Robot): Robot {
  const lists = Object.fromEntries(LISTS.map((name) => [name, Array.isArray(told[name]) ? told[name] : []]));
  return { ...told, ...lists };
}

export const may = (needed: Role): boolean => role.value !== null && RANK[role.value] >= RANK[needed];

/** The capabilities of a kind, such as `drive`. */
export const capabilities = (kind: string): Capability[] => robot.value?.capabilities.filter((one) => one.kind === kind) ?? [];

/** The name of a message by its schema. */
export const typeOf = (schema: Schema | undefined): string => schema?.title ?? schema?.$ref?.split("/").pop() ?? "";

/** All streams whose messages are of a type, such as `["ranges/readings"]` of `Ranges`. */
export function streamsOfType(type: string): string[] {
  return (robot.value?.capabilities ?? []).flatMap((one) =>
    Object.entries(one.outputs ?? {}).filter(([, schema]) => typeOf(schema) === type).map(([output]) => `${one.name}/${output}`),
  );
}

/** The first stream whose messages are of a type; empty if there is none. */
export const streamOfType = (type: string): string => streamsOfType(type)[0] ?? "";

/** Whether the console knows a word, and this user may say it. */
export const knows = (word: string): boolean => robot.value?.words.some((one) => one.word === word && may(one.role)) ?? false;

/** A page that is behind its robot asks for nothing that may move it; to stop is no command. */
async function asked<T>(path: string, options: Parameters<typeof ask>[1] & object): Promise<Answer<T>> {
  if (!outdated.value) return ask<T>(path, options);
  const answer = { ok: false, status: 409, code: OLD.code, reason: OLD.reason(), data: null };
  if (!options.quiet) notice(answer.reason, "warn");
  return answer;
}

/** The capabilities that have a command. */
export const able = (name: string): string[] => (robot.value?.capabilities ?? []).filter(({ commands }) => commands[name]).map((one) => one.name);

/** Asks a capability for something. What it leaves undone of that is shown, as a refusal is. */
export async function command(capability: string, name: string, message: unknown, options: { quiet?: boolean; timeoutMs?: number } = {}): Promise<Answer<CommandReply>> {
  const answer = await asked<CommandReply>(`api/${capability}/${name}`, { method: "POST", body: message, ...options });
  const undone = answer.ok && !options.quiet ? maybe(`undone.${answer.code}`) : "";
  if (undone) notice(undone, "warn");
  return answer;
}

/** Has the console carry out a line, as if it were typed there. */
export const consoleLine = (line: string, options: { quiet?: boolean; timeoutMs?: number } = {}): Promise<Answer<{ text?: string; data?: unknown; confirm?: string }>> =>
  asked(`api/console`, { method: "POST", body: { line }, timeoutMs: 20_000, ...options });
