// Two people, one robot: who wants what another holds asks for it, and the holder hands it over or goes on. An agent asks, too.
import { signal } from "@preact/signals";
import { ask } from "./access";
import { plain } from "./format";
import { holding } from "./holding";
import { onEvent } from "./live";
import { Mend } from "./mend";
import { notice } from "./notices";
import { Button, Icon } from "./parts";
import { able, command, may, streamOfType } from "./robot";
import { t, type WordKey } from "./words";

interface Asker { by: string; capability: string }
interface Question { text: string; yes: WordKey; agree: () => void }
/** What somebody asks of this page's user, and what a yes does. */
const question = signal<Question | null>(null);
/** How long a question stays on the screen: of another person, of an agent. */
const SHOWN_MS = 20_000, AGENT_MS = 60_000;
/** How long a handover is taken for the answer to what was asked here. */
const AWAITED_MS = 120_000;
let wanted = { capability: "", at: 0 };

/** Asks the holder of a capability, such as `drive`, for it. */
export async function askFor(capability: string): Promise<void> {
  wanted = { capability, at: performance.now() };
  if ((await ask("api/ask", { method: "POST", body: { capability } })).ok) notice(t("hand.asked"), "info");
}

function show(asked: Question, forMs: number): void {
  question.value = asked;
  navigator.vibrate?.(80);
  setTimeout(() => { if (question.value === asked) question.value = null; }, forMs);
}

function handOver({ by, capability }: Asker): void {
  holding.release();
  void ask("api/hand_over", { method: "POST", body: { capability, to: by } });
}

const allow = (agent: string): void => able("allow").forEach((owner) => void command(owner, "allow", { agent }));

/** Who that is, as people say it: a page without a token is known by its address, a program by its machine. */
export function named(source: string): string {
  const name = source.replace(/^web:/, "").replace(/@([^@:]+):\d+$/, " ($1)");
  return /^(127\.\d|::1$)/.test(name) ? t("hand.here") : name;
}

/** Whether a person ended a run on a page: then it did not fail. */
export const byPage = ({ reason }: { reason: string }): boolean => /^stopped by web:|page$/.test(reason);

onEvent.add(({ kind, code, data }) => {
  const { by, capability, agent } = (data ?? {}) as Partial<Asker> & { agent?: unknown };
  if (code === "confirm" && typeof agent === "string" && may("operate") && able("allow").length > 0) {
    show({ text: t("hand.wants.agent", { agent }), yes: "hand.allow", agree: () => allow(agent) }, AGENT_MS);
  }
  if (typeof by !== "string" || typeof capability !== "string") return;
  const { holds, to } = holding.state.value;
  if (kind === "asked_for" && holds && to.startsWith(`${capability}/`)) {
    const asked = { by, capability };
    show({ text: wish(asked), yes: "hand.over", agree: () => handOver(asked) }, SHOWN_MS);
  } else if (kind === "handed_over" && wanted.capability === capability && performance.now() - wanted.at < AWAITED_MS) {
    wanted = { capability: "", at: 0 };
    notice(t("hand.yours", { by: named(by) }), "good");
  }
});

const wish = ({ by, capability }: Asker): string => {
  const drives = capability === streamOfType("DriveState").split("/")[0];
  return drives ? t("hand.wants.drive", { by: named(by) }) : t("hand.wants", { by: named(by), what: plain(capability) });
};

/** Says that another holds what was asked for here, and asks the holder for it. */
export function Held({ capability }: { capability: string }) {
  const { code, holder, to } = holding.state.value;
  if (code !== "held" || !to.startsWith(`${capability}/`) || !may("operate")) return null;
  return (
    <div class="held" role="status">
      <Icon name="person" />
      <p><strong>{holder ? t("hand.holds", { holder: named(holder) }) : t("code.held")}</strong></p>
      <Mend code={code} about={capability} />
    </div>
  );
}

/** The question of another or of an agent, and its answers; it moves nothing else on the screen, for a thumb may be on the stick. */
export function Asked() {
  const asked = question.value;
  if (!asked) return null;
  return (
    <div class="notice notice-ask" role="alert">
      <Icon name="person" />
      <p><strong>{asked.text}</strong></p>
      <Button kind="primary" onClick={() => { question.value = null; asked.agree(); }}>{t(asked.yes)}</Button>
      <Button kind="quiet" onClick={() => { question.value = null; }}>{t("hand.later")}</Button>
    </div>
  );
}
