// One line that always says what the base does, who holds it, or why it does not move.
import { told } from "../../access";
import { plain } from "../../format";
import { holding } from "../../holding";
import { clock, useStream } from "../../live";
import type { DriveState } from "../../messages";
import { Button, Icon, Stale, type IconName } from "../../parts";
import { may, role } from "../../robot";
import { maybe, t } from "../../words";
import { refused, takeOver } from "./pilot";

interface Line { tone: "calm" | "good" | "warn" | "bad"; icon: IconName; head: string; text: string; held?: boolean }

export function Why({ from }: { from: string }) {
  void clock.value;
  const sample = useStream<DriveState>(from);
  const line = said(sample?.message ?? null);
  const mine = holding.state.value.moving;
  return (
    <div class="drive-why" data-tone={line.tone}>
      <Icon name={line.icon} />
      <p role="status"><strong>{line.head}</strong>{line.text && <span>{line.text}</span>}</p>
      {sample && <Stale sample={sample} />}
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
    return { tone: "warn", icon: "warn", head: maybe(`code.${code}`) || told({ code: "", reason }), text: refused.value ? `${text.replace(/[.\s]*$/, ". ")}${t("drive.again")}.`.replace(/^\. /, "") : text, held: code === "held" };
  }
  if (refused.value) return { tone: "warn", icon: "warn", head: t("drive.again"), text: "" };
  if (!drive) return { tone: "calm", icon: "info", head: t("age.never"), text: "" };
  if (drive.limited_by) return { tone: "warn", icon: "warn", head: t("drive.limited", { by: plain(drive.limited_by) }), text: drive.reason };
  if (moving && holds) return { tone: "good", icon: "drive", head: t("drive.you"), text: drive.goal ?? "" };
  if (drive.moving) return { tone: "calm", icon: "person", head: t("drive.holder", { holder: drive.holder ?? "?" }), text: drive.goal ?? drive.reason, held: true };
  return { tone: "calm", icon: "check", head: t("drive.ready"), text: drive.code && drive.code !== "idle" ? drive.reason : "" };
}

const other = (drive: DriveState | null): string => (drive?.moving ? t("drive.holder", { holder: drive.holder ?? "?" }) : drive?.reason ?? "");
