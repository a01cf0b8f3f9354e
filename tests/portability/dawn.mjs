// The npm package in Node, on Dawn: node dawn.mjs FOLDER-WITH-NODE_MODULES PACKAGE CASES SECONDS
// One line of JSON on stdout, on a line of its own since Dawn ends none of its warnings: the adapter, and what check.mjs found.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

import { checked } from "./check.mjs";

const [modules, folder, cases, seconds] = process.argv.slice(2);
const { create, globals } = await import(createRequire(join(modules, "x")).resolve("webgpu"));
Object.assign(globalThis, globals);
const gpu = create(["backend=vulkan"]);
const adapter = await gpu.requestAdapter();
if (!adapter) throw new Error("Dawn gives no adapter");
const { vendor, architecture, description } = adapter.info;

const stereo = await import(pathToFileURL(join(folder, "index.js")));
const device = await stereo.requestDevice({ gpu });
const load = async (name) => new Uint8Array(await readFile(join(cases, name)));
const result = await checked(stereo, device, load, Number(seconds));
console.log("\n" + JSON.stringify({ adapter: [vendor, architecture, description].filter(Boolean).join(" "), ...result }));
void gpu; // Dawn waits for nothing once this is collected
process.exit(0);
