// Every .wgsl of a folder through Tint, the compiler of WGSL that Dawn and Chromium have:
//     node tint.mjs FOLDER-WITH-NODE_MODULES FOLDER
// Errors are on stderr, a line a text, and the exit code is 1.
import { readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const [modules, folder] = process.argv.slice(2);
const { create, globals } = await import(createRequire(join(modules, "x")).resolve("webgpu"));
Object.assign(globalThis, globals);

// Nothing is run, so the backend that has no driver will do.
const gpu = create(["backend=null"]); // Dawn waits for nothing once this is collected
const adapter = await gpu.requestAdapter();
const features = ["subgroups"].filter((name) => adapter.features.has(name));
if (!features.length) throw new Error("this Dawn knows no subgroups");
const device = await adapter.requestDevice({ requiredFeatures: features });
device.addEventListener("uncapturederror", (event) => event.preventDefault());

let [taken, leftOut, refused] = [0, 0, 0];
const names = readdirSync(folder).filter((name) => name.endsWith(".wgsl")).sort();
for (const name of names) {
  let code = readFileSync(join(folder, name), "utf8");
  if (/\b[iu]64\b/.test(code)) {
    leftOut += 1;
    continue;
  }
  // naga takes no such directives. A kernel reads subgroups where the whole of one arrives.
  if (code.includes("subgroup")) code = `enable subgroups; diagnostic(off, subgroup_uniformity); ${code}`;
  device.pushErrorScope("validation");
  const info = await device.createShaderModule({ code }).getCompilationInfo();
  const error = await device.popErrorScope();
  const first = info.messages.find((message) => message.type === "error") ?? error;
  if (first) {
    console.error(`${name}: ${first.lineNum ?? "?"}: ${first.message.split("\n")[0]}`);
    refused += 1;
  } else {
    taken += 1;
  }
}
console.log(`${taken + refused} texts, ${leftOut} left out`);
if (!taken && !refused) throw new Error(`${folder} has no text`);
void gpu;
process.exit(refused ? 1 : 0);
