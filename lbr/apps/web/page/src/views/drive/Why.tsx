// One line that always says what the base does, who holds it, or why it does not move.
import type { Ref } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";

import { inWords, told } from "../../access";
import { illness, unwell } from "../../lacking";
import { Mend } from "../../mend";
import { notices } from "../../notices";
import { number, percent, plain } from "../../format";
import { byPage, named } from "../../handover";
import { holding, refused } from "../../holding";
import { clock, pace, useStream, type Pace } from "../../live";
import type { BatteryState, DriveState } from "../../messages";
import { useNews } from "../../news";
import { Button, Icon, Stale, type IconName } from "../../parts";
import { consoleLine, fetchJson, knows, may, robot, role, streamOfType } from "../../robot";
import { maybe, t } from "../../words";
import type { Run } from "../behaviours/data";
import { first } from "./line";

/** The robot's own answer: the first link that holds it, and what to type. */
interface Chain { state: string; text: string; code: string; do: string }

interface Line { tone: "calm" | "good" | "warn" | "bad"; icon: IconName; head: string; text: string; code?: string }

/** What the base tells of itself, whether its last end is news, what runs it, and whether it is on a charger. */
interface Told { drive: DriveState | null; fresh: boolean; run: Run | null; failed: boolean; charging: boolean; part: string }

/** An end for want of a change is told so long before. */
const TOLD_S = 8;
/** One looks at something else while a table runs. */
const FAILED_MS = 60_000;
/** A run that somebody ended on a page, or by the emergency stop, did not fail. */
const failedBy = (run: Run): boolean => run.phase === "ended" && run.good === false && run.code !== "estop" && !byPage(run);

export function Why({ from }: { from: string }) {
  void clock.value;
  const sample = useStream<DriveState>(from);
  const drive = sample?.message ?? null;
  const run = useStream<Run>(streamOfType("BehaviourState"))?.message ?? null;
  const charging = useStream<BatteryState>(streamOfType("BatteryState"))?.message.charging ?? false;
  const part = from.split("/")[0]!;
  const fresh = useNews(drive && (drive.moving ? "" : `${drive.code} ${drive.reason}`));
  const failed = useNews(run && (failedBy(run) ? `${run.table} ${run.reason}` : ""), FAILED_MS);
  const line = said({ drive, fresh, run, failed, charging, part });
  const mine = holding.state.value.moving;
  const [asks, ask] = useState(false);
  const stands = !mine && (!drive?.moving || runs(run));
  const why = useChain(asks && stands ? part : "", `${drive?.estop} ${drive?.code} ${holding.state.value.code}`);
  const [place, away] = useAway();
  const telling = line.tone !== "calm" || (line.text !== "" && line.code !== "unwell") || drive?.moving;
  return (
    <div class="drive-why-place" ref={place}>
    <div class="drive-why" data-tone={line.tone} data-open={why !== null || undefined} data-away={(away && telling) || undefined}>
      <Icon name={line.icon} />
      {why ? (
        <p role="status" class="drive-because">
          <strong>{why.state === "ok" ? t("drive.why.nothing") : maybe(`code.${why.code}`) || t("drive.why")}</strong>
          {why.state !== "ok" && <span lang="en">{why.text}</span>}
        </p>
      ) : (
        <p role="status"><strong>{line.head}</strong>{line.text ? <span>{line.text}</span> : null}</p>
      )}
      {sample && <Stale sample={sample} />}
      <Button kind="quiet" icon="info" class={stands ? "" : "drive-unseen"} pressed={asks} onClick={() => ask(!asks)}>{t("drive.why")}</Button>
      {why ? <Cure of={why} part={part} /> : !mine && line.code ? <Mend code={line.code} about={part} /> : null}
    </div>
    </div>
  );
}

/** What holds a part, as the robot answers it; asked again whenever `now` is another; the last answer stays until then. Null until it has answered, and of no part. */
function useChain(part: string, now: string): Chain | null {
  const [answer, setAnswer] = useState<{ part: string; chain: Chain } | null>(null);
  useEffect(() => {
    if (!part) { setAnswer(null); return undefined; }
    let over = false;
    void fetchJson<Chain>(`/api/why/${part}`).then(({ ok, data }) => { if (!over && ok && data) setAnswer({ part, chain: data }); });
    return () => { over = true; };
  }, [part, now]);
  return part && answer?.part === part ? answer.chain : null;
}

/** Whether the element is scrolled away. */
function useAway(): [Ref<HTMLDivElement>, boolean] {
  const place = useRef<HTMLDivElement>(null);
  const [away, tell] = useState(false);
  useEffect(() => {
    const seen = new IntersectionObserver(([one]) => tell(!one!.isIntersecting), { rootMargin: "-56px 0px 0px" });
    seen.observe(place.current!);
    return () => seen.disconnect();
  }, []);
  return [place, away];
}

/** What mends what the robot tells: a button by its code, or the restart of the part that it names. */
function Cure({ of, part }: { of: Chain; part: string }) {
  const [, name] = /^\/restart\/([a-z0-9_]+)$/.exec(of.do) ?? [];
  if (name && knows("restart")) return <Button icon="restart" onClick={() => void consoleLine(of.do)}>{t("drive.why.restart", { name: plain(name) })}</Button>;
  return <Mend code={of.code} about={part} />;
}

function said(all: Told): Line {
  const { drive, fresh, run } = all;
  const hand = holding.state.value;
  const { holds, code, reason, holder } = hand;
  if (!may("operate")) return { tone: "calm", icon: "info", head: t("drive.stick.view", { role: t(`role.${role.value ?? "view"}`) }), text: other(drive, fresh) };
  if (drive?.estop) return { tone: "bad", icon: "stop", head: t("code.estop"), text: "" };
  const over = code !== "" && code !== "done" && !holds;
  switch (first(hand, drive, refused.value)) {
    case "limited":
      return { tone: "warn", icon: "warn", head: t("drive.limited", { by: plain(drive!.limited_by!) }), text: inWords(drive!) };
    case "mine":
      return steady() ?? slow(pace.value) ?? { tone: "good", icon: "drive", head: t("drive.you"), text: goalOf(drive) ?? "" };
    case "other":
      if (isPart(drive!.holder) && runs(run)) return { ...running(run!), code: "held_by_part" };
      return { tone: "calm", icon: "person", head: t("drive.holder", { holder: whose(drive!.holder ?? "?") }), text: goalOf(drive) ?? inWords(drive!), code: isPart(drive!.holder) ? "held_by_part" : "held" };
    case "ended": {
      const again = refused.value ? t("drive.again") : "";
      if (code === "stopped" && justStopped()) return again ? { tone: "warn", icon: "warn", head: again, text: "" } : rest({ ...all, fresh: false });
      if (code === "held") return { tone: "warn", icon: "person", head: heldBy(holder || drive?.holder), text: again, code };
      const own = maybe(`refused.${code}`) || maybe(`code.${code}`);
      const head = over ? own || told({ code: "", reason }) : again;
      const more = over ? [again, own && !maybe(`refused.${code}`) ? reason : ""] : [];
      return { tone: "warn", icon: "warn", head, text: more.filter(Boolean).map((one) => one.replace(/[.\s]*$/, ".")).join(" "), code };
    }
    default:
      return rest(all);
  }
}

/** That the robot soon ends a motion which nothing changes, as if nobody were there. */
function steady(): Line | null {
  const left = (robot.value?.base?.max_run_s ?? Infinity) - holding.unchangedMs() / 1000;
  return left < TOLD_S ? { tone: "warn", icon: "info", head: t("drive.steady", { left: Math.max(0, Math.ceil(left)) }), text: t("drive.steady.how") } : null;
}

/** That the link is slow, what that leaves of the speed, and why. */
function slow(told: Pace | null): Line | null {
  if (!told || told.speed >= 1) return null;
  return { tone: "warn", icon: "link", head: t("drive.slow", { speed: told.speed === 0.5 ? t("drive.slow.half") : percent(told.speed) }), text: t("drive.slow.age", { age: number(told.age_ms / 1000, 1) }) };
}

/** What it drives for; a number that a part of the robot gave it says nothing. */
const goalOf = (drive: DriveState | null): string | undefined => (drive?.goal?.startsWith("goal-") ? undefined : drive?.goal ?? undefined);

/** Whether a part of the robot drives, which nobody can ask. */
const isPart = (holder: string | null | undefined): boolean => robot.value?.capabilities.some((one) => one.name === holder) ?? false;
const whose = (holder: string): string => (isPart(holder) ? plain(holder) : named(holder));

const heldBy = (holder: string | null | undefined): string => (holder ? t("drive.holder", { holder: whose(holder) }) : t("code.held"));

function rest({ drive, fresh, run, failed, charging, part }: Told): Line {
  if (!drive) return { tone: "calm", icon: "info", head: t("age.never"), text: "" };
  if (runs(run)) return { ...running(run!), code: "held_by_part" };
  if (failed) return { tone: "warn", icon: "warn", head: t("drive.run.failed", { table: plain(run!.table) }), text: inWords(run!) };
  const ill = illness(part);
  if (ill) return { tone: "warn", icon: "warn", head: t("drive.unwell"), text: ill, code: "unwell" };
  const text = fresh && drive.code && drive.code !== "idle" && !byHand(drive) ? inWords(drive) : "";
  const others = unwell.value.map((one) => plain(one.name)).join(", ");
  return {
    tone: "calm", icon: others ? "warn" : charging ? "bolt" : "check", head: t(charging ? "drive.charges" : "drive.ready"),
    text: text || (others && t("drive.unwell.others", { names: others })), code: others ? "unwell" : "",
  };
}

const runs = (run: Run | null): boolean => run?.phase === "running" || run?.phase === "paused";
const running = (run: Run): Line => ({ tone: "good", icon: "behaviours", head: plain(run.table), text: plain(run.state) });

/** This page stopped it a moment ago, and says so already. */
const justStopped = (): boolean => notices.value.some((one) => one.text === t("stop.stopped"));

/** Its own holder ended it, or a page stopped it and shows that itself: nothing keeps the robot from moving. */
const byHand = (drive: DriveState): boolean =>
  drive.code === "stopped" && (drive.stopped_s !== drive.halted_s || (drive.stopped_by ?? "").startsWith("web:"));

const other = (drive: DriveState | null, fresh: boolean): string => (drive?.moving ? t("drive.holder", { holder: whose(drive.holder ?? "?") }) : fresh ? inWords(drive ?? {}) : "");
