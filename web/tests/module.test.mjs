// The module in Chromium: the bits of the command, the check, the caller's device and textures, errors.

import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { join } from "node:path";
import { ROOT, launch, serve } from "./browser.mjs";
import { compared, map } from "./command.mjs";

/** What takes more than some minutes on a software adapter is left to the whole test, and told. */
const SHORT = process.env.GPU_STEREO_WEB_SHORT === "1";

let server, browser, page;

before(async () => {
    server = await serve({ "": join(ROOT, "web/dist/site") });
    browser = await launch();
    page = await browser.newPage();
    await page.goto(`${server.url}motorcycle/calib.txt`); // a page without scripts
    await page.evaluate(async () => {
        self.stereo = await import("/gpu-stereo/index.js");
        const load = async (name) => {
            const blob = await (await fetch(`/motorcycle/${name}.png`)).blob();
            const bitmap = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
            const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
            context.drawImage(bitmap, 0, 0);
            return context;
        };
        const [left, right] = [await load("left"), await load("right")];
        const { width, height } = left.canvas;
        self.pair = (part) => [left, right].map((context) => context.getImageData(...(part ?? [0, 0, width, height])));
        // Two texts of numbers that fit together, for small pairs.
        self.made = (width, height) =>
            [0, 3].map((shift) =>
                Uint8Array.from({ length: width * height }, (_, i) => {
                    const [x, y] = [(i % width) + shift, Math.floor(i / width)];
                    return x * x * 31 + x * y * 17 + y * 7;
                }),
            );
        self.failure = async (work) => {
            try {
                await work();
            } catch (error) {
                return { name: error.name, kind: error.kind, message: error.message };
            }
            return null;
        };
    });
});

after(async () => {
    await browser?.close();
    server?.close();
});

/** The disparities of the Motorcycle pair, or of a part of it, in the browser. */
async function matched(device, disparities, options, part) {
    const values = await page.evaluate(
        async ([device, disparities, options, part]) => {
            const [left, right] = pair(part);
            const { width, height } = left;
            const m = await stereo.StereoMatcher.create({ device, width, height, disparities, options });
            const { disparities: values } = await m.compute(left, right);
            await m.free();
            return [...values];
        },
        [device, disparities, options, part],
    );
    return Int16Array.from(values);
}

const PART = [200, 120, 240, 160];
const SETTINGS = { classic: ["preset=classic"], balanced: ["preset=balanced"], bm: ["preset=classic", "method=bm"] };
const flags = (options) => options.flatMap((option) => [`--${option.split("=")[0]}`, option.split("=")[1]]);

for (const [name, options] of Object.entries(SETTINGS)) {
    test(`the CPU gives the command's bits of ${name}`, async () => {
        const expected = map(["--disp", "64", ...flags(options)]);
        const got = await matched("cpu", 64, options);
        assert.deepEqual(compared(expected, got), { different: 0, first: null });
        got[1000] += 1; // the comparison can fail
        assert.equal(compared(expected, got).different, 1);
    });
    for (const schedule of ["per-thread", "per-subgroup"]) {
        const whole = !SHORT || (name === "balanced" && schedule === "per-subgroup");
        test(`WebGPU gives the command's bits of ${name}, ${schedule}${whole ? "" : ", of a part"}`, async () => {
            const part = whole ? undefined : PART;
            const expected = map(["--disp", "64", ...flags(options), ...(part ? ["--crop", part.join(",")] : [])]);
            const got = await matched(undefined, 64, [...options, `schedule=${schedule}`], part);
            assert.deepEqual(compared(expected, got), { different: 0, first: null });
        });
    }
}

test("every stage equals the reference, on the CPU and by both schedules", async () => {
    for (const [device, schedule] of [["cpu", "auto"], [undefined, "per-thread"], [undefined, "per-subgroup"]]) {
        const stages = await page.evaluate(
            ([device, schedule]) => stereo.check(61, 37, ...made(61, 37), { device, disparities: 32, options: { preset: "dense", schedule } }),
            [device, schedule],
        );
        assert.ok(stages.length >= 10, JSON.stringify(stages));
        for (const { stage, compared, different, first } of stages) {
            assert.ok(compared > 0 && different === 0, `${device} ${schedule} ${stage}: ${JSON.stringify(first)}`);
        }
    }
});

test("other maps come when they are asked for", async () => {
    const sizes = await page.evaluate(async () => {
        const all = [];
        for (const device of ["cpu", undefined]) {
            const [left, right] = made(40, 20);
            const m = await stereo.StereoMatcher.create({
                device, width: 40, height: 20, format: "gray8", disparities: 16, right: true, confidence: true, camera: { focal: 100, baseline: 0.1 },
            });
            const maps = await m.compute(left, right);
            const depth = await stereo.depth(maps, { focal: 100, baseline: 0.1 });
            all.push([maps.right.length, maps.confidence.length, maps.labels, depth.every((value, i) => value === maps.depth[i]), depth.some((value) => value > 0), m.deviceBytes > 0]);
            await m.free();
        }
        return all;
    });
    assert.deepEqual(sizes, [[800, 800, null, true, true, false], [800, 800, null, true, true, true]]);
});

test("formats of 16 bits and arrays are taken, and wrong ones refused", async () => {
    const [deep, ...errors] = await page.evaluate(async () => {
        const [left, right] = made(40, 20);
        const [l16, r16] = [left, right].map((image) => Uint16Array.from(image, (value) => 257 * value));
        const make = (format) => stereo.StereoMatcher.create({ device: "cpu", width: 40, height: 20, format, disparities: 16 });
        const [eight, sixteen] = [await make("gray8"), await make("gray16")];
        const [a, b] = [(await eight.compute(left, right)).disparities, (await sixteen.compute(l16, r16)).disparities];
        return [
            [a.some((value) => value === 48), b.some((value) => value === 48)],
            await failure(() => eight.compute(l16, r16)),
            await failure(() => sixteen.compute(left, right)),
            await failure(() => eight.compute(left.subarray(1), right)),
            await failure(() => eight.compute(new ImageData(40, 20), new ImageData(40, 20))),
            await failure(() => eight.compute(new ImageData(41, 20), new ImageData(41, 20))),
            await failure(() => eight.compute({}, right)),
            await failure(() => make("rgb8")),
        ];
    });
    assert.deepEqual(deep, [true, true]);
    for (const error of errors) assert.equal(error?.name, "StereoError", JSON.stringify(errors));
    assert.match(errors[2].message, /40x20 was given 799 samples/);
    assert.match(errors[6].message, /must be gray8, gray16, rgba8 or rgba16/);
});

test("settings outside their range are refused by name", async () => {
    const errors = await page.evaluate(async () => {
        const make = (given) => failure(() => stereo.StereoMatcher.create({ device: "cpu", width: 40, height: 20, ...given }));
        return [
            await make({ options: { p2: 1000 } }),
            await make({ options: ["nonsense=1"] }),
            await make({ options: ["p2"] }),
            await make({ width: 0 }),
            await make({ disparities: 1.5 }),
            await make({ disparities: 100000 }),
            await make({ options: { method: "psmnet" } }),
            await make({ camera: { focal: -1, baseline: 1 } }),
            await make({ device: {} }),
        ];
    });
    for (const error of errors) assert.equal(error?.name, "StereoError", JSON.stringify(errors));
    assert.match(errors[0].message, /^p2 is 1000, but must be from p1 to 127/);
    assert.match(errors[6].message, /weights|network/);
    assert.match(errors[7].message, /^focal is -1/);
    assert.match(errors[8].message, /no GPUDevice/);
});

test("the caller's device and textures are taken", async () => {
    const result = await page.evaluate(async () => {
        const adapter = await navigator.gpu.requestAdapter();
        const device = await adapter.requestDevice(); // WebGPU's default limits suffice
        const [width, height] = [64, 40];
        const [left, right] = pair([300, 200, width, height]);
        const usage = GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST | GPUTextureUsage.COPY_SRC | GPUTextureUsage.RENDER_ATTACHMENT;
        const texture = (format, size = [width, height]) => device.createTexture({ size, format, usage });
        const inputs = [left, right].map(({ data }) => {
            const made = texture("rgba8unorm");
            device.queue.writeTexture({ texture: made }, data, { bytesPerRow: 4 * width }, [width, height]);
            return made;
        });
        const gpu = navigator.gpu;
        const m = await stereo.StereoMatcher.create({ device, width, height, disparities: 32 });
        const [disparity, color] = [texture("r16sint"), texture("rgba8unorm")];
        await m.computeTextures(...inputs, { disparity, color });
        const bytes = device.createBuffer({ size: 256 * height, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ });
        const encoder = device.createCommandEncoder();
        encoder.copyTextureToBuffer({ texture: disparity }, { buffer: bytes, bytesPerRow: 256 }, [width, height]);
        device.queue.submit([encoder.finish()]);
        await bytes.mapAsync(GPUMapMode.READ);
        const mapped = new Int16Array(bytes.getMappedRange().slice(0));
        const { disparities } = await m.read();
        const same = disparities.every((value, i) => value === mapped[128 * Math.floor(i / width) + (i % width)]);
        const cpu = await stereo.StereoMatcher.create({ device: "cpu", width, height, disparities: 32 });
        const plain = (await cpu.compute(left, right)).disparities;
        const other = await adapter.constructor.prototype.requestDevice.call(await navigator.gpu.requestAdapter());
        const foreign = other.createTexture({ size: [width, height], format: "rgba8unorm", usage });
        return {
            same,
            equal: plain.every((value, i) => value === disparities[i]),
            own: m.device === device,
            restored: navigator.gpu === gpu && !Object.hasOwn(navigator, "gpu"),
            errors: [
                await failure(() => m.computeTextures(inputs[0], texture("r8unorm"))),
                await failure(() => m.computeTextures(inputs[0], texture("rgba8unorm", [width, 8]))),
                await failure(() => m.computeTextures(inputs[0], texture("rgba32float"))),
                await failure(() => m.computeTextures(inputs[0], null)),
                await failure(() => m.computeTextures(...inputs, { depth: disparity })),
                await failure(() => m.computeTextures(inputs[0], foreign)),
                await failure(() => cpu.computeTextures(...inputs)),
            ],
        };
    });
    const { errors, ...rest } = result;
    assert.deepEqual(rest, { same: true, equal: true, own: true, restored: true });
    for (const error of errors) assert.equal(error?.name, "StereoError", JSON.stringify(errors));
});

test("a device that is lost is an error, and another one computes", async () => {
    const [error, after] = await page.evaluate(async () => {
        const device = await stereo.requestDevice();
        const make = (device) => stereo.StereoMatcher.create({ device, width: 40, height: 20, format: "gray8", disparities: 16 });
        const m = await make(device);
        await m.compute(...made(40, 20));
        device.destroy();
        const error = await failure(() => m.compute(...made(40, 20)));
        const other = await make(await stereo.requestDevice());
        return [error, (await other.compute(...made(40, 20))).disparities.some((value) => value === 48)];
    });
    assert.equal(error?.kind, "lost", JSON.stringify(error));
    assert.equal(after, true);
});

test("what does not fit the device is refused with the remedy, and calls after free are errors", async () => {
    const [large, freed] = await page.evaluate(async () => {
        const device = await (await navigator.gpu.requestAdapter()).requestDevice();
        const large = await failure(() => stereo.StereoMatcher.create({ device, width: 20000, height: 20000, disparities: 256 }));
        const m = await stereo.StereoMatcher.create({ device: "cpu", width: 40, height: 20, format: "gray8", disparities: 16 });
        const before = m.compute(...made(40, 20));
        await m.free(); // after what is on its way
        await before;
        return [large, await failure(() => m.compute(...made(40, 20)))];
    });
    assert.equal(large?.name, "StereoError");
    assert.match(large.message, /; /);
    assert.equal(freed?.kind, "misuse");
});

test("without WebGPU there is an error that says so, and the CPU computes", async () => {
    const [error, works] = await page.evaluate(async () => {
        const nothing = { requestAdapter: async () => null };
        const error = await failure(() => stereo.requestDevice({ gpu: nothing }));
        const m = await stereo.StereoMatcher.create({ device: "cpu", width: 40, height: 20, format: "gray8", disparities: 16 });
        return [error, (await m.compute(...made(40, 20))).disparities.length];
    });
    assert.equal(error?.kind, "adapter");
    assert.equal(works, 800);
});
