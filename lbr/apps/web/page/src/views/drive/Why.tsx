// One line that always says what the base does, who holds it, or why it does not move.
import { useState } from "preact/hooks";

import { told } from "../../access";
import { plain } from "../../format";
import { askFor } from "../../handover";
import { holding } from "../../holding";
import { clock, useStream } from "../../live";
import type { DriveState } from "../../messages";
import { Button, Icon, Stale, type IconName } from "../../parts";
import { fetchJson, may, role } from "../../robot";
import { maybe, t } from "../../words";
import { refused, takeOver } from "./pilot";

/** The robot's own answer: the first link that holds it, and what to type. */
interface Chain { state: string; text: string; code: string; do: string }

interface Line { tone: "calm" | "good" | "warn" | "bad"; icon: IconName; head: string; text: string; held?: boolean }

export function Why({ from }: { from: string }) {
  void clock.value;
  const sample = useStream<DriveState>(from);
  const line = said(sample?.message ?? null);
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
          {why.do && <code lang="en">{why.do}</code>}
        </p>
      ) : (
        <p role="status"><strong>{line.head}</strong>{line.text && <span>{line.text}</span>}</p>
      )}
      {sample && <Stale sample={sample} />}
      <Button kind="quiet" icon="info" class={stands ? "" : "drive-unseen"} pressed={why !== null} onClick={() => (why ? setWhy(null) : void look())}>{t("drive.why")}</Button>
      {line.held && may("operate") && !mine && <Button kind="quiet" onClick={() => void askFor(part)}>{t("hand.ask")}</Button>}
      {line.held && may("operate") && !mine && <Button pressed={takeOver.value} icon="person" onClick={() => { takeOver.value = !takeOver.value; holding.forget(); }}>{t("drive.takeover")}</Button>}
    </div>
  );
}

function said(drive: DriveState | null): Line {
  const { moving, holds, code, reason, holder } = holding.state.value;
  if (!may("operate")) return { tone: "calm", icon: "info", head: t("drive.stick.view", { role: t(`role.${role.value ?? "view"}`) }), text: other(drive) };
  if (drive?.estop) return { tone: "bad", icon: "stop", head: t("code.estop"), text: drive.reason };
  if (code && code !== "done" && !holds) {
    const text = code === "held" ? t("drive.holder", { holder: holder || drive?.holder || "?" }) : reason;
    const head = maybe(`code.${code}`);
    const more = [head ? text : "", refused.value ? t("drive.again") : ""].filter(Boolean).map((one) => one.replace(/[.\s]*$/, "."));
    return { tone: "warn", icon: "warn", head: head || told({ code: "", reason }), text: more.join(" "), held: code === "held" };
  }
  if (refused.value) return { tone: "warn", icon: "warn", head: t("drive.again"), text: "" };
  if (!drive) return { tone: "calm", icon: "info", head: t("age.never"), text: "" };
  if (drive.limited_by) return { tone: "warn", icon: "warn", head: t("drive.limited", { by: plain(drive.limited_by) }), text: drive.reason };
  if (moving && holds) return { tone: "good", icon: "drive", head: t("drive.you"), text: drive.goal ?? "" };
  if (drive.moving) return { tone: "calm", icon: "person", head: t("drive.holder", { holder: drive.holder ?? "?" }), text: drive.goal ?? drive.reason, held: true };
  return { tone: "calm", icon: "check", head: t("drive.ready"), text: drive.code && drive.code !== "idle" && !byHand(drive) ? drive.reason : "" };
}

/** A hand that came to rest on a page ended it, or a stop on a page, which tells of itself: nothing keeps the robot from moving. */
const byHand = (drive: DriveState): boolean => drive.code === "stopped" && (drive.stopped_by ?? "").startsWith("web:");

const other = (drive: DriveState | null): string => (drive?.moving ? t("drive.holder", { holder: drive.holder ?? "?" }) : drive?.reason ?? "");
