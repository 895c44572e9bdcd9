import "./style/tokens.css";
import "./style/base.css";
import "./style/parts.css";
import "./style/shell.css";
import { render } from "preact";
import { App } from "./app";
import { begin } from "./begin";
import { keepPage } from "./build";
import { remembered } from "./kept";
import { VIEWS } from "./views";

const host = document.getElementById("page")!;
if (/\/display\/?$/.test(location.pathname)) void import("./views/display/Display").then(({ default: Display }) => render(<Display />, host));
else render(<App />, host);
void begin();
// The view comes while the robot is asked what it is; one that is not shown after all does no harm.
const first = location.hash.slice(1).split("/")[0] || remembered("view", "drive");
void VIEWS.find((one) => one.id === first)?.load().catch(() => undefined);
window.addEventListener("load", keepPage);
