// System: which parts there are and how they are, what happened, and any number as a chart.
import { signal } from "@preact/signals";
import { remember, remembered } from "../../kept";
import { Segments } from "../../parts";
import { t } from "../../words";
import { Chart } from "./Chart";
import { Events } from "./Events";
import { Parts } from "./Parts";
import "./System.css";

type Page = "parts" | "events" | "chart";
const page = signal<Page>(remembered<Page>("system", "parts"));

export default function System() {
  return (
    <div class="system">
      <div class="system-head">
        <h2>{t("view.system")}</h2>
        <Segments<Page>
          label={t("view.system")} value={page.value} onChange={(value) => { page.value = value; remember("system", value); }}
          options={[{ value: "parts", text: t("system.parts"), icon: "system" }, { value: "events", text: t("system.events"), icon: "events" }, { value: "chart", text: t("system.chart"), icon: "chart" }]}
        />
      </div>
      {page.value === "parts" ? <Parts /> : page.value === "events" ? <Events /> : <Chart />}
    </div>
  );
}
