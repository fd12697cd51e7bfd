import { defineConfig } from "vite";

export default defineConfig({
  build: {
    outDir: "dist/page",
    emptyOutDir: true,
    target: "es2022",
    // Everything is a file of its own: the policy of the page allows nothing else.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 900,
  },
  server: {
    // `npm run dev` shows changes at once, beside a server that runs at its usual place.
    proxy: Object.fromEntries(
      ["/jobs", "/meshes", "/evaluations", "/docs", "/openapi.json"].map((path) => [
        path,
        "http://127.0.0.1:8080",
      ]),
    ),
  },
});
