// One line that always says what the base does, who holds it, or why it does not move.
import { useState } from "preact/hooks";

import { told } from "../../access";
import { plain } from "../../format";
import { askFor } from "../../handover";
import { holding } from "../../holding";
import { clock, useStream } from "../../live";
import type { DriveState } from "../../messages";
import { useNews } from "../../news";
import { Button, Icon, Stale, type IconName } from "../../parts";
import { fetchJson, may, role } from "../../robot";
import { maybe, t } from "../../words";
import { first } from "./line";
import { refused, takeOver } from "./pilot";

/** The robot's own answer: the first link that holds it, and what to type. */
interface Chain { state: string; text: string; code: string; do: string }

interface Line { tone: "calm" | "good" | "warn" | "bad"; icon: IconName; head: string; text: string; held?: boolean }

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

function said(drive: DriveState | null, fresh: boolean): Line {
  const hand = holding.state.value;
  const { holds, code, reason, holder } = hand;
  if (!may("operate")) return { tone: "calm", icon: "info", head: t("drive.stick.view", { role: t(`role.${role.value ?? "view"}`) }), text: other(drive, fresh) };
  if (drive?.estop) return { tone: "bad", icon: "stop", head: t("code.estop"), text: drive.reason };
  const over = code !== "" && code !== "done" && !holds;
  switch (first(hand, drive, refused.value)) {
    case "limited":
      return { tone: "warn", icon: "warn", head: t("drive.limited", { by: plain(drive!.limited_by!) }), text: drive!.reason };
    case "mine":
      return { tone: "good", icon: "drive", head: t("drive.you"), text: drive?.goal ?? "" };
    case "other":
      return { tone: "calm", icon: "person", head: t("drive.holder", { holder: drive!.holder ?? "?" }), text: drive!.goal ?? drive!.reason, held: true };
    case "ended": {
      const text = code === "held" ? t("drive.holder", { holder: holder || drive?.holder || "?" }) : reason;
      const head = over ? maybe(`code.${code}`) || told({ code: "", reason }) : t("drive.again");
      const more = over ? [maybe(`code.${code}`) ? text : "", refused.value ? t("drive.again") : ""] : [];
      return { tone: "warn", icon: "warn", head, text: more.filter(Boolean).map((one) => one.replace(/[.\s]*$/, ".")).join(" "), held: code === "held" };
    }
    default:
      if (!drive) return { tone: "calm", icon: "info", head: t("age.never"), text: "" };
      return { tone: "calm", icon: "check", head: t("drive.ready"), text: fresh && drive.code && drive.code !== "idle" && !byHand(drive) ? drive.reason : "" };
  }
}

/** A hand that came to rest on a page ended it, or a stop on a page, which tells of itself: nothing keeps the robot from moving. */
const byHand = (drive: DriveState): boolean => drive.code === "stopped" && (drive.stopped_by ?? "").startsWith("web:");

const other = (drive: DriveState | null, fresh: boolean): string => (drive?.moving ? t("drive.holder", { holder: drive.holder ?? "?" }) : fresh ? drive?.reason ?? "" : "");
