// A real Chromium without a window, and a server for the files that it loads.

import { createServer } from "node:http";
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";

/** The project's folder. */
export const ROOT = join(import.meta.dirname, "../..");

/** Packages of npm's, which web/build and web/test install there. */
export const required = createRequire(join(ROOT, "target/page/"));

const TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".wasm": "application/wasm",
    ".png": "image/png",
    ".txt": "text/plain; charset=utf-8",
    ".json": "application/json",
};

/** What makes Chromium offer WebGPU without a GPU: it computes on SwiftShader. */
const FLAGS = [
    "--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run", "--enable-unsafe-webgpu", "--use-fake-ui-for-media-stream", "--use-fake-device-for-media-stream",
];

const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome", "/usr/bin/google-chrome-stable"];

/** Where Chromium is; `CHROMIUM` in the environment names another place. */
export function chromiumPath() {
    const asked = process.env.CHROMIUM;
    if (asked && !existsSync(asked)) throw new Error(`CHROMIUM is ${asked}, but there is no such file; name the program`);
    return asked ?? PLACES.find((place) => existsSync(place));
}

/** Serves folders by the first part of a path: `{ "": "web/dist/site" }`. Returns `url` and `close`. */
export async function serve(folders) {
    const server = createServer(async (request, response) => {
        const path = normalize(decodeURIComponent(new URL(request.url, "http://localhost").pathname));
        const [, first] = path.split("/");
        const [root, rest] = first in folders && first !== "" ? [folders[first], path.slice(first.length + 1)] : [folders[""], path];
        const file = join(root, rest.endsWith("/") ? `${rest}index.html` : rest);
        try {
            const bytes = await readFile(file);
            response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream", "cache-control": "no-store" });
            response.end(bytes);
        } catch {
            response.writeHead(404);
            response.end();
        }
    });
    await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
    return { url: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

/** A browser; `without` names flags to leave out, so that there is no WebGPU. */
export async function launch({ webgpu = true } = {}) {
    const { chromium } = required("playwright-core");
    const args = webgpu ? FLAGS : [...FLAGS.filter((flag) => flag !== "--enable-unsafe-webgpu"), "--disable-features=WebGPU", "--disable-gpu"];
    return chromium.launch({ executablePath: chromiumPath(), headless: true, args, ignoreDefaultArgs: ["--headless"] });
}
