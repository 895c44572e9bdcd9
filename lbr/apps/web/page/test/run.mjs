// Runs the tests of the page's modules that need no screen: each is bundled by Vite, then run by node's own test runner.
import { spawnSync } from "node:child_process";
import { readdirSync, rmSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { build } from "vite";

const here = fileURLToPath(new URL(".", import.meta.url));
const out = fileURLToPath(new URL("../node_modules/.test/", import.meta.url));
const tests = readdirSync(here).filter((name) => name.endsWith(".test.ts"));
rmSync(out, { recursive: true, force: true });
await build({
  root: here,
  configFile: false,
  logLevel: "warn",
  build: { ssr: true, outDir: out, minify: false, rollupOptions: { input: tests.map((name) => here + name) } },
  ssr: { noExternal: true },
});
const built = readdirSync(out).filter((name) => name.endsWith(".test.js")).map((name) => out + name);
process.exit(spawnSync(process.execPath, ["--test", ...built], { stdio: "inherit" }).status ?? 1);
