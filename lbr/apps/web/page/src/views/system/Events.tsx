// What happened, the newest first: what was written down, and what is heard since; of one part, or only what matters.
import { useEffect, useState } from "preact/hooks";
import { plain, timeOfDay } from "../../format";
import { events, link } from "../../live";
import type { Event } from "../../messages";
import { Choice, Empty, Icon, Segments } from "../../parts";
import { fetchJson, robot } from "../../robot";
import { t } from "../../words";
import { dayOf, matches, merged, type Level, type Listed } from "./listing";

const MOST = 300;

/** The events of a part, from a level on, the newest first; and whatever was ever the subject of one. */
export function useEvents(subject: string, level: Level, most: number): { shown: Listed[]; subjects: string[] } {
  const [written, tell] = useState<Event[]>([]);
  const [subjects, know] = useState<string[]>([]);
  const there = link.value === "open";
  useEffect(() => {
    if (!there) return;
    let over = false;
    const wanted = new URLSearchParams({ level, ...(subject ? { subject } : {}) });
    void fetchJson<{ data: { events: Event[] } | null }>(`api/events?${wanted}`, { quiet: true, timeoutMs: 12_000 }).then((answer) => {
      if (over || !answer.ok) return;
      const found = answer.data?.data?.events ?? [];
      tell(found);
      know((before) => [...new Set([...before, ...found.map((one) => one.subject)])]);
    });
    return () => { over = true; };
  }, [subject, level, there]);
  return { shown: merged(events.value.filter((one) => matches(one, subject, level)), written.filter((one) => matches(one, subject, level)), most), subjects };
}

export function Events() {
  const [level, atLeast] = useState<Level>("info");
  const [subject, of] = useState("");
  const { shown, subjects } = useEvents(subject, level, MOST);
  const parts = [...new Set([...(robot.value?.capabilities ?? []).map((one) => one.name), "executive", ...events.value.map((one) => one.subject), ...subjects])].filter(Boolean).sort();
  return (
    <div class="stack">
      <div class="system-tools">
        <Choice label={t("system.part")} value={subject} options={[{ value: "", text: t("system.parts.all") }, ...parts.map((one) => ({ value: one, text: plain(one) }))]} onChange={of} />
        <Segments<Level> label={t("system.levels")} value={level} onChange={atLeast} options={[{ value: "info", text: t("system.all") }, { value: "warning", text: t("system.warnings") }, { value: "error", text: t("system.errors") }]} />
      </div>
      {shown.length === 0 ? <Empty icon="events" title={t("system.none")} /> : <EventList shown={shown} />}
    </div>
  );
}

export function EventList({ shown }: { shown: Listed[] }) {
  const today = new Date();
  const language = document.documentElement.lang || "en";
  return (
    <ol class="system-events">
      {shown.map(({ key, event: one }) => (
        <li key={key} data-level={one.level ?? "info"}>
          <Icon name={(one.level ?? "info") === "info" ? "info" : "warn"} />
          <div>
            <p><strong>{plain(one.subject)}</strong> {one.text}</p>
            <p class="system-event-foot muted"><time class="num">{[dayOf(one.wall_ns ?? 0, today, language), timeOfDay(one.wall_ns ?? 0)].filter(Boolean).join(" ")}</time> · {plain(one.kind)}{one.code ? ` · ${one.code}` : ""}</p>
          </div>
        </li>
      ))}
    </ol>
  );
}
