// What the command gives, for comparison.

import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { ROOT } from "./browser.mjs";

const INVALID = -32768;

/** The program: `GPU_STEREO_COMMAND`, or that of the last build. */
function program() {
    const target = process.env.CARGO_TARGET_DIR ?? join(ROOT, "target");
    const place = process.env.GPU_STEREO_COMMAND ?? join(target, "debug/gpu-stereo");
    if (!existsSync(place)) throw new Error(`${place} is not there; cargo build -p gpu-stereo-cli makes it`);
    return place;
}

/** The bytes of the files that the command writes of the Motorcycle pair, by their endings. */
export function written(options, endings, pair = ["data/motorcycle/left.png", "data/motorcycle/right.png"]) {
    const folder = mkdtempSync(join(tmpdir(), "gpu-stereo-web-"));
    try {
        const outputs = endings.flatMap((ending) => [ending === "ply" ? "--points" : "-o", join(folder, `map.${ending}`)]);
        execFileSync(program(), [...pair, "--backend", "cpu", ...options, ...outputs], { cwd: ROOT, stdio: ["ignore", "ignore", "inherit"] });
        return Object.fromEntries(endings.map((ending) => [ending, readFileSync(join(folder, `map.${ending}`))]));
    } finally {
        rmSync(folder, { recursive: true });
    }
}

/** A map of the command's in 1/16 px. */
export function map(options, pair) {
    const bytes = written(options, ["npy"], pair).npy;
    const start = 10 + bytes.readUInt16LE(8);
    return Int16Array.from({ length: (bytes.length - start) / 4 }, (_, i) => {
        const value = bytes.readFloatLE(start + 4 * i);
        return Number.isNaN(value) ? INVALID : 16 * value;
    });
}

/** How many values differ, and the first that does. */
export function compared(expected, got) {
    if (expected.length !== got.length) return { different: Infinity, first: `${got.length} values, not ${expected.length}` };
    let [different, first] = [0, null];
    for (let i = 0; i < expected.length; i++) {
        if (expected[i] === got[i]) continue;
        different += 1;
        first ??= { i, expected: expected[i], got: got[i] };
    }
    return { different, first };
}
