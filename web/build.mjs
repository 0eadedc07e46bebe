// SPDX-License-Identifier: Apache-2.0
// Bundles the pages: `node build.mjs [FOLDER]`, by default into dist/. The same sources give the same bytes.
import * as esbuild from "esbuild";
import { copyFileSync, mkdirSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");

await esbuild.build({
  absWorkingDir: here,
  entryPoints: { app: "src/live.ts", annotate: "src/annotate.ts" },
  splitting: true,  // what both pages share is in one file
  chunkNames: "shared",
  outdir: out,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  charset: "utf8",
  legalComments: "eof",  // the licences of what is bundled stay in the bundle
  logLevel: "warning",
});
await esbuild.build({
  absWorkingDir: here, entryPoints: ["src/app.css", "src/annotate.css"], outdir: out, bundle: true, minify: true, logLevel: "warning",
  target: "chrome123",  // keeps light-dark() and nesting as they are written
});
mkdirSync(out, { recursive: true });
copyFileSync(join(here, "node_modules/three/LICENSE"), join(out, "three.LICENSE.txt"));
for (const file of ["index.html", "annotate.html", "icon.svg"]) copyFileSync(join(here, "src", file), join(out, file));
