// The page as a visitor uses it, in Chromium: every control, by pointer and by keyboard, wide and narrow, light and dark.

import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { after, before, beforeEach, test } from "node:test";
import { join } from "node:path";
import { inflateSync } from "node:zlib";
import { ROOT, launch, serve } from "./browser.mjs";
import { compared, map, written } from "./command.mjs";

const SHOTS = join(ROOT, "target/page/screenshots");
const CAMERA = ["--calib", "data/motorcycle/calib.txt"];

let server, browser, page;
const foreign = [];
const faults = [];

before(async () => {
    mkdirSync(SHOTS, { recursive: true });
    server = await serve({ "": join(ROOT, "web/dist/site") });
    browser = await launch();
});

after(async () => {
    await browser?.close();
    server?.close();
});

async function open(context, { expected = [] } = {}) {
    const page = await context.newPage();
    page.on("request", (request) => {
        const url = request.url();
        if (!url.startsWith(server.url) && !/^(blob|data):/.test(url)) foreign.push(url);
    });
    page.on("pageerror", (error) => faults.push(error.message));
    page.on("console", (message) => message.type() === "error" && !expected.some((text) => message.text().includes(text)) && faults.push(message.text()));
    await page.goto(server.url);
    await page.waitForSelector("html[data-ready]");
    await settled(page, 0);
    return page;
}

const maps = (page) => page.evaluate(() => Number(document.documentElement.dataset.maps ?? 0));
const settled = (page, before) =>
    page.waitForFunction(
        (before) => Number(document.documentElement.dataset.maps ?? 0) > before && !document.querySelector('[data-save="npy"]').disabled && document.getElementById("busy").hidden,
        before,
        { timeout: 90_000 },
    );

/** Does something, and waits for the map that comes of it. */
async function matched(page, act) {
    const before = await maps(page);
    await act();
    await settled(page, before);
}

beforeEach(async () => {
    if (page) return;
    page = await open(await browser.newContext({ viewport: { width: 1280, height: 900 }, permissions: ["clipboard-read", "clipboard-write"], acceptDownloads: true }));
});

async function download(kind) {
    const [file] = await Promise.all([page.waitForEvent("download"), page.click(`[data-save="${kind}"]`)]);
    return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}

/** The disparities that are on the page, from its own NPY. */
async function disparities() {
    const { bytes } = await download("npy");
    const start = 10 + bytes.readUInt16LE(8);
    return Int16Array.from({ length: (bytes.length - start) / 4 }, (_, i) => {
        const value = bytes.readFloatLE(start + 4 * i);
        return Number.isNaN(value) ? -32768 : 16 * value;
    });
}

/** Samples of a PNG whose rows have no filter. */
function samples(png) {
    const parts = [];
    for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
        if (png.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
    }
    const [width, height] = [png.readUInt32BE(16), png.readUInt32BE(20)];
    const rows = inflateSync(Buffer.concat(parts));
    return Int32Array.from({ length: width * height }, (_, i) => rows.readUInt16BE(Math.floor(i / width) * (2 * width + 1) + 1 + 2 * (i % width)));
}

const text = (selector) => page.textContent(selector);
const choose = (selector, value) => matched(page, () => page.selectOption(selector, value));
const type = async (selector, value) => {
    await page.fill(selector, value);
    await page.press(selector, "Tab");
};

test("the first visit shows Motorcycle with the command's bits", async () => {
    assert.match(await text("#device"), /CPU/);
    assert.match(await text("#note"), /WebGPU computes on the CPU/);
    assert.match(await text("#times"), /741×500/);
    assert.deepEqual(compared(map(["--disp", "70"]), await disparities()), { different: 0, first: null });
    await page.screenshot({ path: join(SHOTS, "wide.png"), fullPage: true });
});

test("downloads are the command's files", async () => {
    const expected = written(["--disp", "70", ...CAMERA], ["png", "pfm", "npy", "ply"]);
    for (const kind of ["pfm", "npy", "ply"]) {
        const { name, bytes } = await download(kind);
        assert.equal(name, `motorcycle.${kind}`);
        assert.ok(bytes.equals(expected[kind]), `${kind}: ${bytes.length} and ${expected[kind].length} bytes`);
    }
    const values = samples((await download("png")).bytes);
    const disparity = map(["--disp", "70"]);
    const wanted = Int32Array.from(disparity, (value) => (value === -32768 ? 0 : Math.max(16 * value, 1)));
    assert.deepEqual(compared(wanted, values), { different: 0, first: null });
});

test("the pixel under the pointer and under the keys is read", async () => {
    const box = await page.locator("#map").boundingBox();
    await page.mouse.move(box.x + (box.width * 370.5) / 741, box.y + (box.height * 250.5) / 500);
    const expected = map(["--disp", "70"])[250 * 741 + 370];
    const depth = (994.978 * 0.193001) / (expected / 16 + 31.086);
    assert.equal(await text("#readout"), `x 370, y 250 · disparity ${expected / 16} px · depth ${depth.toFixed(3)} m`);
    await page.focus("#left");
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("Shift+ArrowDown");
    assert.match(await text("#readout"), /^x 371, y 266 · /);
    assert.equal(await text("#spoken"), await text("#readout"));
});

test("presets, settings, colours and their errors", async () => {
    const before = await disparities();
    await choose("#preset", "classic");
    const classic = await disparities();
    assert.ok(compared(before, classic).different > 0);
    assert.deepEqual(compared(map(["--disp", "70", "--preset", "classic"]), classic).different, 0);
    assert.match(await text("#preset-help"), /The plain chain/);
    await page.click("summary");
    await choose("#option-method", "bm");
    assert.deepEqual(compared(map(["--disp", "70", "--preset", "classic", "--method", "bm"]), await disparities()).different, 0);
    assert.ok(await page.locator("label.idle:has(#option-p1)").count()); // of no effect with block matching
    await matched(page, () => page.click('button[type="reset"]'));
    assert.equal(await page.inputValue("#option-method"), "sgm");
    await type("#option-p2", "1000");
    await page.waitForSelector("#option-p2-error:not([hidden])");
    assert.match(await text("#option-p2-error"), /p2 is 1000, but must be from p1 to 127/);
    assert.equal(await page.getAttribute("#option-p2", "aria-invalid"), "true");
    assert.ok(await page.isDisabled('[data-save="npy"]')); // no map of other settings is offered
    await type("#option-disp", "many");
    await page.waitForSelector("#option-disp-error:not([hidden])");
    await page.click('button[type="reset"]');
    await matched(page, () => type("#option-disp", "48"));
    assert.ok(await page.isHidden("#error"));
    assert.equal(await text("#last"), "47 px");
    await matched(page, () => type("#option-min-disp", "-8"));
    await page.waitForFunction(() => document.getElementById("first").textContent === "-8 px");
    const picture = () => page.evaluate(() => document.getElementById("map").toDataURL());
    const turbo = await picture();
    await page.selectOption("#colors", "viridis");
    await page.waitForFunction((turbo) => document.getElementById("map").toDataURL() !== turbo, turbo);
    await page.selectOption("#colors", "turbo");
    await page.click("summary");
    await page.selectOption("#preset", "balanced");
    await matched(page, () => page.click("#example"));
    await page.waitForFunction(() => document.getElementById("last").textContent === "69 px");
});

test("cameras give depths, and wrong ones are refused", async () => {
    await type("#focal", "");
    await page.waitForSelector("#numbers-error:not([hidden])");
    assert.ok(await page.isDisabled('[data-save="ply"]'));
    await type("#focal", "-4");
    await page.waitForFunction(() => document.getElementById("numbers-error").textContent.includes("focal is -4"));
    await type("#focal", "994,978"); // as some countries write it
    await page.waitForFunction(() => !document.querySelector('[data-save="ply"]').disabled);
    assert.ok(await page.isHidden("#numbers-error"));
});

test("wipe by pointer, by range and by keys", async () => {
    await page.check('input[value="wipe"]', { force: true });
    const box = await page.locator("#map").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width / 4, box.y + box.height / 2, { steps: 4 });
    await page.mouse.up();
    assert.ok(Math.abs((await page.inputValue("#wipe")) - 25) < 1);
    await page.focus("#wipe");
    await page.keyboard.press("End");
    assert.equal(await page.evaluate(() => document.getElementById("pictures").style.getPropertyValue("--wipe")), "100%");
    await page.fill("#wipe", "45");
    await page.screenshot({ path: join(SHOTS, "wipe.png") });
});

test("points are turned by pointer and keys", async () => {
    await page.check('input[value="cloud"]', { force: true });
    await page.waitForFunction(() => {
        const canvas = document.getElementById("cloud");
        const gl = canvas.getContext("webgl2");
        const pixels = new Uint8Array(4 * canvas.width * canvas.height);
        gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        let bright = 0;
        for (let i = 0; i < pixels.length; i += 4) bright += pixels[i] > 60;
        return bright > 5000;
    });
    const look = () => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve(document.getElementById("cloud").toDataURL())))));
    let last = await look();
    await page.screenshot({ path: join(SHOTS, "cloud-front.png") });
    const box = await page.locator("#cloud").boundingBox();
    await page.mouse.move(box.x + 300, box.y + 200);
    await page.mouse.down();
    await page.mouse.move(box.x + 220, box.y + 230, { steps: 3 });
    await page.mouse.up();
    for (const act of [null, "ArrowLeft", "ArrowUp", "+", "-", "Home"]) {
        if (act) await page.press("#cloud", act);
        const now = await look();
        assert.notEqual(now, last, act ?? "drag");
        last = now;
    }
    await page.mouse.move(box.x + 300, box.y + 200);
    await page.mouse.wheel(0, -300);
    assert.notEqual(await look(), last);
    await page.press("#cloud", "ArrowLeft");
    await page.press("#cloud", "ArrowLeft");
    await page.screenshot({ path: join(SHOTS, "cloud.png") });
    await page.check('input[value="beside"]', { force: true });
});

/** Drops files on an element. */
async function drop(selector, given) {
    const data = await page.evaluateHandle((given) => {
        const transfer = new DataTransfer();
        for (const { name, type, bytes } of given) transfer.items.add(new File([Uint8Array.from(bytes)], name, { type }));
        return transfer;
    }, given);
    for (const event of ["dragenter", "dragover", "drop"]) await page.dispatchEvent(selector, event, { dataTransfer: data });
}

const image = (side, name = `${side}.png`) => ({ name, type: "image/png", bytes: [...readFileSync(join(ROOT, `data/motorcycle/${side}.png`))] });

test("a bad file is told by name, and the page goes on", async () => {
    await drop('[data-side="left"]', [{ name: "notes.txt", type: "text/plain", bytes: [104, 105] }]);
    await page.waitForSelector("#error:not([hidden])");
    assert.match(await text("#error"), /"notes.txt" is no image that this browser reads; give a PNG/);
    await drop("body", [image("left"), image("right"), image("right", "third.png")]);
    await page.waitForFunction(() => document.getElementById("error").textContent.includes("3 files"));
    await matched(page, () => page.click("#example"));
    assert.ok(await page.isHidden("#error"));
});

test("pairs come by drop, file picker, paste, swap and in one file", async () => {
    // In the order of their names, whatever the order given.
    await matched(page, () => drop("body", [image("right", "b.png"), image("left", "a.png")]));
    await page.waitForFunction(() => document.getElementById("note").textContent.includes("Left: a.png, right: b.png"));
    const expected = map(["--disp", "70"]);
    assert.equal(compared(expected, await disparities()).different, 0);
    assert.equal(await page.inputValue("#focal"), ""); // the cameras were those of another pair
    assert.ok(await page.isDisabled('[data-save="ply"]'));

    await matched(page, () => page.click("#swap"));
    assert.ok(compared(expected, await disparities()).different > 1000);
    await matched(page, () => page.setInputFiles('[data-side="left"] input', join(ROOT, "data/motorcycle/left.png")));
    await matched(page, () => page.setInputFiles('[data-side="right"] input', join(ROOT, "data/motorcycle/right.png")));
    assert.equal(compared(expected, await disparities()).different, 0);

    // Both in one file; then one image alone, of another size, by paste.
    const both = await page.evaluate(async () => {
        const [left, right] = await Promise.all(["left", "right"].map(async (name) => createImageBitmap(await (await fetch(`motorcycle/${name}.png`)).blob(), { colorSpaceConversion: "none" })));
        const canvas = new OffscreenCanvas(2 * left.width, left.height);
        const context = canvas.getContext("2d");
        context.drawImage(left, 0, 0);
        context.drawImage(right, left.width, 0);
        return [...new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer())];
    });
    await matched(page, () => page.setInputFiles("#both", { name: "both.png", mimeType: "image/png", buffer: Buffer.from(both) }));
    assert.equal(compared(expected, await disparities()).different, 0);
    await page.evaluate(async () => {
        const canvas = new OffscreenCanvas(31, 20);
        canvas.getContext("2d").fillRect(0, 0, 31, 20);
        const transfer = new DataTransfer();
        transfer.items.add(new File([await canvas.convertToBlob()], "small.png", { type: "image/png" }));
        document.body.dispatchEvent(new ClipboardEvent("paste", { clipboardData: transfer, bubbles: true }));
    });
    await page.waitForFunction(() => document.getElementById("note").textContent.includes("31×20"));
    assert.ok(await page.isDisabled('[data-save="npy"]'));
    await page.setInputFiles("#both", { name: "odd.png", mimeType: "image/png", buffer: readFileSync(join(ROOT, "data/motorcycle/left.png")) });
    await page.waitForFunction(() => document.getElementById("error").textContent.includes("741 pixels wide"));
    await matched(page, () => page.click("#example"));
});

test("the check compares every stage, and says so", async () => {
    await page.click("#check");
    await page.waitForFunction(() => /Equal|differ/.test(document.getElementById("verdict").textContent), null, { timeout: 120_000 });
    assert.match(await text("#verdict"), /^Equal: all [\d,]+ numbers of \d+ stages/);
    assert.ok((await page.locator("#stages tbody tr").count()) >= 8);
    await page.screenshot({ path: join(SHOTS, "check.png"), fullPage: true });
});

test("a long computation leaves the page free, and is stopped", async () => {
    await page.evaluate(() => {
        self.longest = 0;
        let last = performance.now();
        const tick = () => {
            self.longest = Math.max(self.longest, performance.now() - last);
            last = performance.now();
            setTimeout(tick, 4);
        };
        tick();
    });
    await page.click("#check");
    await page.waitForSelector("#busy:not([hidden])");
    await page.waitForTimeout(400);
    const longest = await page.evaluate(() => self.longest);
    assert.ok(longest < 1000, `the page was blocked for ${longest} ms`);
    await page.click("#stop");
    await page.waitForFunction(() => document.getElementById("verdict").textContent === "Stopped.");
    await matched(page, () => page.click("#example"));
});

test("on WebGPU the map is the same, and a lost device is told and made again", async () => {
    const small = await page.evaluate(async () => {
        const cut = async (name) => {
            const bitmap = await createImageBitmap(await (await fetch(`motorcycle/${name}.png`)).blob(), 200, 120, 160, 100, { colorSpaceConversion: "none" });
            const canvas = new OffscreenCanvas(160, 100);
            canvas.getContext("2d").drawImage(bitmap, 0, 0);
            return { name: `${name}.png`, type: "image/png", bytes: [...new Uint8Array(await (await canvas.convertToBlob()).arrayBuffer())] };
        };
        return [await cut("left"), await cut("right")];
    });
    await matched(page, () => drop("body", small));
    const cpu = await disparities();
    await matched(page, () => page.check('input[name="device"][value="gpu"]', { force: true }));
    assert.match(await text("#device"), /^WebGPU/);
    assert.equal(compared(cpu, await disparities()).different, 0);
    await matched(page, () => page.workers()[0].evaluate(() => self.gpuDevice.destroy()));
    assert.match(await text("#note"), /The GPU was lost/);
    assert.ok(await page.isHidden("#error"));
    assert.match(await text("#device"), /^WebGPU/);
    assert.equal(compared(cpu, await disparities()).different, 0);
    await matched(page, () => page.check('input[name="device"][value="auto"]', { force: true }));
    await matched(page, () => page.click("#example"));
    assert.match(await text("#times"), /741×500/);
});

test("a camera's frames are matched", async () => {
    await page.click("#camera");
    await page.waitForFunction(() => document.getElementById("camera").getAttribute("aria-pressed") === "true");
    await page.waitForFunction(() => /^(?!.*741×500).*×/.test(document.getElementById("times").textContent), null, { timeout: 60_000 });
    assert.ok((await page.locator("#cameras option").count()) >= 1);
    await page.click("#camera");
    await page.waitForFunction(() => document.getElementById("camera").getAttribute("aria-pressed") === "false");
    await page.evaluate(() => (navigator.mediaDevices.getUserMedia = async () => { throw new DOMException("no", "NotAllowedError"); }));
    await page.click("#camera");
    await page.waitForFunction(() => document.getElementById("camera-note").textContent.includes("not allowed"));
    await matched(page, () => page.click("#example"));
    // The map that came may have been that of the camera's last frame.
    await page.waitForFunction(() => document.getElementById("times").textContent.includes("741×500") && !document.querySelector('[data-save="ply"]').disabled);
});

test("every control has a name, is reached by keys, and shows its focus", async () => {
    const nameless = await page.evaluate(() =>
        [...document.querySelectorAll("button, input, select, canvas:not([aria-hidden]), summary")]
            .filter((node) => !(node.labels?.[0]?.textContent.trim() || node.textContent.trim() || node.getAttribute("aria-label")))
            .map((node) => node.outerHTML),
    );
    assert.deepEqual(nameless, []);
    await page.evaluate(() => {
        // From the beginning of the page.
        document.body.tabIndex = -1;
        document.body.focus();
        document.body.removeAttribute("tabindex");
    });
    const seen = new Set();
    for (let i = 0; i < 60; i++) {
        await page.keyboard.press("Tab");
        const id = await page.evaluate(() => {
            const node = document.activeElement;
            return node === document.body ? "" : `${node.tagName}#${node.id || node.name || node.dataset.save || node.type || node.className}`;
        });
        if (!id) break;
        seen.add(id);
    }
    for (const wanted of ["A#skip", "INPUT#mode", "CANVAS#left", "CANVAS#map", "BUTTON#png", "BUTTON#check", "INPUT#file", "BUTTON#swap", "INPUT#both", "BUTTON#example", "BUTTON#camera", "SELECT#preset", "INPUT#option-disp", "INPUT#device", "SELECT#colors", "INPUT#focal"]) {
        assert.ok(seen.has(wanted), `${wanted} is not reached: ${[...seen].join(" ")}`);
    }
});

/** WCAG's contrast of all texts with their grounds. */
const faint = (page) =>
    page.evaluate(() => {
        const parse = (color) => color.match(/[\d.]+/g).map(Number);
        const light = ([r, g, b]) => [r, g, b].map((v) => v / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)).reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
        const ground = (node) => {
            for (let at = node; at; at = at.parentElement) {
                const color = parse(getComputedStyle(at).backgroundColor);
                if (color.length === 3 || color[3] === 1) return color;
            }
            return parse(getComputedStyle(document.documentElement).backgroundColor);
        };
        const faults = [];
        for (const node of document.querySelectorAll("body *")) {
            const own = [...node.childNodes].some((child) => child.nodeType === 3 && child.textContent.trim());
            if (!own || !node.checkVisibility() || node.disabled || node.closest(":disabled, .idle, .hidden, option")) continue;
            const [a, b] = [light(parse(getComputedStyle(node).color)), light(ground(node))].sort((x, y) => y - x);
            const ratio = (a + 0.05) / (b + 0.05);
            if (ratio < 4.5) faults.push(`${node.tagName} ${node.textContent.trim().slice(0, 30)}: ${ratio.toFixed(2)}`);
        }
        return faults;
    });

for (const colorScheme of ["light", "dark"]) {
    test(`at phone width, ${colorScheme}: nothing is cut off, and texts have contrast`, async () => {
        const context = await browser.newContext({ viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, hasTouch: true, isMobile: true, colorScheme, reducedMotion: "reduce" });
        const phone = await open(context);
        const overflow = await phone.evaluate(() => document.documentElement.scrollWidth - innerWidth);
        assert.ok(overflow <= 0, `${overflow} pixels too wide`);
        assert.deepEqual(await faint(phone), []);
        assert.equal(await phone.evaluate(() => getComputedStyle(document.querySelector(".spinner")).animationName), "none");
        await phone.screenshot({ path: join(SHOTS, `phone-${colorScheme}.png`), fullPage: true });
        await context.close();
    });
}

test("wide and dark, texts have contrast", async () => {
    const context = await browser.newContext({ viewport: { width: 1280, height: 900 }, colorScheme: "dark" });
    const dark = await open(context);
    await dark.screenshot({ path: join(SHOTS, "wide-dark.png"), fullPage: true });
    assert.deepEqual(await faint(dark), []);
    assert.deepEqual(await faint(page), []);
    await context.close();
});

test("without WebGPU the CPU computes, with a word about it", async () => {
    const other = await launch({ webgpu: false });
    try {
        const plain = await open(await other.newContext());
        assert.match(await plain.textContent("#device"), /CPU/);
        assert.match(await plain.textContent("#note"), /WebGPU/);
        await plain.check('input[name="device"][value="gpu"]', { force: true });
        await plain.waitForSelector("#error:not([hidden])");
        assert.match(await plain.textContent("#error"), /WebGPU/);
    } finally {
        await other.close();
    }
});

test("no request went to another host, and nothing failed unseen", () => {
    assert.deepEqual(foreign, []);
    assert.deepEqual(faults, []);
});
