// Files to pixels, exactly as they are stored.

/** The pixels of a bitmap, red, green, blue and alpha of 8 bits each. */
function pixels(bitmap) {
    const { width, height } = bitmap;
    const canvas = new OffscreenCanvas(width, height);
    const context = canvas.getContext("2d", { willReadFrequently: true });
    if (!context) throw new Error(`an image of ${width}x${height} pixels is too large for this browser; scale it down`);
    context.drawImage(bitmap, 0, 0);
    const data = context.getImageData(0, 0, width, height).data;
    for (let i = 3; i < data.length; i += 4) if (data[i] !== 255) return unmixed(bitmap) ?? data;
    return data;
}

/** A 2D canvas multiplies colours by alpha, which loses bits; a texture keeps them. */
function unmixed(bitmap) {
    const { width, height } = bitmap;
    const gl = new OffscreenCanvas(1, 1).getContext("webgl2");
    if (!gl || Math.max(width, height) > gl.getParameter(gl.MAX_TEXTURE_SIZE)) return undefined;
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    const data = new Uint8ClampedArray(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(data.buffer));
    gl.getExtension("WEBGL_lose_context")?.loseContext();
    return data;
}

/** Bits a sample of a PNG; 8 for other files. */
async function depthOf(file) {
    const head = new Uint8Array(await file.slice(0, 25).arrayBuffer());
    const png = [0x89, 0x50, 0x4e, 0x47].every((byte, i) => head[i] === byte);
    return png && head.length === 25 ? head[24] : 8;
}

/** An image from a file, or from a bitmap: `width`, `height`, `data` and, if something is to be said of it, `note`. */
export async function decoded(source) {
    const name = source.name ? `"${source.name}"` : "the image";
    let bitmap = source;
    if (source instanceof Blob) {
        try {
            bitmap = await createImageBitmap(source, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
        } catch {
            throw new Error(`${name} is no image that this browser reads; give a PNG, JPEG, WebP, GIF or BMP file`);
        }
    }
    const { width, height } = bitmap;
    const data = pixels(bitmap);
    bitmap.close();
    const deep = source instanceof Blob && (await depthOf(source)) === 16;
    const note = deep ? `${name} has 16 bits a sample, of which a browser gives 8: the map differs from that of the command.` : "";
    return { width, height, data, note };
}

/** The halves of an image. */
export function halves({ width, height, data, note: said }) {
    if (width % 2 === 1 || width < 2) throw new Error(`the image is ${width} pixels wide, but two images side by side have an even width; give another one`);
    const half = width / 2;
    const side = (from) => {
        const pixels = new Uint8ClampedArray(4 * half * height);
        for (let y = 0; y < height; y++) pixels.set(data.subarray(4 * (y * width + from), 4 * (y * width + from + half)), 4 * y * half);
        return { width: half, height, data: pixels, note: said };
    };
    return [side(0), side(half)];
}
