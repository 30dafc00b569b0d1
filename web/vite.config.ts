import { defineConfig } from "vite";

// The page is served from the package; what is built here is committed there.
export default defineConfig({
  base: "./",
  build: {
    outDir: "../src/ridedown/apps/web/static",
    emptyOutDir: true,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: "es2022",
  },
  oxc: { jsx: { runtime: "automatic", importSource: "preact" } },
});
