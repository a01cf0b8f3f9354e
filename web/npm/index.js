// The npm package gpu-stereo: a matcher of rectified pairs on WebGPU, or on the CPU.
// What the types in index.d.ts say is computed in WebAssembly, by one of two modules: on a device by gpu, on the CPU by cpu.

const MODULES = {
    gpu: { script: () => import("./gpu_stereo_gpu.js"), binary: () => new URL("./gpu_stereo_gpu_bg.wasm", import.meta.url) },
    cpu: { script: () => import("./gpu_stereo_cpu.js"), binary: () => new URL("./gpu_stereo_cpu_bg.wasm", import.meta.url) },
};

/** What goes wrong. `kind` tells what: see index.d.ts. */
export class StereoError extends Error {
    constructor(message, kind) {
        super(message);
        this.name = "StereoError";
        this.kind = kind;
    }
}

/** Errors of the module become StereoErrors; a trap says what to do. */
function raised(error) {
    if (error?.name === "StereoError" && !(error instanceof StereoError)) return new StereoError(error.message, error.kind);
    if (error instanceof WebAssembly.RuntimeError) {
        return new StereoError(
            `the module stopped: ${error.message}; it may lack memory: take a smaller pair or fewer disparities, and load the module again`,
            "stopped",
        );
    }
    return error;
}

function attempt(work) {
    try {
        return work();
    } catch (error) {
        throw raised(error);
    }
}

async function awaited(work) {
    try {
        return await work();
    } catch (error) {
        throw raised(error);
    }
}

/** The modules that are loaded or being loaded, by name. */
const loading = {};

/** Loads a module once; `source` is where its binary is. */
function load(name, source) {
    loading[name] ??= begin(name, source).catch((error) => {
        delete loading[name]; // another try may succeed
        throw error;
    });
    return loading[name];
}

async function begin(name, source) {
    const { script, binary } = MODULES[name];
    const wasm = await script();
    let given = source ?? binary();
    // Node fetches no file.
    if (given.protocol === "file:") given = await (await import("node:fs/promises")).readFile(given);
    await wasm.default({ module_or_path: given });
    return wasm;
}

/** Either module, for what both have. */
function either() {
    return loading.gpu ?? loading.cpu ?? load("gpu");
}

export async function init({ device, source } = {}) {
    await load(device === "cpu" ? "cpu" : "gpu", source);
}

/** Settings as names and values in turns. */
function flat(options) {
    if (options === undefined) return [];
    if (Array.isArray(options)) {
        return options.flatMap((option) => {
            if (typeof option !== "string") return option.map(String);
            const at = option.indexOf("=");
            if (at < 0) throw new StereoError(`the option ${JSON.stringify(option)} has no value; write name=value`, "parameter");
            return [option.slice(0, at), option.slice(at + 1)];
        });
    }
    return Object.entries(options).flatMap(([name, value]) => {
        if (typeof value === "boolean") return [name, value ? "on" : "off"];
        return [name, String(value)];
    });
}

function whole(name, value) {
    if (Number.isInteger(value) && value > 0 && value < 2 ** 32) return value;
    throw new StereoError(`${name} is ${value}, but must be a whole number above 0; give one`, "parameter");
}

function numbersOf(camera) {
    if (camera === undefined || camera === null) return new Float64Array();
    const { focal, baseline, doffs = 0, cx = 0, cy = 0 } = camera;
    return Float64Array.of(focal, baseline, doffs, cx, cy);
}

/** Hides what `names` are in an object while `work` runs. */
function shadowed(object, values, work) {
    const before = Object.keys(values).map((name) => [name, Object.getOwnPropertyDescriptor(object, name)]);
    try {
        for (const [name, value] of Object.entries(values)) {
            Object.defineProperty(object, name, { value, configurable: true, writable: true });
        }
        return work();
    } finally {
        for (const [name, descriptor] of before) {
            if (descriptor) Object.defineProperty(object, name, descriptor);
            else delete object[name];
        }
    }
}

/**
 * wgpu makes its devices itself, from `navigator.gpu`, which it reads once. For a caller's device it finds there, for as long as it
 * reads, an adapter that gives this device.
 */
function instanceOf(wasm, gpu) {
    const make = () => new wasm.Instance();
    if (!gpu) return make();
    const navigator = globalThis.navigator ?? {};
    const inside = () => shadowed(navigator, { gpu }, make);
    const missing = {};
    if (!globalThis.navigator) missing.navigator = navigator;
    if (!("Window" in globalThis) && !("WorkerGlobalScope" in globalThis)) missing.Window = class {};
    return shadowed(globalThis, missing, inside);
}

function gpuOf(device) {
    const adapter = {
        features: device.features,
        limits: device.limits,
        info: device.adapterInfo ?? { vendor: "", architecture: "", device: "", description: "" },
        requestDevice: async () => device,
    };
    return { requestAdapter: async () => adapter, getPreferredCanvasFormat: () => "bgra8unorm" };
}

/** wgpu's devices by the caller's. */
const known = new WeakMap();

async function wrapped(device) {
    if (typeof device?.createComputePipeline !== "function") {
        throw new StereoError('device is no GPUDevice; give one, "cpu", or none for the device of the browser', "misuse");
    }
    const wasm = await load("gpu");
    let own = known.get(device);
    if (!own) {
        own = await awaited(() => instanceOf(wasm, gpuOf(device)).request(false));
        known.set(device, own);
    }
    return own;
}

/** A device of the browser's, with all that a matcher makes use of. */
export async function requestDevice({ powerPreference, gpu } = {}) {
    const wasm = await load("gpu");
    const own = await awaited(() => instanceOf(wasm, gpu).request(powerPreference === "low-power"));
    known.set(own.gpu, own);
    return own.gpu;
}

/** The bytes of an image in the format of the matcher. */
async function bytesOf(image, { width, height, format }) {
    const deep = format.endsWith("16");
    if (ArrayBuffer.isView(image)) {
        const right = deep ? image instanceof Uint16Array : image.BYTES_PER_ELEMENT === 1;
        if (!right) throw new StereoError(`an image in ${format} is a ${deep ? "Uint16Array" : "Uint8Array"}; give such an array`, "image");
        return new Uint8Array(image.buffer, image.byteOffset, image.byteLength);
    }
    const size = [image?.width, image?.height];
    if (size[0] !== width || size[1] !== height) {
        const given = size[0] === undefined ? "of no size" : `${size[0]}x${size[1]}`;
        throw new StereoError(`an image is ${given}, but the matcher was made for ${width}x${height}; make another matcher`, "image");
    }
    if (format !== "rgba8") {
        throw new StereoError(`an image with colours of 8 bits needs the format rgba8, but the matcher has ${format}; make one for it`, "image");
    }
    if (ArrayBuffer.isView(image.data)) return bytesOf(image.data, { width, height, format });
    // An ImageBitmap, a canvas, an image element or a frame of a video.
    const canvas = new OffscreenCanvas(width, height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return new Uint8Array(context.getImageData(0, 0, width, height).data.buffer);
}

export class StereoMatcher {
    #matcher;
    #made;
    #before = Promise.resolve();

    constructor(matcher, made) {
        this.#matcher = matcher;
        this.#made = made;
    }

    static async create(settings) {
        const { device, width, height, format = "rgba8", disparities = 64, options, right = false, confidence = false, camera } = settings;
        const given = [whole("width", width), whole("height", height), format, whole("disparities", disparities), flat(options), right, confidence, numbersOf(camera)];
        const made = { width, height, format, device: null };
        if (device === "cpu") {
            const { CpuMatcher } = await load("cpu");
            return new StereoMatcher(attempt(() => new CpuMatcher(...given)), made);
        }
        const own = await wrapped(device ?? (await requestDevice()));
        made.device = own.gpu;
        const { GpuMatcher } = await load("gpu");
        return new StereoMatcher(await awaited(() => GpuMatcher.create(own, ...given)), made);
    }

    get width() {
        return this.#made.width;
    }

    get height() {
        return this.#made.height;
    }

    get format() {
        return this.#made.format;
    }

    get device() {
        return this.#made.device;
    }

    get deviceBytes() {
        return this.#own().device_bytes ?? 0;
    }

    #own() {
        if (this.#matcher) return this.#matcher;
        throw new StereoError("the matcher was freed; make another one", "misuse");
    }

    #onDevice() {
        if (this.#made.device) return this.#own();
        throw new StereoError("this matcher computes on the CPU, which has no textures; make one on a device", "misuse");
    }

    /** One after the other: a matcher holds one frame at a time. */
    #next(work) {
        const next = this.#before.then(() => awaited(work));
        this.#before = next.catch(() => {});
        return next;
    }

    compute(left, right) {
        return this.#next(async () => {
            const pair = [await bytesOf(left, this.#made), await bytesOf(right, this.#made)];
            return this.#own().compute(...pair);
        });
    }

    computeTextures(left, right, outputs = {}) {
        return this.#next(() => this.#onDevice().submit_textures(left, right, outputs));
    }

    read() {
        return this.#next(() => this.#onDevice().read());
    }

    check(left, right) {
        return this.#next(async () => {
            const pair = [await bytesOf(left, this.#made), await bytesOf(right, this.#made)];
            return this.#own().check(...pair);
        });
    }

    async free() {
        await this.#before;
        this.#matcher?.free();
        this.#matcher = undefined;
    }
}

/** Makes a matcher, checks a pair with it, and frees it. */
export async function check(width, height, left, right, { format = "gray8", ...settings } = {}) {
    const matcher = await StereoMatcher.create({ ...settings, width, height, format });
    try {
        return await matcher.check(left, right);
    } finally {
        await matcher.free();
    }
}

export async function options() {
    return (await either()).options();
}

export async function presets() {
    return (await either()).presets();
}

export async function resolve(disparities, options) {
    const wasm = await either();
    return attempt(() => wasm.resolve(whole("disparities", disparities), flat(options)));
}

export async function colors() {
    return (await either()).colors();
}

export async function color({ width, height, disparities }, first, last, name = "turbo") {
    const wasm = await either();
    const bytes = attempt(() => wasm.color(width, height, disparities, first, last, name));
    return new ImageData(new Uint8ClampedArray(bytes.buffer), width, height);
}

export async function depth({ width, height, disparities }, camera) {
    const wasm = await either();
    return attempt(() => wasm.depth(width, height, disparities, numbersOf(camera)));
}

export async function points({ width, height, disparities }, camera) {
    const wasm = await either();
    return attempt(() => wasm.points(width, height, disparities, numbersOf(camera)));
}
