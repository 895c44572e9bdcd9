// Who this browser is to the robot: its token, and requests that show it.
import { signal } from "@preact/signals";
import { remember, remembered } from "./kept";
import { notice } from "./notices";
import { language, maybe, t } from "./words";

export const token = signal<string>(remembered("token", ""));
/** The robot asks who this is. */
export const unknown = signal(false);
/** The robot refused the token that this browser had. */
export const revoked = signal(false);

export interface Answer<T = unknown> { ok: boolean; status: number; code: string; reason: string; data: T | null }
interface Options { method?: "GET" | "POST" | "DELETE"; body?: unknown; quiet?: boolean; keepalive?: boolean; timeoutMs?: number }

export const headers = (): Record<string, string> => (token.value ? { Authorization: `Bearer ${token.value}` } : {});

/** Asks the robot; never throws. A refusal is also shown, unless `quiet`. */
export async function ask<T>(path: string, { method = "GET", body, quiet = false, keepalive = false, timeoutMs = 8000 }: Options = {}): Promise<Answer<T>> {
  const answer = await asked<T>(path, { method, body, keepalive, timeoutMs });
  if (!answer.ok && !quiet) notice(told(answer), "warn", { code: answer.code, about: path.split("/")[1] });
  return answer;
}

/** Codes too general for a person: the robot's sentence names the fault. */
const VAGUE = new Set(["failed", "bad_value", "malformed", "unknown_name", "unknown_command", "not_possible", "busy", "check", "wiring", "exists", "changed", "limit"]);

/** A state's English sentence. In another language: the meaning of its code, with the sentence if the code is vague. */
export function inWords({ code = "", reason = "" }: { code?: string; reason?: string }): string {
  const meant = language.value === "en" ? "" : maybe(`code.${code}`);
  return meant && reason && !VAGUE.has(code) ? meant : [meant, reason].filter(Boolean).join(": ");
}

/** What a person reads of a refusal: the page's own sentence for its code, or else what the code means and the robot's sentence, which is in English and so is left out of another language where the code says enough. */
export function told(answer: Pick<Answer, "code" | "reason">): string {
  const own = maybe(`refused.${answer.code}`);
  if (own) return own;
  const meant = maybe(`code.${answer.code}`);
  const reason = meant && language.value !== "en" && !VAGUE.has(answer.code) ? "" : answer.reason;
  return [meant, reason].filter(Boolean).join(": ") || t("away.silent");
}

async function asked<T>(path: string, { method, body, keepalive, timeoutMs }: Required<Pick<Options, "method" | "keepalive" | "timeoutMs">> & { body?: unknown }): Promise<Answer<T>> {
  const shown = token.value;
  try {
    const answer = await fetch(path, {
      method,
      keepalive,
      credentials: "same-origin",
      headers: { ...headers(), ...(body === undefined ? {} : { "Content-Type": "application/json" }) },
      body: body === undefined ? undefined : JSON.stringify(body),
      signal: AbortSignal.timeout(timeoutMs),
    });
    const data = await read(answer);
    const reply = data as { accepted?: boolean; message?: string; reason?: string; code?: string | number; reason_code?: string; text?: string } | null;
    if (answer.status === 401 && method === "GET" && token.value === shown) unknown.value = true;
    const refused = !answer.ok || reply?.accepted === false || (typeof reply?.code === "number" && reply.code !== 0);
    const code = typeof reply?.code === "string" ? reply.code : reply?.reason_code ?? "";
    return { ok: !refused, status: answer.status, code, reason: reply?.message ?? reply?.reason ?? reply?.text ?? "", data: data as T };
  } catch (err) {
    const late = err instanceof DOMException && err.name === "TimeoutError";
    return { ok: false, status: 0, code: late ? "timeout" : "", reason: t("away.silent"), data: null };
  }
}

async function read(answer: Response): Promise<unknown> {
  const text = await answer.text();
  try {
    return text ? JSON.parse(text) : null;
  } catch {
    return { message: answer.ok ? "" : `${answer.status} ${answer.statusText}` };
  }
}

/** Takes a token as this browser's own, and a cookie for pictures; true if the robot knows it. */
export async function signIn(given: string): Promise<boolean> {
  token.value = given.trim();
  const answer = await ask("session", { method: "POST" });
  if (!answer.ok) {
    token.value = "";
    return false;
  }
  remember("token", token.value);
  unknown.value = revoked.value = false;
  return true;
}

/** Gives up the token; true if there was one. */
export function forget(): boolean {
  const had = token.value !== "";
  token.value = "";
  remember("token", null);
  return had;
}

export async function signOut(): Promise<void> {
  await ask("session", { method: "DELETE", quiet: true });
  forget();
  location.reload();
}

/** Pairs by six digits; true once this browser has a token of its own. */
export async function pair(code: string, name: string): Promise<boolean> {
  const answer = await ask<{ token: string; role: string }>("api/pair", { method: "POST", body: { code: code.replace(/\D/g, ""), name }, quiet: true });
  if (!answer.ok) notice(answer.code === "token" ? t("sign.wrong") : told(answer), "warn");
  if (!answer.ok || !answer.data) return false;
  return signIn(answer.data.token);
}

/** What the address brought behind its #: a token or a code to pair; taken out of the address bar at once. */
export function given(): { token: string; code: string } {
  const found = new URLSearchParams(location.hash.slice(1));
  const [shown, code] = [found.get("token") ?? "", found.get("pair") ?? found.get("code") ?? ""];
  if (shown || code) history.replaceState(null, "", location.pathname + location.search);
  return { token: shown, code };
}
