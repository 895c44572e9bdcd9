// The views there are, in their order; each is shown only for a robot that has what it needs.
import type { ComponentType } from "preact";
import { streamOfType } from "./robot";
import type { Robot } from "./messages";
import type { IconName } from "./parts/icons";
import type { WordKey } from "./words";

export interface View {
  id: string;
  word: WordKey;
  icon: IconName;
  shows: (robot: Robot) => boolean;
  load: () => Promise<{ default: ComponentType }>;
}

/** What is to be mended of a robot that is not well; asked for from every view. */
export const LACKING: Pick<View, "load"> = { load: () => import("./views/system/Lacking") };

export const VIEWS: View[] = [
  { id: "drive", word: "view.drive", icon: "drive", shows: () => streamOfType("DriveState") !== "", load: () => import("./views/drive/Drive") },
  { id: "joints", word: "view.joints", icon: "joints", shows: (robot) => robot.joints.length > 0, load: () => import("./views/joints/Joints") },
  { id: "motions", word: "view.motions", icon: "motions", shows: (robot) => robot.motions.length > 0, load: () => import("./views/motions/Motions") },
  { id: "behaviours", word: "view.behaviours", icon: "behaviours", shows: () => streamOfType("BehaviourState") !== "", load: () => import("./views/behaviours/Behaviours") },
  { id: "call", word: "view.call", icon: "phone", shows: (robot) => robot.capabilities.some((one) => one.kind === "call"), load: () => import("./views/call/Call") },
  { id: "system", word: "view.system", icon: "system", shows: () => true, load: () => import("./views/system/System") },
];
