// The robot's picture, by whichever way there is: that of a call, or MJPEG.
import { useEffect, useRef, useState } from "preact/hooks";
import { call, theirs } from "./call";
import { clock, onLink, type Sample } from "./live";
import type { CameraState } from "./messages";
import { Icon } from "./parts";
import { t } from "./words";

const AGAIN_MS = 2000;
export const PREFIX = "camera_";

/** Whether the picture comes by a call now. */
export const byCall = (): boolean => call.value.stage === "talking" && theirs.value !== null && call.value.picture === "";

export function Film({ stream, label, muted, mirrored = false, class: more = "", onBlocked }: { stream: MediaStream; label: string; muted: boolean; mirrored?: boolean; class?: string; onBlocked?: (blocked: boolean) => void }) {
  const film = useRef<HTMLVideoElement>(null);
  const [there, come] = useState(false);
  useEffect(() => {
    const video = film.current!;
    video.srcObject = stream;
    video.muted = muted;
    video.play().then(() => onBlocked?.(false), (err: unknown) => {
      if (!(err instanceof DOMException && err.name === "NotAllowedError")) return; // begun again meanwhile
      onBlocked?.(true);
      video.muted = true;
      void video.play().catch(() => undefined);
    });
    return () => { video.srcObject = null; };
  }, [stream, muted]);
  return <video ref={film} class={more} aria-label={label} autoplay playsInline muted={muted} data-there={there || undefined} data-mirrored={mirrored || undefined} onPlaying={() => come(true)} />;
}

/** How old the newest picture of a camera is: since its count went on. A camera that is stuck goes on telling of itself. */
export function usePictureAge(state: Sample<CameraState> | null): number | null {
  const seen = useRef({ frames: -1, at: 0 });
  void clock.value;
  if (!state || state.message.frames === 0) return null;
  const { frames = state.at } = state.message;
  if (frames !== seen.current.frames) seen.current = { frames, at: state.at };
  return performance.now() - seen.current.at;
}

/** The camera's picture: of the call where there is one, otherwise the newest ones of a camera by MJPEG. */
export function Picture({ name }: { name: string }) {
  return byCall() ? <Film stream={theirs.value!} label={t("drive.camera.alt")} muted class="drive-picture" /> : <Stream key={name} name={name} />;
}

/** The newest pictures of one camera. A hidden page looks at none, for a stream goes on in the background otherwise. A new link begins a new one: of a stream whose robot is gone, a browser keeps the last picture, and tells of no error. */
function Stream({ name }: { name: string }) {
  const address = (): string => (document.hidden ? "" : `stream.mjpg?camera=${encodeURIComponent(name.replace(PREFIX, ""))}&at=${Date.now()}`);
  const [source, from] = useState(address);
  const [there, come] = useState(false);
  const shown = useRef<HTMLImageElement>(null);
  useEffect(() => {
    const image = shown.current;
    return () => { if (image) image.src = ""; }; // one that is only taken out of the page goes on loading, and counts as a viewer
  }, [source]);
  useEffect(() => {
    const seen = (): void => { come(false); from(address()); };
    const linked = (open: boolean): void => { if (open) seen(); };
    document.addEventListener("visibilitychange", seen);
    onLink.add(linked);
    return () => { document.removeEventListener("visibilitychange", seen); onLink.delete(linked); };
  }, []);
  useEffect(() => {
    if (source !== "failed") return undefined;
    const again = setTimeout(() => from(address()), AGAIN_MS);
    return () => clearTimeout(again);
  }, [source]);
  return (
    <>
      {!there && <div class="drive-nopicture" role="status"><Icon name="camera" /><p>{t("drive.camera.wait")}</p></div>}
      {source && source !== "failed" && (
        <img ref={shown} key={source} class="drive-picture" src={source} alt={t("drive.camera.alt")} draggable={false} data-there={there || undefined} onLoad={() => come(true)} onError={() => { come(false); from("failed"); }} />
      )}
    </>
  );
}
