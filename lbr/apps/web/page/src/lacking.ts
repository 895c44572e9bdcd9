// Whether parts of the robot are not well, and the list of what is to be mended, which opens over every view.
import { computed, signal } from "@preact/signals";
import { inWords } from "./access";
import { status } from "./live";
import type { CapabilityStatus } from "./messages";

const SETTLED_S = 8;
/** Whether that list is open. */
export const mends = signal(false);

export const ill = ({ phase }: Pick<CapabilityStatus, "phase">): boolean => phase === "failed" || phase === "degraded";

/** The parts that are not well, once the robot has had the time to start them. */
export const unwell = computed(() => ((status.value?.uptime_s ?? 0) > SETTLED_S ? status.value!.capabilities.filter(ill) : []));

/** Why a part is not well; empty where it is. */
export const illness = (name: string): string => inWords(unwell.value.find((one) => one.name === name) ?? {});
