// The npm package as it is packed: installed into a new folder, used by Node and by TypeScript.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { ROOT } from "./browser.mjs";

const dist = join(ROOT, "web/dist");
const tools = join(ROOT, "target/page/node_modules");
let folder;

const run = (program, ...args) => execFileSync(program, args, { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });

before(() => {
    folder = mkdtempSync(join(tmpdir(), "gpu-stereo-npm-"));
    const packed = readdirSync(dist).find((name) => name.endsWith(".tgz"));
    writeFileSync(join(folder, "package.json"), JSON.stringify({ name: "user", private: true, type: "module" }));
    run("npm", "install", "--silent", "--no-audit", "--no-fund", "--offline", join(dist, packed));
});

after(() => rmSync(folder, { recursive: true, force: true }));

test("it holds what it needs, and no more", () => {
    const files = readdirSync(join(folder, "node_modules/gpu-stereo")).sort();
    assert.deepEqual(files, [
        "LICENSE-APACHE", "LICENSE-MIT", "NOTICE", "README.md", "gpu_stereo_cpu.js", "gpu_stereo_cpu_bg.wasm", "gpu_stereo_gpu.js", "gpu_stereo_gpu_bg.wasm", "index.d.ts",
        "index.js", "package.json",
    ]);
});

test("it computes and checks in Node, and refuses with a StereoError", () => {
    writeFileSync(
        join(folder, "use.js"),
        `import { StereoError, StereoMatcher, check, presets } from "gpu-stereo";
        const [width, height] = [40, 20];
        const view = (shift) => Uint8Array.from({ length: width * height }, (_, i) => {
            const [x, y] = [i % width + shift, Math.floor(i / width)];
            return x * x * 31 + x * y * 17 + y * 7;
        });
        const m = await StereoMatcher.create({ device: "cpu", width, height, format: "gray8", disparities: 16 });
        const { disparities } = await m.compute(view(0), view(3));
        const stages = await check(width, height, view(0), view(3), { device: "cpu", disparities: 16, options: ["preset=strict"] });
        const refused = await StereoMatcher.create({ device: "cpu", width, height, options: { p1: 500 } }).catch((error) => error);
        console.log(JSON.stringify({
            found: disparities[10 * width + 20], different: stages.filter(({ different }) => different > 0).length, stages: stages.length,
            refused: refused instanceof StereoError && refused.kind, presets: (await presets()).map(({ name }) => name),
        }));`,
    );
    const { stages, ...rest } = JSON.parse(run("node", "use.js"));
    assert.deepEqual(rest, { found: 48, different: 0, refused: "parameter", presets: ["classic", "fast", "balanced", "strict", "dense", "accurate"] });
    assert.ok(stages >= 8);
});

test("its types hold in strict TypeScript, and a mistake is found", () => {
    const program = (format) => `import { StereoMatcher, type Maps } from "gpu-stereo";
        export async function use(device: GPUDevice, left: ImageData, right: ImageBitmap, target: GPUTexture): Promise<Maps> {
            const m = await StereoMatcher.create({ device, width: 8, height: 8, format: "${format}", options: { preset: "dense", p2: 80, wls: true } });
            await m.computeTextures(target, target, { disparity: target });
            return m.compute(left, right);
        }`;
    const check = (format) => {
        writeFileSync(join(folder, "use.ts"), program(format));
        const args = ["--noEmit", "--strict", "--module", "nodenext", "--target", "es2022", "--lib", "es2022,dom", "use.ts"];
        return run(join(tools, ".bin/tsc"), ...args);
    };
    check("rgba8");
    assert.throws(() => check("rgb8"), /Command failed/);
});
