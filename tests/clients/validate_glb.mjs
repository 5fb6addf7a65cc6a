// Checks GLB files with Khronos' validator: node validate_glb.mjs FILE...
// One line of JSON a file; exit 1 if any has an error or a warning, 2 for wrong usage.
import { readFile } from "node:fs/promises";
import { basename } from "node:path";
import { validateBytes } from "gltf-validator";

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node validate_glb.mjs FILE...");
  process.exit(2);
}

let failed = false;
for (const file of files) {
  const bytes = new Uint8Array(await readFile(file));
  const report = await validateBytes(bytes, { uri: basename(file), format: "glb", maxIssues: 0 });
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  failed ||= numErrors > 0 || numWarnings > 0;
  console.log(JSON.stringify({ file, numErrors, numWarnings, numInfos, numHints, messages: messages.slice(0, 10) }));
}
process.exit(failed ? 1 : 0);
