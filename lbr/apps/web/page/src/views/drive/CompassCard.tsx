// The compass: whether it is calibrated, and the turn on the spot that calibrates it.
import { useState } from "preact/hooks";
import { inWords } from "../../access";
import { clock, useStream } from "../../live";
import type { AttitudeState, CalibrationProgress } from "../../messages";
import { Badge, Button, Card, Dialog } from "../../parts";
import { capabilities, command, may } from "../../robot";
import { percent } from "../../format";
import { t } from "../../words";

/** As many as the console's examples ask for: two turns, some half a minute. */
const SAMPLES = 300;
/** Progress is told several times a second; what is older belongs to a calibration that is over. */
const OLD_MS = 3000;
/** The answer comes when the base turns. */
const BEGINS_MS = 15_000;

/** Shown where the robot has an attitude that can be calibrated; what turns it holds the drive by itself, and every stop ends it. */
export function CompassCard() {
  const owner = capabilities("attitude").find((one) => one.commands["calibrate"])?.name ?? "";
  return owner ? <Shown owner={owner} /> : null;
}

function Shown({ owner }: { owner: string }) {
  void clock.value;
  const [asks, ask] = useState(false);
  const state = useStream<AttitudeState>(`${owner}/state`)?.message;
  const heard = useStream<CalibrationProgress>(`${owner}/calibration`);
  const told = heard?.message;
  const runs = told !== undefined && (told.phase === "collecting" || told.phase === "fitting") && !heard!.stale(OLD_MS);
  const part = told && told.wanted > 0 ? Math.min(told.collected / told.wanted, told.coverage) : 0;
  const begin = (): void => {
    ask(false);
    void command(owner, "calibrate", { samples: SAMPLES, source: "-" }, { timeoutMs: BEGINS_MS });
  };
  const over = told && !runs && told.wanted > 0 && (told.phase === "done" || told.phase === "refused") ? told : null;
  return (
    <Card title={t("compass.title")} icon="compass" actions={state && <Badge tone={state.calibrated ? "good" : "warn"} icon={state.calibrated ? "check" : "warn"}>{t(state.calibrated ? "compass.good" : "compass.raw")}</Badge>}>
      {runs ? (
        <>
          <div class="drive-progress" role="progressbar" aria-label={t("compass.runs")} aria-valuemin={0} aria-valuemax={100} aria-valuenow={Math.round(100 * part)}><span style={{ width: `${100 * part}%` }} /></div>
          <p class="muted" role="status">{t(told.phase === "fitting" ? "compass.fits" : "compass.turns", { part: percent(part) })}</p>
        </>
      ) : (
        <>
          {over ? <p role="status" class="drive-calibrated" data-bad={over.phase === "refused" || undefined}><strong>{t(over.phase === "done" ? "compass.done" : "compass.failed")}</strong> <span class="muted">{over.text}</span></p>
            : state?.heading_reason ? <p class="muted">{inWords({ code: state.code, reason: state.heading_reason })}</p> : null}
          <Button icon="turn" disabled={!may("operate")} onClick={() => ask(true)}>{t("compass.begin")}</Button>
        </>
      )}
      <Dialog
        title={t("compass.ask")} open={asks} onClose={() => ask(false)}
        actions={<>
          <Button kind="quiet" onClick={() => ask(false)}>{t("dialog.cancel")}</Button>
          <Button kind="primary" icon="turn" onClick={begin}>{t("compass.begin")}</Button>
        </>}
      >
        <p>{t("compass.text")}</p>
      </Dialog>
    </Card>
  );
}
