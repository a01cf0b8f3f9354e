// Maps and points as files, byte for byte what the command writes (a PNG is compressed in another way).

const INVALID = -32768;

function concatenated(...parts) {
    return new Blob(parts, { type: "application/octet-stream" });
}

/** Disparities in pixels, with a value where there is none. */
function pixels({ disparities }, none) {
    return Float32Array.from(disparities, (value) => (value === INVALID ? none : value / 16));
}

/** Little endian on every machine. */
function floats(values) {
    const view = new DataView(new ArrayBuffer(4 * values.length));
    values.forEach((value, i) => view.setFloat32(4 * i, value, true));
    return view;
}

const CRCS = Uint32Array.from({ length: 256 }, (_, n) => {
    let crc = n;
    for (let k = 0; k < 8; k++) crc = crc & 1 ? 0xedb88320 ^ (crc >>> 1) : crc >>> 1;
    return crc;
});

function chunk(name, data) {
    const bytes = new Uint8Array(12 + data.length);
    const view = new DataView(bytes.buffer);
    view.setUint32(0, data.length);
    bytes.set(new TextEncoder().encode(name), 4);
    bytes.set(data, 8);
    let crc = 0xffffffff;
    for (const byte of bytes.subarray(4, 8 + data.length)) crc = CRCS[(crc ^ byte) & 255] ^ (crc >>> 8);
    view.setUint32(8 + data.length, ~crc >>> 0);
    return bytes;
}

/** PNG of one sample of 16 bits a pixel: 256 a pixel of disparity, 0 where there is none. */
export async function png(map) {
    const { width, height, disparities } = map;
    const rows = new DataView(new ArrayBuffer(height * (1 + 2 * width)));
    disparities.forEach((value, i) => {
        const [x, y] = [i % width, Math.floor(i / width)];
        if (value !== INVALID && (value < 0 || value > 4095)) {
            throw new Error(
                `the disparity at (${x}, ${y}) is ${value / 16} px, but a 16-bit PNG holds 0 to 255.9375 px; take PFM or NPY, or search another range`,
            );
        }
        const sample = value === INVALID ? 0 : Math.max(16 * value, 1);
        rows.setUint16(y * (1 + 2 * width) + 1 + 2 * x, sample);
    });
    const header = new DataView(new ArrayBuffer(13));
    header.setUint32(0, width);
    header.setUint32(4, height);
    header.setUint8(8, 16); // bits; gray is 0
    const packed = new Blob([rows]).stream().pipeThrough(new CompressionStream("deflate"));
    const data = new Uint8Array(await new Response(packed).arrayBuffer());
    const signature = Uint8Array.of(0x89, 0x50, 0x4e, 0x47, 13, 10, 26, 10);
    return concatenated(signature, chunk("IHDR", new Uint8Array(header.buffer)), chunk("IDAT", data), chunk("IEND", new Uint8Array()));
}

/** Portable float map: pixels, infinity where there is no disparity, rows from the bottom. */
export function pfm(map) {
    const { width, height } = map;
    const values = pixels(map, Infinity);
    const rows = Array.from({ length: height }, (_, i) => floats(values.subarray((height - 1 - i) * width, (height - i) * width)));
    return concatenated(`Pf\n${width} ${height}\n-1.0\n`, ...rows);
}

/** NumPy's array: pixels, not a number where there is no disparity. */
export function npy(map) {
    const { width, height } = map;
    const text = `{'descr': '<f4', 'fortran_order': False, 'shape': (${height}, ${width}, ), }`;
    const size = 10 + text.length + 1;
    const padded = `${text}${" ".repeat((64 - (size % 64)) % 64)}\n`;
    const head = Uint8Array.of(0x93, 0x4e, 0x55, 0x4d, 0x50, 0x59, 1, 0, padded.length & 255, padded.length >> 8);
    return concatenated(head, padded, floats(pixels(map, NaN)));
}

/** Points in metres with the colours of the left image, in the order of the pixels that have a depth. */
export function ply(points, depth, { data }) {
    const count = points.length / 3;
    const head =
        "ply\nformat binary_little_endian 1.0\ncomment metres: x right, y down, z forward of the left camera\n" +
        `element vertex ${count}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n` +
        "property uchar green\nproperty uchar blue\nend_header\n";
    const view = new DataView(new ArrayBuffer(15 * count));
    let at = 0;
    depth.forEach((value, i) => {
        if (value === 0) return;
        for (let k = 0; k < 3; k++) {
            view.setFloat32(15 * at + 4 * k, points[3 * at + k], true);
            view.setUint8(15 * at + 12 + k, data[4 * i + k]);
        }
        at += 1;
    });
    return concatenated(head, view);
}

/** Gives a file to the visitor. */
export function offer(blob, name) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
