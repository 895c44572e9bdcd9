// The songs that the robot has: heard, or danced to.
import { inWords } from "../../access";
import { plain } from "../../format";
import { useStream } from "../../live";
import type { DanceState, SpeechState } from "../../messages";
import { Button, Card } from "../../parts";
import { capabilities, command, may, robot, streamOfType } from "../../robot";
import { t } from "../../words";

const MOST = 40;

export function Songs() {
  const dance = capabilities("dance")[0]?.name;
  const speech = capabilities("speech").find((one) => one.commands.play)?.name;
  const state = useStream<DanceState>(streamOfType("DanceState"))?.message;
  const heard = useStream<SpeechState>(streamOfType("SpeechState"))?.message;
  if (!dance) return null;
  const field = robot.value?.words.flatMap((one) => one.fields ?? []).find((one) => one.name === "song");
  const songs = (field?.choices ?? []).slice(0, MOST);
  const dances = state?.phase === "dancing";
  const plays = heard?.playing ?? "";
  const part = dances && state.beats > 0 ? Math.round((100 * state.beat) / state.beats) : 0;
  const end = (): void => {
    if (dances) void command(dance, "stop", { reason: "ended on the page" });
    else if (speech) void command(speech, "hush", { song: plays });
  };
  return (
    <Card title={t("drive.songs")} icon="song" actions={(dances || plays) && <Button kind="quiet" icon="hush" disabled={!may("operate")} onClick={end}>{t("drive.songs.end")}</Button>}>
      {dances && (
        <div class="drive-dancing" role="status">
          <strong>{t("drive.dancing", { song: plain(state.song) })}</strong>
          <span class="drive-gauge-bar" aria-hidden="true"><span style={{ width: `${part}%` }} /></span>
        </div>
      )}
      {!dances && state?.phase === "ended" && state.reason && state.code !== "done" && <p class="muted drive-ended">{inWords(state)}</p>}
      {songs.length === 0 && <p class="muted">{t("drive.songs.none")}</p>}
      <ul class="drive-songs">
        {songs.map((song) => (
          <li key={song}>
            <span class="cut">{plain(song)}</span>
            {speech && <Button kind="quiet" icon="play" pressed={plays === song} disabled={!may("operate")} label={t("drive.songs.play", { song: plain(song) })} onClick={() => void command(speech, "play", { song })} />}
            <Button icon="dance" disabled={!may("operate") || dances} label={t("drive.songs.dance", { song: plain(song) })} onClick={() => void command(dance, "play", { song })} />
          </li>
        ))}
      </ul>
    </Card>
  );
}
