// System: which parts there are and how they are, what happened, any number as a chart, the rows, who may come in.
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { remember, remembered } from "../../kept";
import { Segments, type IconName } from "../../parts";
import { capabilities, may } from "../../robot";
import { learn, t } from "../../words";
import { system as systemWords } from "../../words/system";
import { Box } from "./Box";
import { Cameras } from "./Cameras";
import { Chart } from "./Chart";
import { Devices } from "./Devices";
import { Events } from "./Events";
import { History } from "./History";
import { Parts } from "./Parts";
import { Settings } from "./Settings";
import { Tokens } from "./Tokens";
import "./System.css";

learn(systemWords);

type Page = "parts" | "history" | "events" | "chart" | "cameras" | "settings" | "devices" | "tokens";
const page = signal<Page>(remembered<Page>("system", "parts"));
const VIEWS: Record<Page, () => preact.JSX.Element> = { parts: Parts, history: History, events: Events, chart: Chart, cameras: Cameras, settings: Settings, devices: Devices, tokens: Tokens };

export default function System() {
  const pages: { value: Page; icon: IconName; there: boolean }[] = [
    { value: "parts", icon: "system", there: true },
    { value: "history", icon: "past", there: capabilities("box").length > 0 },
    { value: "events", icon: "events", there: true },
    { value: "chart", icon: "chart", there: true },
    { value: "cameras", icon: "camera", there: capabilities("camera").length > 0 },
    { value: "settings", icon: "settings", there: may("operate") },
    { value: "devices", icon: "plus", there: may("admin") },
    { value: "tokens", icon: "lock", there: may("admin") },
  ];
  useEffect(() => {
    const turn = (): void => { const asked = location.hash.split("/")[1]; if (asked && asked in VIEWS) page.value = asked as Page; };
    turn();
    window.addEventListener("hashchange", turn);
    return () => window.removeEventListener("hashchange", turn);
  }, []);
  const there = pages.filter((one) => one.there);
  const now = there.some((one) => one.value === page.value) ? page.value : "parts";
  const Shown = VIEWS[now];
  return (
    <div class="system">
      <div class="system-head">
        <h2>{t("view.system")}</h2>
        <Segments<Page>
          label={t("view.system")} value={now} onChange={(value) => { page.value = value; remember("system", value); history.replaceState(null, "", `#system/${value}`); }}
          options={there.map((one) => ({ value: one.value, text: t(`system.${one.value}`), icon: one.icon }))}
        />
        <Box />
      </div>
      <Shown />
    </div>
  );
}
