// What happened since the page was opened, the newest first.
import { useState } from "preact/hooks";
import { plain, timeOfDay } from "../../format";
import { events } from "../../live";
import { Empty, Icon, Segments } from "../../parts";
import { t } from "../../words";

export function Events() {
  const [level, show] = useState<"all" | "warnings">("all");
  const shown = events.value.filter((one) => level === "all" || (one.level ?? "info") !== "info");
  return (
    <div class="stack">
      <div class="system-tools">
        <Segments label={t("system.levels")} value={level} onChange={show} options={[{ value: "all", text: t("system.all") }, { value: "warnings", text: t("system.warnings") }]} />
      </div>
      {shown.length === 0 ? <Empty icon="events" title={t("system.none")} /> : (
        <ol class="system-events">
          {shown.map((one) => (
            <li key={one.id} data-level={one.level ?? "info"}>
              <Icon name={(one.level ?? "info") === "info" ? "info" : "warn"} />
              <div>
                <p><strong>{plain(one.subject)}</strong> {one.text}</p>
                <p class="system-event-foot muted"><time class="num">{timeOfDay(one.wall_ns ?? 0)}</time> · {one.kind}{one.code ? ` · ${one.code}` : ""}</p>
              </div>
            </li>
          ))}
        </ol>
      )}
    </div>
  );
}
