// The npm package in a page of headless Chromium: node chromium.mjs FOLDER-WITH-NODE_MODULES PACKAGE CASES SECONDS
// One line of JSON on stdout: the browser and its adapter, and what check.mjs found.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { basename, extname, join } from "node:path";

const [modules, folder, cases, seconds] = process.argv.slice(2);
const { chromium } = createRequire(join(modules, "x"))("playwright-core");
const FLAGS = [
  "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--no-first-run", "--enable-unsafe-webgpu",
];
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".mjs": "text/javascript", ".wasm": "application/wasm" };
const ROOTS = { package: folder, cases, here: import.meta.dirname };

/** http://127.0.0.1:PORT/ROOT/FILE; every folder is flat. */
const server = createServer(async (request, response) => {
  const [, root, file] = request.url.split("/");
  try {
    const bytes = root ? await readFile(join(ROOTS[root], basename(file))) : "<!doctype html><title>gpu-stereo</title>";
    response.writeHead(200, { "content-type": TYPES[root ? extname(file) : ".html"] ?? "application/octet-stream" });
    response.end(bytes);
  } catch {
    response.writeHead(404);
    response.end();
  }
});
await new Promise((ready) => server.listen(0, "127.0.0.1", ready));

const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: FLAGS, ignoreDefaultArgs: ["--headless"] });
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(0);
  await page.goto(`http://127.0.0.1:${server.address().port}/`);
  const result = await page.evaluate(async (seconds) => {
    const stereo = await import("/package/index.js");
    const { checked } = await import("/here/check.mjs");
    const load = async (name) => {
      const response = await fetch(`/cases/${name}`);
      if (!response.ok) throw new Error(`${name}: ${response.status}`);
      return new Uint8Array(await response.arrayBuffer());
    };
    const { vendor, architecture, description } = (await navigator.gpu?.requestAdapter())?.info ?? {};
    const device = await stereo.requestDevice();
    const result = await checked(stereo, device, load, seconds);
    return { adapter: [vendor, architecture, description].filter(Boolean).join(" "), ...result };
  }, Number(seconds));
  console.log(JSON.stringify({ ...result, adapter: `Chromium ${browser.version()}, ${result.adapter}` }));
} finally {
  await browser.close();
  server.close();
}
