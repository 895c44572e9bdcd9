import { createHash } from "node:crypto";
import { readdirSync, readFileSync, statSync, writeFileSync } from "node:fs";
import { join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { defineConfig, type Plugin } from "vite";

const here = fileURLToPath(new URL(".", import.meta.url));
const robot = process.env.LBR_PAGE_ROBOT ?? "http://127.0.0.1:50000";
const SOURCES = ["index.html", "package.json", "package-lock.json", "vite.config.ts", "tsconfig.json", "src", "public"];

function files(place: string): string[] {
  if (!statSync(place).isDirectory()) return [place];
  return readdirSync(place).flatMap((name) => files(join(place, name)));
}

const sha256 = (file: string): string => createHash("sha256").update(readFileSync(file)).digest("hex");

/** The digest of all sources: what this build of the page is called. */
function digestOfSources(): string {
  const all = SOURCES.flatMap((name) => files(resolve(here, name))).map((file) => relative(here, file).replaceAll("\\", "/"));
  const digest = createHash("sha256");
  for (const name of all.sort()) digest.update(`${sha256(resolve(here, name))}  ${name}\n`);
  return digest.digest("hex");
}

const sources = digestOfSources();
const build = sources.slice(0, 16);
const NOT_KEPT = ["manifest.json", "worker.js", "licences.md"];

/** Tells the worker which files there are, and writes which sources `dist/` was built from, so that a test without node
 * sees when it is behind them. */
function manifest(): Plugin {
  return {
    name: "manifest",
    apply: "build",
    closeBundle() {
      const dist = resolve(here, "dist");
      const names = (): string[] => files(dist).map((file) => relative(dist, file).replaceAll("\\", "/")).sort();
      const digests = (given: string[]): Record<string, string> => Object.fromEntries(given.map((name) => [name, sha256(resolve(dist, name))]));
      const kept = digests(names().filter((name) => !NOT_KEPT.includes(name)));
      const named = [...readFileSync(resolve(dist, "index.html"), "utf8").matchAll(/(?:src|href)="\.\/([^"]+)"/g)].map((found) => found[1]!);
      const shell = ["index.html", ...named];
      const quoted = (value: unknown): string => JSON.stringify(JSON.stringify(value)).slice(1, -1);
      const worker = resolve(dist, "worker.js");
      const text = readFileSync(worker, "utf8").replace("__BUILD__", build).replace("__FILES__", () => quoted(kept)).replace("__SHELL__", () => quoted(shell));
      writeFileSync(worker, text);
      const told = { sources, files: digests(names().filter((name) => name !== "manifest.json")) };
      writeFileSync(resolve(dist, "manifest.json"), `${JSON.stringify(told, null, 1)}\n`);
    },
  };
}

export default defineConfig({
  root: here,
  base: "./",
  plugins: [manifest()],
  define: { __BUILD__: JSON.stringify(build) },
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
  build: {
    target: "es2022",
    outDir: "dist",
    emptyOutDir: true,
    sourcemap: false,
    license: { fileName: "licences.md" },
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    reportCompressedSize: true,
    chunkSizeWarningLimit: 700,
  },
  server: {
    proxy: Object.fromEntries(
      ["/api", "/stop", "/estop", "/session", "/sessions", "/state", "/stream.mjpg", "/snapshot.jpg", "/cameras", "/call", "/qr"].map((path) => [
        path,
        { target: robot, ws: path === "/api", changeOrigin: true, headers: { Origin: robot } },
      ]),
    ),
  },
});
