// Bundles the page and the player into the folder named on the command line, ../page unless one is named.
import { build } from "esbuild";
import { copyFile, mkdir, rm } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const output = process.argv[2] ?? join(here, "..", "page");

await rm(output, { recursive: true, force: true });
await mkdir(output, { recursive: true });
await build({
  absWorkingDir: here,
  entryPoints: ["studio.js", "player.js"],
  outdir: output,
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "linked",
  logLevel: "warning",
});
await copyFile(join(here, "node_modules", "three", "LICENSE"), join(output, "three.LICENSE.txt"));
for (const name of ["style.css", "index.html"]) await copyFile(join(here, name), join(output, name));
