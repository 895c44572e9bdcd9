// What the robot says: a text, or one of its phrases.
import { useState } from "preact/hooks";
import { useStream } from "../../live";
import type { SpeechState } from "../../messages";
import { Button, Card } from "../../parts";
import { plain } from "../../format";
import { capabilities, command, may, robot, streamOfType } from "../../robot";
import { language, t } from "../../words";

/** So many are offered at first. */
const FEW = 6;

/** Whether a phrase is a sentence; the others are parts of one. */
const whole = ({ text }: { text?: string | null }): boolean => /[.!?]$/.test(text ?? "");

export function Speak() {
  const [text, write] = useState("");
  const [every, offer] = useState(false);
  const speech = capabilities("speech")[0]?.name;
  const state = useStream<SpeechState>(streamOfType("SpeechState"));
  if (!speech) return null;
  const say = async (event: Event): Promise<void> => {
    event.preventDefault();
    if (!text.trim()) return;
    const answer = await command(speech, "say", { text: text.trim() });
    if (answer.ok) write("");
  };
  const all = robot.value?.phrases ?? [];
  const own = all.filter((one) => !one.language || one.language === language.value);
  const phrases = [...new Map((own.length > 0 ? own : all).map((one) => [one.name, one])).values()].sort((one, other) => Number(whole(other)) - Number(whole(one)));
  const speaking = state?.message.speaking ?? false;
  return (
    <Card title={t("drive.speak")} icon="speak" actions={<Button kind="quiet" icon="hush" label={t("drive.hush")} disabled={!may("operate")} onClick={() => void command(speech, "hush", {})} />}>
      <form class="drive-say" onSubmit={(event) => void say(event)}>
        <input class="input" aria-label={t("drive.say")} placeholder={t("drive.say")} maxLength={300} enterKeyHint="send" value={text} disabled={!may("operate")} onInput={(event) => write(event.currentTarget.value)} />
        <Button type="submit" kind="primary" icon="speak" label={t("drive.say.go")} disabled={!may("operate") || !text.trim()} />
      </form>
      {speaking && <p class="drive-speaking" role="status">“{state!.message.text}”</p>}
      {phrases.length > 0 && (
        <div class="drive-phrases">
          {(every ? phrases : phrases.slice(0, FEW)).map((one) => <button key={one.name} type="button" class="drive-phrase" title={plain(one.name)} disabled={!may("operate")} onClick={() => void command(speech, "say", { phrase: one.name, language: one.language ?? "" })}>{one.text ? `“${one.text}”` : plain(one.name)}</button>)}
          {phrases.length > FEW && <Button kind="quiet" onClick={() => offer(!every)}>{t(every ? "drive.phrases.few" : "drive.phrases.all", { count: phrases.length })}</Button>}
        </div>
      )}
    </Card>
  );
}
