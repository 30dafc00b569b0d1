import { createHash } from "node:crypto";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { defineConfig, type Plugin } from "vite";

const ROOT = import.meta.dirname;

/** Every file that the page is built from. */
function sources(): string[] {
  const inner = readdirSync(join(ROOT, "src"), { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => join(entry.parentPath, entry.name).slice(ROOT.length + 1).replaceAll("\\", "/"));
  return ["index.html", "package-lock.json", "package.json", "tsconfig.json", "vite.config.ts", ...inner].sort();
}

function hash(content: Buffer | string): string {
  return createHash("sha256").update(content).digest("hex");
}

/** Leaves built.json beside the page: the hash of each source, and of each file built, for tests that have no Node. */
function manifest(): Plugin {
  let folder = "";
  return {
    name: "manifest",
    configResolved(config) {
      folder = config.build.outDir.startsWith("/") ? config.build.outDir : join(ROOT, config.build.outDir);
    },
    closeBundle() {
      const files = readdirSync(folder, { recursive: true, withFileTypes: true })
        .filter((entry) => entry.isFile() && entry.name !== "built.json")
        .map((entry) => join(entry.parentPath, entry.name).slice(folder.length + 1).replaceAll("\\", "/"))
        .sort();
      const of = (names: string[], root: string) => Object.fromEntries(names.map((name) => [name, hash(readFileSync(join(root, name)))]));
      const built = { sources: of(sources(), ROOT), files: of(files, folder) };
      writeFileSync(join(folder, "built.json"), JSON.stringify(built, null, 1) + "\n");
    },
  };
}

// The page is served from the package; what is built here is committed there.
export default defineConfig({
  base: "./",
  plugins: [manifest()],
  build: {
    outDir: "../src/ridedown/apps/web/static",
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: "es2022",
  },
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
});
