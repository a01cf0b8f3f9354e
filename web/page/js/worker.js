// All that takes time: decoding, matching, checking. The page stays free meanwhile.

import * as stereo from "../gpu-stereo/index.js";
import { decoded } from "./pixels.js";

/** The device, once there is one; the matcher and what it was made for; the last map. */
const state = { device: undefined, matcher: undefined, made: "", map: undefined };

/** Software that poses as a GPU: the CPU's own schedule is many times as fast. */
const SOFTWARE = /swiftshader|llvmpipe|basic render|software/i;

function nameOf(device) {
    const { vendor = "", architecture = "", description = "" } = device.adapterInfo ?? {};
    return description || [vendor, architecture].filter(Boolean).join(" ") || "a GPU";
}

function forgetDevice() {
    [state.device, state.matcher, state.made] = [undefined, undefined, ""];
}

async function gpu() {
    if (state.device) return state.device;
    const device = await stereo.requestDevice({ powerPreference: "high-performance" });
    state.device = device;
    self.gpuDevice = device; // what a test loses
    device.lost.then(({ reason, message }) => {
        if (state.device === device) forgetDevice();
        postMessage({ lost: message || reason });
    });
    return device;
}

/** The device for a choice: `auto` takes a GPU where there is one. */
async function deviceFor(choice) {
    if (choice === "cpu") return { device: "cpu", name: "CPU, one thread", why: "" };
    try {
        if (!navigator.gpu) throw new Error("this browser has no WebGPU");
        const device = await gpu();
        const name = nameOf(device);
        const software = device.adapterInfo?.isFallbackAdapter || SOFTWARE.test(name);
        if (choice === "auto" && software) {
            return { device: "cpu", name: "CPU, one thread", why: `This browser's WebGPU computes on the CPU (${name}), where WebAssembly is faster.` };
        }
        return { device, name: `WebGPU, ${name}`, why: "" };
    } catch (error) {
        if (choice === "gpu") throw error;
        return { device: "cpu", name: "CPU, one thread", why: `Computed on the CPU: ${error.message}.` };
    }
}

async function matcherFor({ left, right, disparities, options, choice }) {
    if (left.width !== right.width || left.height !== right.height) {
        throw new stereo.StereoError(
            `the left image is ${left.width}x${left.height} and the right one ${right.width}x${right.height}, but a rectified pair has one size; ` +
                "crop or rectify them again",
            "image",
        );
    }
    const { device, name, why } = await deviceFor(choice);
    const { width, height } = left;
    const wanted = JSON.stringify([width, height, disparities, options, device === "cpu"]);
    let making = 0;
    if (state.made !== wanted || !state.matcher) {
        const before = state.matcher;
        [state.matcher, state.made] = [undefined, ""];
        await before?.free();
        const start = performance.now();
        state.matcher = await stereo.StereoMatcher.create({ device, width, height, format: "rgba8", disparities, options });
        [making, state.made] = [performance.now() - start, wanted];
    }
    return { matcher: state.matcher, name, why, making };
}

const jobs = {
    async start() {
        if (!navigator.gpu) await stereo.init({ device: "cpu" });
        const [options, presets, colors] = [await stereo.options(), await stereo.presets(), await stereo.colors()];
        return { options, presets, colors };
    },

    async decode({ source }) {
        const image = await decoded(source);
        return [image, [image.data.buffer]];
    },

    resolve: ({ disparities, options }) => stereo.resolve(disparities, options),

    async compute(job) {
        const { matcher, name, why, making } = await matcherFor(job);
        const start = performance.now();
        const map = await matcher.compute(job.left.data, job.right.data);
        const ms = performance.now() - start;
        state.map = map;
        const { first, last } = await stereo.resolve(job.disparities, job.options);
        const valid = map.disparities.reduce((count, value) => count + (value !== -32768), 0);
        return { map, ...(await painted({ first, last, colors: job.colors })), first, last, ms, making, name, why, share: valid / map.disparities.length };
    },

    paint: painted,

    async depth({ camera }) {
        return { depth: camera ? await stereo.depth(state.map, camera) : null };
    },

    async points({ camera }) {
        return { points: await stereo.points(state.map, camera) };
    },

    async check(job) {
        const { matcher } = await matcherFor(job);
        const start = performance.now();
        const stages = await matcher.check(job.left.data, job.right.data);
        return { stages, ms: performance.now() - start };
    },
};

/** The picture of the last map, and that of its colours. */
async function painted({ first, last, colors }) {
    const ramp = Int16Array.from({ length: 256 }, (_, i) => Math.round(16 * (first + (i / 255) * (last - first))));
    const picture = await stereo.color(state.map, first, last, colors);
    const legend = await stereo.color({ width: 256, height: 1, disparities: ramp }, first, last, colors);
    return { picture, legend };
}

/** One after the other, in the order in which they came. */
let before = Promise.resolve();

onmessage = ({ data: { id, job, ...given } }) => {
    before = before.then(async () => {
        try {
            const result = await jobs[job](given);
            const [value, transfer] = Array.isArray(result) ? result : [result, []];
            postMessage({ id, value }, transfer);
        } catch (error) {
            if (error?.kind === "lost") forgetDevice();
            postMessage({ id, error: { message: error?.message ?? String(error), kind: error?.kind ?? "other" } });
        }
    });
};
