// How the page begins: who this is, what the robot is, then the live line.
import { effect, signal } from "@preact/signals";
import { given, pair, signIn } from "./access";
import { deviceName } from "./device";
import { remember, remembered } from "./kept";
import { connect } from "./live";
import { look, robot } from "./robot";
import { language } from "./words";

export type Theme = "auto" | "dark" | "light";
export const theme = signal<Theme>(remembered<Theme>("theme", "auto"));
effect(() => {
  document.documentElement.lang = language.value;
  remember("language", language.value);
});
effect(() => {
  if (theme.value === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme.value;
  remember("theme", theme.value);
});
effect(() => {
  if (robot.value) document.title = robot.value.robot;
});

export async function begin(): Promise<void> {
  const { token: shown, code } = given();
  if (shown) await signIn(shown);
  else if (code) await pair(code, deviceName());
  await enter();
}

/** Asks what the robot is and opens the live line, once it is known who this is. */
export async function enter(): Promise<void> {
  await look();
  connect();
}
