import "./style/tokens.css";
import "./style/base.css";
import "./style/parts.css";
import "./style/shell.css";
import { render } from "preact";
import { App } from "./app";
import { begin } from "./begin";
import { keepPage } from "./build";

const host = document.getElementById("page")!;
if (/\/display\/?$/.test(location.pathname)) void import("./views/display/Display").then(({ default: Display }) => render(<Display />, host));
else render(<App />, host);
void begin();
window.addEventListener("load", keepPage);
