// Opens motion files with three.js in a browser, writes where it puts their joints, and takes a picture:
// node see_with_three.mjs REFERENCE.json OUT.json PICTURE.png CHROMIUM
// A row a file and a column a time; the reference says at what seconds to look. The server is this machine's own.
import { createServer } from "node:http";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

const here = path.dirname(fileURLToPath(import.meta.url));
const [referenceName, outName, pictureName, browserName] = process.argv.slice(2);
const reference = JSON.parse(await readFile(referenceName, "utf8"));
const files = Object.keys(reference);
const kinds = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript" };

const server = createServer(async (request, response) => {
  const name = decodeURIComponent(new URL(request.url, "http://127.0.0.1").pathname);
  try {
    const bytes = await answer(name);
    response.writeHead(200, { "content-type": kinds[path.extname(name)] ?? "application/octet-stream" });
    response.end(bytes);
  } catch {
    response.writeHead(404).end();
  }
});

// the page, three.js and the files asked for by number; nothing else
async function answer(name) {
  if (name === "/see.html") return readFile(path.join(here, "see.html"));
  if (name === "/reference.json") return JSON.stringify(files.map((file) => ({ file, ...reference[file] })));
  if (name === "/favicon.ico") return "";
  const numbered = name.match(/^\/file\/(\d+)$/);
  if (numbered) return readFile(files[Number(numbered[1])]);
  const inside = path.join(here, "node_modules", "three", path.normalize(name.replace(/^\/three\//, "/")));
  if (!name.startsWith("/three/") || !inside.startsWith(path.join(here, "node_modules", "three"))) throw new Error(name);
  return readFile(inside);
}

await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
const browser = await chromium.launch({
  executablePath: browserName,
  args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking"],
});
try {
  const page = await browser.newPage({ viewport: { width: 1200, height: 300 * files.length } });
  page.on("console", (message) => message.type() === "error" && console.error(message.text()));
  page.on("pageerror", (error) => console.error(String(error)));
  await page.goto(`http://127.0.0.1:${server.address().port}/see.html`);
  await page.waitForFunction(() => window.found !== undefined, null, { timeout: 240_000 });
  const found = await page.evaluate(() => window.found);
  if (found.error) throw new Error(found.error);
  await page.screenshot({ path: pictureName });
  await writeFile(outName, JSON.stringify(found));
} finally {
  await browser.close();
  server.close();
}
