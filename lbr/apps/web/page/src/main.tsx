import "./style/tokens.css";
import "./style/base.css";
import "./style/parts.css";
import "./style/shell.css";
import { render } from "preact";
import { App } from "./app";
import { begin } from "./begin";

render(<App />, document.getElementById("page")!);
void begin();
