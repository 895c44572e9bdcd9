// One WebRTC connection with the robot: offered, answered, kept alive, left. No servers but the robot itself are asked for anything.
import { ask, told } from "./access";
import { t } from "./words";

export type Purpose = "talk" | "watch" | "display";
export type Phase = "ringing" | "connecting" | "talking";
export type Hears = "microphone" | "tone" | "silence";
interface Told { id: string; phase: Phase | "idle"; answer: string; picture: string; hears: Hears; sound: string; seen: boolean }
export interface News { phase: Phase; picture: string; hears: Hears; sound: string; seen: boolean }
export interface Connection { close: () => void }
interface Wanted {
  purpose: Purpose;
  send?: MediaStream | null;
  onMedia: (stream: MediaStream) => void;
  onNews: (news: News) => void;
  /** It is over, or never came to be: why, and whether the robot itself said so. */
  onEnd: (reason: string, code: string) => void;
}

const GATHER_MS = 1200;
const SOON_MS = 200;
const KEEP_MS = 1000;
const LOST_MS = 8000;
const SPOKEN = ["video/VP8", "video/rtx"];

/** Begins a connection; everything that comes of it is told by the callbacks. */
export function connect(wanted: Wanted): Connection {
  const pc = new RTCPeerConnection({ iceServers: [] });
  const media = new MediaStream();
  let id = "";
  let over = false;
  let heard = performance.now();

  const leave = (): void => { if (id) void ask(`call/${encodeURIComponent(id)}`, { method: "POST", body: { leave: true }, quiet: true, keepalive: true }); };
  const close = (): void => {
    if (over) return;
    over = true;
    window.removeEventListener("pagehide", close);
    pc.close();
    leave();
  };
  const end = (reason: string, code: string): void => {
    if (over) return;
    close();
    wanted.onEnd(reason, code);
  };

  window.addEventListener("pagehide", close);
  pc.ontrack = ({ track, receiver }) => {
    if ("jitterBufferTarget" in receiver && track.kind === "video") receiver.jitterBufferTarget = 0;
    media.addTrack(track);
    wanted.onMedia(media);
  };
  pc.onconnectionstatechange = () => { if (pc.connectionState === "failed") end(t("call.lost"), "unreachable"); };

  const keep = async (): Promise<void> => {
    if (over) return;
    const answer = await ask<Told>(`call/${encodeURIComponent(id)}`, { method: "POST", body: {}, quiet: true, timeoutMs: 4000 });
    if (over) return;
    if (answer.ok && answer.data) {
      heard = performance.now();
      const { phase, answer: sdp, picture, hears, sound, seen } = answer.data;
      if (phase === "idle") return end(answer.reason, answer.code);
      if (sdp && pc.signalingState === "have-local-offer") await pc.setRemoteDescription({ type: "answer", sdp });
      wanted.onNews({ phase: phase === "talking" && pc.connectionState !== "connected" ? "connecting" : phase, picture, hears, sound, seen });
    } else if (answer.status >= 400 && answer.status < 500) return end(told(answer), answer.code);
    else if (performance.now() - heard > LOST_MS) return end(t("call.lost"), "unreachable");
    setTimeout(() => void keep().catch(failed), pc.connectionState === "connected" ? KEEP_MS : SOON_MS);
  };
  const failed = (err: unknown): void => end(err instanceof Error ? err.message : String(err), "failed");

  const begin = async (): Promise<void> => {
    for (const kind of wanted.purpose === "watch" ? (["video"] as const) : (["video", "audio"] as const)) {
      const track = wanted.send?.getTracks().find((one) => one.kind === kind);
      const made = pc.addTransceiver(track ?? kind, { direction: track ? "sendrecv" : "recvonly", streams: track && wanted.send ? [wanted.send] : [] });
      const codecs = kind === "video" ? RTCRtpReceiver.getCapabilities?.("video")?.codecs.filter((one) => SPOKEN.includes(one.mimeType)) : undefined;
      if (codecs?.length) made.setCodecPreferences(codecs);
    }
    await pc.setLocalDescription();
    await gathered(pc);
    const answer = await ask<Told>("call", { method: "POST", body: { purpose: wanted.purpose, offer: pc.localDescription?.sdp ?? "" }, quiet: true });
    if (!answer.ok || !answer.data) return end(told(answer), answer.code);
    id = answer.data.id;
    heard = performance.now();
    if (over) return leave();
    await keep();
  };
  begin().catch(failed);
  return { close };
}

function gathered(pc: RTCPeerConnection): Promise<void> {
  return new Promise((done) => {
    const late = setTimeout(done, GATHER_MS);
    const look = (): void => {
      if (pc.iceGatheringState !== "complete") return;
      clearTimeout(late);
      done();
    };
    pc.onicegatheringstatechange = look;
    look();
  });
}
