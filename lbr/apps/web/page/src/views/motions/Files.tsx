// Motions in files and in the robot's rows: saved, opened, taken from files, written to files, and what they were before.
import { useEffect, useRef, useState } from "preact/hooks";
import { told } from "../../access";
import { number, plain } from "../../format";
import { notice } from "../../notices";
import { Button, Choice, Dialog, Field } from "../../parts";
import { fetchJson, may } from "../../robot";
import { bytesOf, save as saveFile } from "../../saving";
import { t } from "../../words";
import type { BodyModel } from "../joints/model";
import type { Motion, MotionRow } from "./data";
import { change, dirty, open, rename, saved, sheet } from "./desk";
import { Figure } from "./Figure";
import { EMPTY, good, lasts, nameFrom, poseAt, sparse, type Sheet } from "./sheet";
import { move } from "./rows";
import { upload } from "./upload";

interface Form { suffix: string; summary: string; writes: boolean }
interface Taken { motions: Motion[]; notes: string[]; cut: number }
interface Version { revision: number; since: string; motion: Motion }
const LARGEST = 4 << 20;

const asSheet = (motion: Motion): Sheet => ({ name: nameFrom(motion.name), help: motion.help ?? "", frames: motion.frames.map(({ positions, duration_s }) => ({ positions, duration_s })) });

/** Keeps the sheet in the robot's rows; true once it is there. */
export async function save(replace: boolean): Promise<boolean> {
  const now = sheet.value;
  const sent = await upload(JSON.stringify({ name: now.name, help: now.help, frames: sparse(now.frames) }));
  if (sent.refused) return false;
  const answer = await fetchJson("api/motion", { method: "POST", body: { name: now.name, help: now.help, upload: sent.name, replace } });
  if (!answer.ok) return false;
  saved.value = now;
  notice(t("motions.saved", { motion: plain(now.name) }), "good");
  return true;
}

export function Files({ model, motions, bad }: { model: BodyModel; motions: MotionRow[]; bad: boolean }) {
  const input = useRef<HTMLInputElement>(null);
  const [forms, setForms] = useState<Form[]>([]);
  const [taken, take] = useState<(Taken & { file: string }) | null>(null);
  const [looks, look] = useState(false);
  const [leaving, leave] = useState(false);
  const [says, say] = useState<{ title: string; notes: string[] } | null>(null);
  const now = sheet.value;
  const own = motions.filter((one) => one.slot == null);
  const known = own.some((one) => one.name === now.name);
  const former = saved.value && saved.value.name !== now.name && own.some((one) => one.name === saved.value!.name && !one.builtin) ? saved.value.name : "";
  const fixed = motions.some((one) => one.name === now.name && (one.builtin || one.slot != null));
  useEffect(() => void fetchJson<{ forms: Form[] }>("api/motion/forms", { quiet: true }).then((answer) => setForms(answer.data?.forms ?? [])), []);

  const renameTo = async (name: string): Promise<void> => {
    if (!await move(name, now.name)) return;
    saved.value = { ...saved.value!, name: now.name };
    notice(t("motions.renamed", { motion: plain(now.name) }), "good");
  };
  const remove = async (): Promise<void> => {
    leave(false);
    if (!await move(now.name, null)) return;
    saved.value = null;
    notice(t("motions.deleted", { motion: plain(now.name) }), "good");
  };
  const openOne = async (name: string): Promise<void> => {
    const answer = await fetchJson<Motion>(`api/motion?motion=${encodeURIComponent(name)}`);
    if (answer.ok && answer.data) open(asSheet(answer.data), true);
  };
  const read = async (file: File | undefined): Promise<void> => {
    if (!file) return;
    const no = (why: string): void => notice(t("motions.no.motion", { file: file.name, why }), "warn");
    if (file.size > LARGEST) return no(t("motions.too.large", { mb: number(LARGEST >> 20) }));
    const sent = await upload(new Uint8Array(await file.arrayBuffer()));
    if (sent.refused) return;
    const answer = await fetchJson<Taken>("api/motion/read", { method: "POST", quiet: true, timeoutMs: 25_000, body: { upload: sent.name, file: file.name } });
    if (!answer.ok || !answer.data) return no(told(answer));
    const { motions: found, notes, cut } = answer.data;
    if (found.length === 1 && notes.length === 0 && cut === 0) open(asSheet(found[0]!), false);
    else take({ ...answer.data, file: file.name });
  };
  const write = async (form: string): Promise<void> => {
    const sent = await upload(JSON.stringify({ name: good(now.name) ? now.name : "motion", help: now.help, frames: sparse(now.frames) }));
    if (sent.refused) return;
    const answer = await fetchJson<{ content: string; notes: string[] }>("api/motion/write", { method: "POST", timeoutMs: 25_000, body: { upload: sent.name, form } });
    if (!answer.ok || !answer.data) return;
    saveFile(`${now.name || "motion"}${form}`, bytesOf(answer.data.content));
    if (answer.data.notes.length) say({ title: t("motions.no.place"), notes: answer.data.notes });
  };
  const writes = forms.filter((one) => one.writes);
  return (
    <>
      <Field label={t("motions.keep.name")} value={now.name} maxLength={40} placeholder="bow" autocomplete="off" onInput={(event) => rename(nameFrom(event.currentTarget.value))} />
      {fixed && <p class="motions-hint">{t("motions.fixed")}</p>}
      <div class="joints-actions">
        <Button icon="save" disabled={!may("admin") || fixed || !good(now.name) || now.frames.length === 0 || bad || (known && !dirty.value)} onClick={() => void save(known)}>{t(known ? "motions.replace" : "motions.save")}</Button>
        <Button icon="restart" disabled={!known} onClick={() => look(true)}>{t("motions.versions")}</Button>
        {former && !known && <Button disabled={!may("admin") || !good(now.name)} onClick={() => void renameTo(former)}>{t("motions.rename", { motion: plain(former) })}</Button>}
        <Button kind="danger" icon="trash" disabled={!may("admin") || !known || fixed} onClick={() => leave(true)}>{t("motions.delete")}</Button>
        <Button kind="quiet" disabled={now.frames.length === 0} onClick={() => open(EMPTY, false)}>{t("motions.new")}</Button>
      </div>
      {own.length > 0 && <Choice label={t("motions.open")} value="" options={[{ value: "", text: "…" }, ...own.map((one) => ({ value: one.name, text: plain(one.name) }))]} onChange={(name) => { if (name) void openOne(name); }} />}
      <div class="motions-files">
        <Button icon="ahead" class="motions-in" onClick={() => input.current?.click()}>{t("motions.import")}</Button>
        <span class="motions-label">{t("motions.export")}</span>
        {writes.map((one) => <Button key={one.suffix} icon="save" disabled={now.frames.length === 0} aria-label={t("motions.export.as", { form: one.suffix })} title={t("motions.export.as", { form: one.suffix })} onClick={() => void write(one.suffix)}>{one.suffix.slice(1).toUpperCase()}</Button>)}
      </div>
      <input ref={input} type="file" accept={forms.map((one) => one.suffix).join(",") || ".json"} hidden aria-label={t("motions.import")} onChange={(event) => { void read(event.currentTarget.files?.[0]); event.currentTarget.value = ""; }} />
      <Dialog title={taken ? t("motions.taken", { file: taken.file }) : ""} open={taken !== null} onClose={() => take(null)}>
        {taken && <Found taken={taken} model={model} onOpen={(motion) => { open(asSheet(motion), false); take(null); }} />}
      </Dialog>
      <Dialog title={t("motions.delete.sure", { motion: plain(now.name) })} open={leaving} onClose={() => leave(false)} actions={<><Button kind="quiet" onClick={() => leave(false)}>{t("dialog.cancel")}</Button><Button kind="danger" icon="trash" onClick={() => void remove()}>{t("motions.delete")}</Button></>}>
        <p>{t("motions.delete.text")}</p>
      </Dialog>
      <Dialog title={says?.title ?? ""} open={says !== null} onClose={() => say(null)}>
        <Notes notes={says?.notes ?? []} />
      </Dialog>
      <Dialog title={t("motions.versions.of", { motion: plain(now.name) })} open={looks} onClose={() => look(false)}>
        {looks && <Versions name={now.name} model={model} mayRestore={may("admin") && !fixed} onDone={() => look(false)} />}
      </Dialog>
    </>
  );
}

function Found({ taken, model, onOpen }: { taken: Taken; model: BodyModel; onOpen: (motion: Motion) => void }) {
  return (
    <>
      <ul class="motions-found">
        {taken.motions.map((motion) => (
          <li key={motion.name}>
            <Figure model={model} pose={poseAt(motion.frames, Math.floor(motion.frames.length / 2))} />
            <p><strong>{plain(motion.name)}</strong><span>{t("motions.frames", { count: motion.frames.length })} · {number(lasts(motion.frames), 1)} s</span></p>
            <Button onClick={() => onOpen(motion)}>{t("motions.open.it")}</Button>
          </li>
        ))}
      </ul>
      {taken.cut > 0 && <p class="motions-hint">{t("motions.cut", { count: taken.cut })}</p>}
      {taken.notes.length > 0 && <details class="motions-notes"><summary>{t("motions.notes", { count: taken.notes.length })}</summary><Notes notes={taken.notes} /></details>}
    </>
  );
}

const Notes = ({ notes }: { notes: string[] }) => <ul class="motions-note">{notes.slice(0, 200).map((one, at) => <li key={at}>{one}</li>)}</ul>;

function Versions({ name, model, mayRestore, onDone }: { name: string; model: BodyModel; mayRestore: boolean; onDone: () => void }) {
  const [all, show] = useState<Version[] | null>(null);
  const [why, setWhy] = useState("");
  useEffect(() => void fetchJson<{ versions: Version[] }>(`api/motion/versions?motion=${encodeURIComponent(name)}`, { quiet: true, timeoutMs: 25_000 }).then((answer) => {
    if (answer.ok && answer.data) show(answer.data.versions);
    else setWhy(told(answer));
  }), [name]);
  if (why) return <p>{why}</p>;
  if (!all) return <div class="loading" role="status"><div class="pulse" />{t("shell.loading")}</div>;
  const restore = async (one: Version): Promise<void> => {
    change(asSheet(one.motion));
    if (await save(true)) onDone();
  };
  return (
    <ul class="motions-found">
      {all.map((one, at) => (
        <li key={one.revision}>
          <Figure model={model} pose={poseAt(one.motion.frames, Math.floor(one.motion.frames.length / 2))} />
          <p>
            <strong>{at === 0 ? t("motions.version.now") : one.since ? when(one.since) : t("motions.version.first")}</strong>
            <span>{at === 0 && one.since ? `${when(one.since)} · ` : ""}{t("motions.frames", { count: one.motion.frames.length })} · {number(lasts(one.motion.frames), 1)} s</span>
          </p>
          <span class="motions-acts">
            <Button kind="quiet" onClick={() => { change(asSheet(one.motion)); onDone(); }}>{t("motions.look")}</Button>
            {at > 0 && <Button disabled={!mayRestore} onClick={() => void restore(one)}>{t("motions.restore")}</Button>}
          </span>
        </li>
      ))}
    </ul>
  );
}

const when = (iso: string): string => new Date(iso).toLocaleString(document.documentElement.lang || "en", { dateStyle: "medium", timeStyle: "short", hourCycle: "h23" });
