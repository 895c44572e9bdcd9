// One line that always says what the base does, who holds it, or why it does not move.
import { useState } from "preact/hooks";

import { told } from "../../access";
import { Mend } from "../../mend";
import { notices } from "../../notices";
import { number, percent, plain } from "../../format";
import { named } from "../../handover";
import { holding } from "../../holding";
import { clock, pace, useStream, type Pace } from "../../live";
import type { DriveState } from "../../messages";
import { useNews } from "../../news";
import { Button, Icon, Stale, type IconName } from "../../parts";
import { consoleLine, fetchJson, knows, may, robot, role } from "../../robot";
import { maybe, t } from "../../words";
import { first } from "./line";
import { refused } from "./pilot";

/** The robot's own answer: the first link that holds it, and what to type. */
interface Chain { state: string; text: string; code: string; do: string }

interface Line { tone: "calm" | "good" | "warn" | "bad"; icon: IconName; head: string; text: string; code?: string }

export function Why({ from }: { from: string }) {
  void clock.value;
  const sample = useStream<DriveState>(from);
  const drive = sample?.message ?? null;
  const fresh = useNews(drive && !drive.moving ? `${drive.code} ${drive.reason}` : "");
  const line = said(drive, fresh);
  const mine = holding.state.value.moving;
  const [why, setWhy] = useState<Chain | null>(null);
  const part = from.split("/")[0]!;
  const look = async () => {
    const answer = await fetchJson<Chain>(`/api/why/${part}`);
    setWhy(answer.ok ? answer.data : null);
  };
  const stands = !mine && !sample?.message.moving;
  return (
    <div class="drive-why" data-tone={line.tone} data-open={why !== null || undefined}>
      <Icon name={line.icon} />
      {stands && why ? (
        <p role="status" class="drive-because">
          <strong>{why.state === "ok" ? t("drive.why.nothing") : maybe(`code.${why.code}`) || t("drive.why")}</strong>
          {why.state !== "ok" && <span lang="en">{why.text}</span>}
        </p>
      ) : (
        <p role="status"><strong>{line.head}</strong>{line.text && <span>{line.text}</span>}</p>
      )}
      {sample && <Stale sample={sample} />}
      <Button kind="quiet" icon="info" class={stands ? "" : "drive-unseen"} pressed={why !== null} onClick={() => (why ? setWhy(null) : void look())}>{t("drive.why")}</Button>
      {stands && why ? <Cure of={why} part={part} /> : !mine && line.code && <Mend code={line.code} about={part} />}
    </div>
  );
}

/** What mends what the robot tells: a button by its code, or the restart of the part that it names. */
function Cure({ of, part }: { of: Chain; part: string }) {
  const [, name] = /^\/restart\/([a-z0-9_]+)$/.exec(of.do) ?? [];
  if (name && knows("restart")) return <Button icon="restart" onClick={() => void consoleLine(of.do)}>{t("drive.why.restart", { name: plain(name) })}</Button>;
  return <Mend code={of.code} about={part} />;
}

function said(drive: DriveState | null, fresh: boolean): Line {
  const hand = holding.state.value;
  const { holds, code, reason, holder } = hand;
  if (!may("operate")) return { tone: "calm", icon: "info", head: t("drive.stick.view", { role: t(`role.${role.value ?? "view"}`) }), text: other(drive, fresh) };
  if (drive?.estop) return { tone: "bad", icon: "stop", head: t("code.estop"), text: "" };
  const over = code !== "" && code !== "done" && !holds;
  switch (first(hand, drive, refused.value)) {
    case "limited":
      return { tone: "warn", icon: "warn", head: t("drive.limited", { by: plain(drive!.limited_by!) }), text: drive!.reason };
    case "mine":
      return slow(pace.value) ?? { tone: "good", icon: "drive", head: t("drive.you"), text: goalOf(drive) ?? "" };
    case "other":
      return { tone: "calm", icon: "person", head: t("drive.holder", { holder: whose(drive!.holder ?? "?") }), text: goalOf(drive) ?? drive!.reason, code: isPart(drive!.holder) ? "held_by_part" : "held" };
    case "ended": {
      const again = refused.value ? t("drive.again") : "";
      if (code === "stopped" && justStopped()) return again ? { tone: "warn", icon: "warn", head: again, text: "" } : rest(drive, false);
      if (code === "held") return { tone: "warn", icon: "person", head: heldBy(holder || drive?.holder), text: again, code };
      const own = maybe(`refused.${code}`) || maybe(`code.${code}`);
      const head = over ? own || told({ code: "", reason }) : again;
      const more = over ? [again, own && !maybe(`refused.${code}`) ? reason : ""] : [];
      return { tone: "warn", icon: "warn", head, text: more.filter(Boolean).map((one) => one.replace(/[.\s]*$/, ".")).join(" "), code };
    }
    default:
      return rest(drive, fresh);
  }
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

function rest(drive: DriveState | null, fresh: boolean): Line {
  if (!drive) return { tone: "calm", icon: "info", head: t("age.never"), text: "" };
  return { tone: "calm", icon: "check", head: t("drive.ready"), text: fresh && drive.code && drive.code !== "idle" && !byHand(drive) ? drive.reason : "" };
}

/** This page stopped it a moment ago, and says so already. */
const justStopped = (): boolean => notices.value.some((one) => one.text === t("stop.stopped"));

/** A hand that came to rest on a page ended it, or a stop on a page, which tells of itself: nothing keeps the robot from moving. */
const byHand = (drive: DriveState): boolean => drive.code === "stopped" && (drive.stopped_by ?? "").startsWith("web:");

const other = (drive: DriveState | null, fresh: boolean): string => (drive?.moving ? t("drive.holder", { holder: drive.holder ?? "?" }) : fresh ? drive?.reason ?? "" : "");
