// What each range sensor reads, with a plain sign where it reads nothing, nonsense, or has gone silent.
import { age, metres, plain } from "../../format";
import { clock, useStream, type Sample } from "../../live";
import type { DriveState, Ranges, Scan } from "../../messages";
import { Badge, Card, Icon } from "../../parts";
import { robot, streamOfType, streamsOfType } from "../../robot";
import { maybe, named, t } from "../../words";
import { missed, nearestOf, read, type Reading } from "./geometry";

const OLD_MS = 1500;
const NEAR_M = 0.5;

export function Distances() {
  const streams = streamsOfType("Ranges");
  const scans = streamsOfType("Scan");
  const drive = useStream<DriveState>(streamOfType("DriveState"));
  if (streams.length === 0 && scans.length === 0) return null;
  const sees = Object.entries(drive?.message.sees ?? {}).filter(([, far]) => far !== null);
  return (
    <Card title={t("drive.distances")} icon="radar">
      <ul class="drive-distances">
        {streams.map((key) => <OfRanges key={key} from={key} />)}
        {scans.map((key) => <OfScan key={key} from={key} />)}
        {sees.map(([name, far]) => <li key={name} title={t("drive.inway")}><span class="cut">{plain(name.replace(".", " "))}</span>{far! < NEAR_M && <Icon name="warn" />}<span class="num">{metres(far)}</span></li>)}
      </ul>
    </Card>
  );
}

function OfRanges({ from }: { from: string }) {
  const sample = useStream<Ranges>(from);
  void clock.value;
  if (!sample) return <li><span class="cut">{plain(from.split("/")[0]!)}</span><Badge tone="warn" icon="warn">{t("age.never")}</Badge></li>;
  return <>{read(robot.value?.ranges ?? [], sample.message).map((one) => <Line key={one.name} one={one} sample={sample} />)}</>;
}

function OfScan({ from }: { from: string }) {
  const sample = useStream<Scan>(from);
  void clock.value;
  const name = sample?.message.sensor ?? from.split("/")[0]!;
  if (!sample) return <li><span class="cut">{plain(name)}</span><Badge tone="warn" icon="warn">{t("age.never")}</Badge></li>;
  const distance = nearestOf(sample.message);
  return <Line one={{ name, distance, status: distance === null ? "over_range" : "ok" }} sample={sample} />;
}

function Line({ one, sample }: { one: Reading; sample: Sample<unknown> }) {
  const old = sample.stale(OLD_MS);
  const absent = one.status === "missing" && !missed(robot.value?.ranges ?? [], one.name);
  const calm = one.status === "over_range" || absent;
  const told = one.status === "ok" ? "" : absent ? t("range.absent") : maybe(`range.${one.status}`) || one.status;
  return (
    <li data-sensor={one.name} data-status={old ? "stale" : one.status}>
      <span class="cut">{named(one.name)}</span>
      {old ? <Badge tone="warn" icon="warn">{t("age.stale", { age: age(sample.ageMs()) })}</Badge> : told ? <Badge tone={calm ? "calm" : "warn"} icon={calm ? undefined : "warn"}>{told}</Badge> : null}
      {one.distance !== null && <span class="num">{metres(one.distance)}</span>}
    </li>
  );
}
