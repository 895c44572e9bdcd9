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

/** Writes which sources `dist/` was built from, so that a test without node sees when it is behind them. */
function manifest(): Plugin {
  return {
    name: "manifest",
    apply: "build",
    closeBundle() {
      const all = SOURCES.flatMap((name) => files(resolve(here, name))).map((file) => relative(here, file).replaceAll("\\", "/"));
      const digest = createHash("sha256");
      for (const name of all.sort()) {
        digest.update(`${sha256(resolve(here, name))}  ${name}\n`);
      }
      const dist = resolve(here, "dist");
      const built = files(dist).map((file) => relative(dist, file).replaceAll("\\", "/")).filter((name) => name !== "manifest.json");
      const told = { sources: digest.digest("hex"), files: Object.fromEntries(built.sort().map((name) => [name, sha256(resolve(dist, name))])) };
      writeFileSync(resolve(here, "dist/manifest.json"), `${JSON.stringify(told, null, 1)}\n`);
    },
  };
}

export default defineConfig({
  root: here,
  base: "./",
  plugins: [manifest()],
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
      ["/api", "/stop", "/estop", "/session", "/sessions", "/state", "/stream.mjpg", "/snapshot.jpg", "/cameras", "/qr"].map((path) => [
        path,
        { target: robot, ws: path === "/api", changeOrigin: true, headers: { Origin: robot } },
      ]),
    ),
  },
});
