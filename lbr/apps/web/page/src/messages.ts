// The robot's messages as the page reads them; all of `lbr.messages` that it shows. Fields that a robot may lack are optional.
export type Role = "view" | "operate" | "admin";
export interface CommandReply { accepted: boolean; reason?: string; code?: string; cause?: string; note?: string; goal?: string }
export interface DriveState {
  moving: boolean; power: number; angle_deg: number; left: number; right: number; holder: string | null; goal: string | null;
  limited_by: string; reason: string; estop: boolean; stopped_s?: number | null; stopped_by?: string; halted_s?: number | null; code?: string; sees?: Record<string, number | null>; aside?: number;
  loop?: { rate_hz: number; period_p99_ms: number; period_max_ms: number; overruns: number } | null;
}
export interface GoalResult {
  goal: string; result: string; reason: string; elapsed_s: number; code?: string; range_cm?: number | null; turned_deg?: number | null;
  error_deg?: number | null; distance_m?: number | null; error_m?: number | null;
}
export interface BatteryState { valid: boolean; reason?: string; voltage_v?: number | null; current_a?: number | null; charge?: number | null; charging?: boolean | null; level: string }
export interface OdometryState { valid: boolean; epoch: string; reason?: string; x_m?: number | null; y_m?: number | null; yaw_rad?: number | null; distance_m?: number | null; speed_mps?: number | null; aside_mps?: number | null; turn_rps?: number | null; stalled?: boolean; slipping?: boolean }
export interface AttitudeState { valid: boolean; reason?: string; code?: string; roll_rad?: number | null; pitch_rad?: number | null; yaw_rad?: number | null; heading_deg?: number | null; heading_reason?: string; calibrated?: boolean }
export interface CalibrationProgress { phase: "collecting" | "fitting" | "done" | "refused"; collected: number; wanted: number; coverage: number; text?: string }
export interface Ranges { forward_m?: number | null; back_m?: number | null; left_m?: number | null; right_m?: number | null; bottom_m?: number | null; status: Record<string, string>; others_m?: Record<string, number | null> }
export interface Scan { sensor: string; angle_min_rad: number; angle_increment_rad: number; range_min_m: number; range_max_m: number; ranges_m: (number | string | null)[] }
export interface SpeechState { speaking: boolean; text: string; queued: number; reason?: string; playing?: string }
export interface CallState {
  phase: "idle" | "ringing" | "connecting" | "talking"; caller: string; at_once: boolean; by_webrtc: number; most: number; displays: number;
  camera: string; picture: string; hears: string; sound: string; reason: string; calls: number; lacks?: string;
}
export interface DanceState { phase: "resting" | "dancing" | "ended"; song: string; dance: string; beat: number; beats: number; reason: string; code?: string }
export interface BoxState { recording: string; recording_s: number; recording_mb: number; kept: number; trouble: string }
export interface CameraState { on: boolean; phase: string; width_px?: number | null; height_px?: number | null; fps?: number | null; frames?: number; reason?: string; code?: string }
export interface RangeSensor { name: string; kind: string; x_m?: number; y_m?: number; z_m?: number; yaw_rad?: number; pitch_rad?: number; fov_rad?: number; min_m?: number; max_m?: number; rays?: number; stop_m?: number | null }
export interface Event { kind: string; subject: string; text: string; level?: "info" | "warning" | "error"; wall_ns?: number; code?: string; about?: string; data?: Record<string, unknown> }
export interface CapabilityStatus {
  name: string; kind: string; phase: string; pid: number | null; restarts: number; uptime_s: number | null; reason: string; rates_hz: Record<string, number>;
  cpu_percent?: number | null; memory_mb?: number | null; last_end?: string; host?: string; code?: string; process?: string;
}
export interface EstopState { engaged: boolean; reason: string; source?: string; acknowledged?: string[]; waiting?: string[]; overdue?: string[]; text?: string }
export interface Status { robot: string; profile: string; ready: boolean; uptime_s: number; estop: EstopState; capabilities: CapabilityStatus[]; problems?: string[]; revision?: number }
export interface Schema { $ref?: string; $defs?: Record<string, Schema>; title?: string; type?: string | string[]; properties?: Record<string, Schema>; description?: string; anyOf?: Schema[] }
export interface CommandInfo { schema: Schema; role: Role; leased: boolean }
export interface Capability {
  name: string; kind: string; family: string; summary: string; phase?: string; reason?: string;
  outputs: Record<string, Schema>; commands: Record<string, CommandInfo>;
}
export interface Word { word: string; help: string; role: Role; usage: string; fields?: { name: string; choices?: string[] }[] }
export interface Robot {
  robot: string; simulated: boolean; version: string; revision: number; role: Role; capabilities: Capability[]; words: Word[];
  joints: Record<string, unknown>[]; motions: Record<string, unknown>[]; cameras: unknown[]; wheels: Record<string, unknown>[];
  ranges: RangeSensor[]; buttons: Record<string, unknown>[]; phrases: { name: string; language?: string; text?: string }[];
  base?: { capability: string; kind: string; sideways: boolean; max_speed_mps: number; max_turn_rps: number; max_power?: number; max_run_s?: number } | null;
}
