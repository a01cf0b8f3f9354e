// The page: what is shown, and what happens when something is given or changed.

import { compare } from "./check.js";
import { Cloud } from "./cloud.js";
import * as files from "./files.js";
import { Live } from "./live.js";
import { halves } from "./pixels.js";
import { Settings } from "./settings.js";
import { View } from "./view.js";
import { Compute } from "./workers.js";

const element = (id) => document.getElementById(id);
const INVALID = -32768;
const CAMERA = ["focal", "baseline", "doffs", "cx", "cy"];

const page = {
    images: { left: undefined, right: undefined },
    /** The last result, while it is of the present images and settings. */
    result: undefined,
    depth: undefined,
    camera: undefined,
    name: "disparity",
    maps: 0,
    /** Grows with every change of images and settings: what was begun before is of something else. */
    turn: 0,
    /** What was said of a lost device, and how often in a row one was lost. */
    lost: "",
    losses: 0,
    /** What is to be said of the files. */
    said: "",
    /** The side that the next single image goes to. */
    next: "left",
};

// ---- messages

function fail(message) {
    element("error").textContent = message ? message[0].toUpperCase() + message.slice(1) : "";
    element("error").hidden = !message;
}

function note(...parts) {
    const text = parts.filter(Boolean).join(" ");
    element("note").textContent = text;
    element("note").hidden = !text;
}

function busy(text) {
    element("busy").hidden = !text;
    if (text) element("busy-text").textContent = text;
}

// ---- computing

const lost = (reason) => {
    page.lost = `The GPU was lost (${reason.trim().replace(/\.$/, "")}). Another device was made, and the pair is matched again.`;
    note(page.lost);
    match();
};

/** The map lies in the worker, too: with another one it is of no use. */
const restarted = (reason) => {
    forget();
    view.stale = true;
    busy("");
    if (reason.kind !== "ended") fail(reason.message);
};

const compute = new Compute(lost, restarted);

/** Waits for something whose end by `Stop` is no error. */
async function quietly(work) {
    try {
        await work;
    } catch (error) {
        if (error.kind !== "ended") fail(error.message);
    }
}

let running = false;
let again = false;

/** Matches the pair with the present settings; if it is asked for meanwhile, once more afterwards. */
async function match() {
    if (running) {
        again = true;
        return;
    }
    running = true;
    do {
        again = false;
        await matchOnce();
    } while (again);
    running = false;
}

async function matchOnce() {
    const { left, right } = page.images;
    const { disparities, options, choice } = settings.wanted;
    forget();
    const { turn } = page;
    try {
        settings.show(await compute.ask("resolve", { disparities, options }));
    } catch (error) {
        if (again || turn !== page.turn) return;
        view.stale = true;
        return fail(settings.refuse(error.message) ? `These settings do not go together: ${error.message}` : error.message);
    }
    if (!left || !right) return;
    const slow = setTimeout(() => {
        busy("Matching");
        view.stale = true;
    }, live.on ? 1500 : 150);
    try {
        const result = await compute.ask("compute", { left, right, disparities, options, choice, colors: settings.colors });
        if (again || turn !== page.turn) return;
        fail("");
        await show(result);
    } catch (error) {
        if (again || turn !== page.turn || error.kind === "ended") return;
        view.stale = true;
        // Another device, some times.
        if (error.kind === "lost" && ++page.losses <= 3) again = true;
        else fail(settings.refuse(error.message) ? `These settings do not go together: ${error.message}` : error.message);
    } finally {
        clearTimeout(slow);
        busy("");
    }
}

/** What is shown is of something else from now on. */
function forget() {
    page.turn += 1;
    page.result = undefined;
    page.depth = undefined;
    for (const button of document.querySelectorAll("[data-save]")) button.disabled = true;
    element("check").disabled = true;
    element("verdict").textContent = "";
    element("stages").hidden = true;
}

async function show(result) {
    const { map, picture, ms, making, name, why, share } = result;
    page.result = result;
    page.losses = 0;
    paint(result);
    element("device").textContent = name;
    const made = making > 0 ? `, prepared in ${making.toFixed(0)} ms` : "";
    element("times").textContent = `${ms.toFixed(ms < 10 ? 1 : 0)} ms${made} · ${map.width}×${map.height} · ${(100 * share).toFixed(1)} % have a disparity`;
    note(page.lost, why, page.images.left.note, page.images.right.note, page.said);
    for (const button of document.querySelectorAll('[data-save]:not([data-save="ply"])')) button.disabled = false;
    element("check").disabled = live.on;
    await measure();
    // For those who wait for a map.
    document.documentElement.dataset.maps = ++page.maps;
}

function paint({ legend, first, last, picture }) {
    element("legend").getContext("2d").putImageData(legend, 0, 0);
    element("first").textContent = `${first} px`;
    element("last").textContent = `${last} px`;
    view.map(picture);
}

// ---- pixels

const view = new View((x, y) => {
    const { result, depth } = page;
    const at = `x ${x}, y ${y}`;
    if (!result) return at;
    const { map } = result;
    const value = map.disparities[y * map.width + x];
    if (value === INVALID || value === undefined) return `${at} · no disparity`;
    const metres = depth?.[y * map.width + x];
    const far = depth ? ` · depth ${metres ? `${(metres / 1e6).toFixed(3)} m` : "none"}` : "";
    return `${at} · disparity ${value / 16} px${far}`;
});

// ---- cameras and points

const cloud = new Cloud(element("cloud"));

/** The numbers of the cameras; null where they are not given, undefined where they are wrong. */
function cameras() {
    const texts = CAMERA.map((id) => element(id).value.trim().replace(",", "."));
    for (const id of CAMERA) element(id).removeAttribute("aria-invalid");
    if (texts.every((text) => text === "")) return null;
    const numbers = texts.map((text) => (text === "" ? 0 : Number(text)));
    const wrong = CAMERA.filter((id, i) => !Number.isFinite(numbers[i]) || (i < 2 && texts[i] === ""));
    if (wrong.length > 0) {
        for (const id of wrong) element(id).setAttribute("aria-invalid", "true");
        refuseCamera("Focal length and baseline are needed, and all are numbers, such as 994.978.");
        return undefined;
    }
    // The principal point is in the middle unless it is given.
    const { width, height } = page.images.left;
    const middle = { cx: (width - 1) / 2, cy: (height - 1) / 2 };
    return Object.fromEntries(CAMERA.map((id, i) => [id, texts[i] === "" ? (middle[id] ?? 0) : numbers[i]]));
}

function refuseCamera(message) {
    element("numbers-error").textContent = message;
    element("numbers-error").hidden = !message;
}

/** Depths, and the cloud where it is seen. */
async function measure() {
    const { result } = page;
    const save = document.querySelector('[data-save="ply"]');
    [page.depth, page.camera, save.disabled] = [undefined, undefined, true];
    if (!result) return;
    const camera = cameras();
    if (camera) {
        try {
            const { depth } = await compute.ask("depth", { camera });
            if (page.result !== result) return;
            [page.depth, page.camera, save.disabled] = [depth, camera, false];
            refuseCamera("");
        } catch (error) {
            if (error.kind === "ended") return;
            const name = error.message.split(" is ")[0];
            element(CAMERA.includes(name) ? name : "focal").setAttribute("aria-invalid", "true");
            refuseCamera(error.message);
        }
    } else if (camera === null) refuseCamera("");
    view.reread();
    if (view.mode === "cloud") await quietly(showCloud());
}

async function showCloud() {
    const { result, images } = page;
    element("cloud-note").textContent = cloud.works ? "" : "This browser has no WebGL 2, which the points need.";
    if (!result || !cloud.works) return;
    const { width, height } = result.map;
    // Without cameras the shape is a guess, and said to be one.
    const camera = page.camera ?? { focal: width, baseline: 0.1, doffs: 0, cx: (width - 1) / 2, cy: (height - 1) / 2 };
    if (!page.camera) element("cloud-note").textContent = "Without the cameras' numbers the proportions are a guess.";
    const { points } = await compute.ask("points", { camera });
    const { depth } = page.camera ? page : await compute.ask("depth", { camera });
    if (page.result !== result) return;
    const colors = new Uint8Array(points.length);
    let at = 0;
    depth.forEach((value, i) => {
        if (value === 0) return;
        colors.set(images.left.data.subarray(4 * i, 4 * i + 3), at);
        at += 3;
    });
    cloud.show(points, colors);
}

// ---- images

const thumbnails = { left: document.querySelector('[data-side="left"] canvas'), right: document.querySelector('[data-side="right"] canvas') };

function place(side, image) {
    page.images[side] = image;
    const canvas = thumbnails[side];
    [canvas.width, canvas.height] = [image.width, image.height];
    canvas.getContext("2d").putImageData(new ImageData(image.data, image.width, image.height), 0, 0);
    if (side === "left") {
        view.image(image);
        view.map(undefined);
    }
}

const decode = (source, transfer = []) => compute.ask("decode", { source }, transfer);

/** Takes images from files: one for a side, or two in the order of their names. */
async function take(given, side) {
    const list = [...given];
    if (list.length === 0) return;
    live.on && live.stop();
    fail("");
    page.said = "";
    try {
        if (list.length > 2) throw new Error(`these are ${list.length} files, but a pair has two; give a left and a right image`);
        list.sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
        const images = await Promise.all(list.map((file) => decode(file)));
        clearCameras();
        if (images.length === 2) {
            place("left", images[0]);
            place("right", images[1]);
            page.next = "left";
            page.said = `Left: ${list[0].name}, right: ${list[1].name}.`;
        } else {
            const target = side ?? page.next;
            place(target, images[0]);
            page.next = target === "left" ? "right" : "left";
        }
        page.name = list[0].name.replace(/\.[^.]*$/, "") || "disparity";
        pair();
    } catch (error) {
        if (error.kind !== "ended") fail(error.message);
    }
}

/** A pair is matched once both have one size. */
function pair() {
    const { left, right } = page.images;
    page.lost = "";
    forget();
    if (!left || !right) return note("Now give the other image.");
    if (left.width !== right.width || left.height !== right.height) {
        return note(`The left image is ${left.width}×${left.height}, the right one ${right.width}×${right.height}: give the other image of the pair, of the same size.`);
    }
    note("");
    match();
}

async function takeBoth(source) {
    try {
        fail("");
        page.said = "";
        const [left, right] = halves(await decode(source));
        live.on && live.stop();
        clearCameras();
        place("left", left);
        place("right", right);
        page.name = source.name?.replace(/\.[^.]*$/, "") || "disparity";
        pair();
    } catch (error) {
        if (error.kind !== "ended") fail(error.message);
    }
}

function clearCameras() {
    for (const id of CAMERA) element(id).value = "";
}

/** The example, with its cameras. */
async function example() {
    live.on && live.stop();
    fail("");
    try {
        const get = async (name) => {
            const response = await fetch(`motorcycle/${name}`);
            if (!response.ok) throw new Error(`motorcycle/${name} is not there (${response.status}); build the page once more`);
            return response;
        };
        const [left, right] = await Promise.all(["left.png", "right.png"].map(async (name) => decode(await (await get(name)).blob())));
        const text = await (await get("calib.txt")).text();
        const entry = (name) => text.match(new RegExp(`^${name}=(.*)$`, "m"))?.[1];
        const [focal, , cx, , , cy] = entry("cam0").match(/[\d.]+/g);
        [focal, String(Number(entry("baseline")) / 1000), entry("doffs"), cx, cy].forEach((value, i) => (element(CAMERA[i]).value = value));
        settings.disparities = Number(entry("ndisp"));
        place("left", left);
        place("right", right);
        [page.name, page.said, page.next] = ["motorcycle", "", "left"];
        pair();
    } catch (error) {
        if (error.kind !== "ended") fail(error.message);
    }
}

// ---- a camera

const live = new Live(
    async (bitmap) => {
        const [left, right] = halves(await decode(bitmap, [bitmap]));
        if (!live.on) return; // another pair may be there by now
        page.images = { left, right };
        page.name = "camera";
        view.image(left);
        await matchOnce();
    },
    (message) => {
        element("camera").setAttribute("aria-pressed", "false");
        element("camera").textContent = "Camera";
        element("camera-row").hidden = !message;
        element("camera-note").textContent = message;
        if (page.result) element("check").disabled = false;
    },
);

element("camera").addEventListener("click", async () => {
    if (live.on) return live.stop();
    fail("");
    note("");
    page.said = "";
    clearCameras();
    await live.start();
    if (!live.on) return;
    element("camera").setAttribute("aria-pressed", "true");
    element("camera").textContent = "Stop the camera";
    element("camera-row").hidden = false;
    element("camera-note").textContent = "The left half of each frame is the left image, the right half the right one.";
});

// ---- what the visitor does

for (const drop of document.querySelectorAll(".drop")) {
    const { side } = drop.dataset;
    drop.querySelector("input").addEventListener("change", ({ target }) => {
        take(target.files, side);
        target.value = "";
    });
    drop.addEventListener("dragenter", () => drop.classList.add("over"));
    drop.addEventListener("dragleave", () => drop.classList.remove("over"));
}

addEventListener("dragover", (event) => {
    if (!event.dataTransfer.types.includes("Files")) return;
    event.preventDefault();
    element("dropping").hidden = false;
});
addEventListener("dragleave", (event) => event.relatedTarget || (element("dropping").hidden = true));
addEventListener("drop", (event) => {
    event.preventDefault();
    element("dropping").hidden = true;
    for (const drop of document.querySelectorAll(".drop")) drop.classList.remove("over");
    if (event.dataTransfer.files.length > 0) take(event.dataTransfer.files, event.target.closest?.(".drop")?.dataset.side);
    else fail("what was dropped is no file; drop one or two images");
});
addEventListener("paste", (event) => {
    const given = [...(event.clipboardData?.files ?? [])];
    if (given.length > 0) take(given, document.activeElement?.closest?.(".drop")?.dataset.side);
    else if (!/INPUT|SELECT/.test(event.target.tagName)) fail("the clipboard holds no image; copy one, and paste it again");
});

element("both").addEventListener("change", ({ target }) => {
    if (target.files[0]) takeBoth(target.files[0]);
    target.value = "";
});
element("example").addEventListener("click", example);
element("swap").addEventListener("click", () => {
    const { left, right } = page.images;
    if (!left || !right) return;
    place("left", right);
    place("right", left);
    pair();
});
element("stop").addEventListener("click", () => {
    live.on && live.stop();
    compute.restart();
    busy("");
    note("Stopped. Change a setting or give another pair to match again.");
});
for (const radio of document.querySelectorAll('input[name="mode"]')) {
    radio.addEventListener("change", () => {
        view.arrange();
        if (view.mode === "cloud") quietly(showCloud());
    });
}
for (const id of CAMERA) element(id).addEventListener("change", measure);

for (const button of document.querySelectorAll("[data-save]")) {
    button.addEventListener("click", async () => {
        const { result, name, camera, depth, images } = page;
        const kind = button.dataset.save;
        try {
            const make = {
                png: () => files.png(result.map),
                pfm: () => files.pfm(result.map),
                npy: () => files.npy(result.map),
                ply: async () => files.ply((await compute.ask("points", { camera })).points, depth, images.left),
            };
            files.offer(await make[kind](), `${name}.${kind}`);
            fail("");
        } catch (error) {
            fail(error.message);
        }
    });
}

element("check").addEventListener("click", async () => {
    const { left, right } = page.images;
    const { disparities, options, choice } = settings.wanted;
    const { result } = page;
    element("check").disabled = true;
    busy("Comparing with the reference");
    await compare(compute.ask("check", { left, right, disparities, options, choice }), () => page.result === result);
    busy("");
    element("check").disabled = !page.result;
});

// ---- the first visit

let settings;
try {
    settings = new Settings(element("settings"), await compute.ask("start"), async (what) => {
        page.lost = "";
        if (what !== "colors") return live.on || match();
        if (!page.result) return;
        const { first, last } = page.result;
        await quietly((async () => {
            const painted = await compute.ask("paint", { first, last, colors: settings.colors });
            if (page.result) paint(Object.assign(page.result, painted));
        })());
    });
    view.arrange();
    await example();
    document.documentElement.dataset.ready = "true";
} catch (error) {
    element("device").textContent = "Not started";
    fail(`the page could not be started: ${error.message}; reload it, or take a newer browser`);
}
