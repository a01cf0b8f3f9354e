// The types of WebGPU are those of TypeScript's library `dom`; before TypeScript 6 those of the package @webgpu/types.

/** What goes wrong. The message says the value given, the values allowed and the remedy. */
export class StereoError extends Error {
    /**
     * - `parameter`: a setting outside its range
     * - `image`: an image is not what the matcher was made for
     * - `too-large`, `memory`: the pair does not fit the device, or memory
     * - `device`, `adapter`: the device lacks what the kernels need, or there is none
     * - `lost`: the device is lost; make another device and matcher
     * - `refused`: the driver refuses valid work; take another adapter, or the CPU
     * - `stopped`: the module trapped, mostly for lack of memory; it must be loaded again, such as in another worker
     * - `misuse`: a call that does not fit earlier ones
     */
    readonly kind:
        | "parameter" | "image" | "network" | "too-large" | "memory" | "device" | "lost" | "refused" | "misuse" | "dropped" | "adapter" | "stopped" | "other";
}

/** How the samples of an image are laid out: row by row from the top, without padding. */
export type Format = "gray8" | "gray16" | "rgba8" | "rgba16";

/** Settings by the names that the command has, such as `{ preset: "dense", p2: 80 }`, `["preset=dense", "p2=80"]` or pairs. */
export type Options = Record<string, string | number | boolean> | readonly string[] | readonly (readonly [string, string | number])[];

/** The cameras of a rectified pair. */
export interface Camera {
    /** Focal length in pixels, 1 to 1,000,000. */
    focal: number;
    /** Distance between the cameras in metres, 0.000001 to 1000. */
    baseline: number;
    /** Column of the right principal point less that of the left one, in pixels; 0 unless given. */
    doffs?: number;
    /** Column and row of the left principal point, in pixels; 0 unless given. */
    cx?: number;
    cy?: number;
}

export interface Settings {
    /** The device to compute on, or `"cpu"` for one thread of the CPU. Unless given, a device of the browser's adapter. */
    device?: GPUDevice | "cpu";
    /** Pixels a row. */
    width: number;
    /** Rows. */
    height: number;
    /** `rgba8` unless given. */
    format?: Format;
    /** Number of disparities to search; 64 unless given. */
    disparities?: number;
    options?: Options;
    /** Compute the right view's map, too. */
    right?: boolean;
    /** Compute the confidence, too. */
    confidence?: boolean;
    /** Compute the depth, too, seen by these cameras. */
    camera?: Camera;
}

/**
 * An image of the matcher's size: its samples (`Uint16Array` in formats of 16 bits), or, in the format `rgba8`, anything that a canvas
 * draws. Must not change until the result is there.
 */
export type Source = Uint8Array | Uint8ClampedArray | Uint16Array | ImageData | ImageBitmap | HTMLCanvasElement | OffscreenCanvas | HTMLImageElement;

/** What has a value for each pixel, row by row from the top. */
export interface Maps {
    width: number;
    height: number;
    /** Disparity in 1/16 pixel; -32768 where there is none. */
    disparities: Int16Array;
    /** The right view's, if it was asked for. */
    right: Int16Array | null;
    /** 1 to 255, 0 where there is no disparity, if it was asked for. */
    confidence: Uint8Array | null;
    labels: Uint16Array | null;
    /** Micrometres, 0 where there is none, if there are cameras. */
    depth: Uint32Array | null;
}

/** How many values of a stage differ from the reference. */
export interface StageCheck {
    stage: string;
    compared: number;
    different: number;
    first: { x: number; y: number; d: number | null; expected: number; got: number } | null;
}

/** Textures of the matcher's device and size that take the results; the formats and usages are those of the Rust library's `Outputs`. */
export interface Outputs {
    /** `r32float` in pixels, -2048 where there is none; or `r16sint` in 1/16 pixel, -32768 where there is none. */
    disparity?: GPUTexture;
    /** `rgba8unorm` or `bgra8unorm`: the colour map turbo. */
    color?: GPUTexture;
    /** Of the right view, if the matcher computes it. */
    rightDisparity?: GPUTexture;
    rightColor?: GPUTexture;
    /** `r8unorm`, if the matcher computes it. */
    confidence?: GPUTexture;
}

/** Matches rectified pairs of one size, one format and one set of settings. Calls are done one after the other. */
export class StereoMatcher {
    private constructor();
    /** Makes all buffers and kernels. */
    static create(settings: Settings): Promise<StereoMatcher>;
    readonly width: number;
    readonly height: number;
    readonly format: Format;
    /** The device it computes on; null on the CPU. */
    readonly device: GPUDevice | null;
    /** Bytes of all its buffers and textures on the device. */
    readonly deviceBytes: number;
    /** The maps of a pair. */
    compute(left: Source, right: Source): Promise<Maps>;
    /** Submits the work of a frame from textures into textures; it is done before what is submitted to the queue afterwards. */
    computeTextures(left: GPUTexture, right: GPUTexture, outputs?: Outputs): Promise<void>;
    /** The maps of what was submitted last. */
    read(): Promise<Maps>;
    /** Computes a pair and compares what each stage left with the reference, value by value. */
    check(left: Source, right: Source): Promise<StageCheck[]>;
    /** Gives back all that it holds. */
    free(): Promise<void>;
}

/**
 * Loads a module: that for devices, or that for the CPU. Every function does so at the first need. `source`: where its binary is, unless
 * beside this file.
 */
export function init(settings?: { device?: "cpu"; source?: string | URL | Request | Response | BufferSource | WebAssembly.Module }): Promise<void>;

/** A device with all features and limits that a matcher makes use of. `gpu`: what to ask in place of `navigator.gpu`. */
export function requestDevice(settings?: { powerPreference?: "low-power" | "high-performance"; gpu?: GPU }): Promise<GPUDevice>;

/** Makes a matcher, checks a pair in `format` (`gray8` unless given), and frees the matcher. */
export function check(
    width: number, height: number, left: Source, right: Source, settings?: Omit<Settings, "width" | "height">,
): Promise<StageCheck[]>;

export interface Named {
    name: string;
    help: string;
}

/** All options that `Settings.options` may have, beside `preset`. */
export function options(): Promise<(Named & { heading: string; placeholder: string; values: Named[] })[]>;

export function presets(): Promise<Named[]>;

/** What settings become: the value of each option, those that change nothing and because of which, the disparities searched. */
export function resolve(
    disparities: number, options?: Options,
): Promise<{ values: Record<string, string>; idle: Record<string, string>; first: number; last: number }>;

type Map = Pick<Maps, "width" | "height" | "disparities">;

/** The names of the colour maps. */
export function colors(): Promise<string[]>;

/** The picture of a map whose disparities are searched from `first` to `last`; black where there is none. */
export function color(
    map: Map, first: number, last: number,
    colors?: string,
): Promise<ImageData>;

/** The depth of each pixel in micrometres; 0 where there is none. */
export function depth(map: Map, camera: Camera): Promise<Uint32Array>;

/** The places that pixels with a depth show: three numbers each, metres to the right, down and forward of the left camera. */
export function points(map: Map, camera: Camera): Promise<Float64Array>;
