// A cloud of points to turn, by WebGL.

const VERTEX = `#version 300 es
uniform mat4 view; uniform float size;
layout(location = 0) in vec3 place; layout(location = 1) in vec3 color;
out vec3 shade;
void main() { gl_Position = view * vec4(place, 1.0); gl_PointSize = max(1.0, size / max(gl_Position.w, 0.05)); shade = color; }`;
const FRAGMENT = `#version 300 es
precision mediump float; in vec3 shade; out vec4 pixel;
void main() { pixel = vec4(shade, 1.0); }`;

const HOME = { yaw: 0, pitch: 0, zoom: 1 };

function product(a, b) {
    return Float32Array.from({ length: 16 }, (_, i) => [0, 1, 2, 3].reduce((sum, k) => sum + a[(i % 4) + 4 * k] * b[k + 4 * Math.floor(i / 4)], 0));
}

export class Cloud {
    #canvas;
    #gl;
    #count = 0;
    #look = { ...HOME };
    #waiting = false;

    constructor(canvas) {
        this.#canvas = canvas;
        canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
        canvas.addEventListener("webglcontextrestored", () => this.#begin());
        this.#begin();
        let held;
        canvas.addEventListener("pointerdown", (event) => {
            held = [event.clientX, event.clientY];
            canvas.setPointerCapture(event.pointerId);
        });
        canvas.addEventListener("pointermove", (event) => {
            if (!held) return;
            this.#turn((event.clientX - held[0]) / 200, (event.clientY - held[1]) / 200);
            held = [event.clientX, event.clientY];
        });
        for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => (held = undefined));
        canvas.addEventListener("wheel", (event) => {
            event.preventDefault();
            this.#zoom(Math.exp(-event.deltaY / 600));
        }, { passive: false });
        canvas.addEventListener("keydown", (event) => {
            const keys = {
                ArrowLeft: () => this.#turn(-0.1, 0), ArrowRight: () => this.#turn(0.1, 0), ArrowUp: () => this.#turn(0, -0.1), ArrowDown: () => this.#turn(0, 0.1),
                "+": () => this.#zoom(1.15), "=": () => this.#zoom(1.15), "-": () => this.#zoom(1 / 1.15), Home: () => this.home(),
            };
            if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
            event.preventDefault();
            keys[event.key]();
        });
        new ResizeObserver(() => this.draw()).observe(canvas);
    }

    get works() {
        return Boolean(this.#gl);
    }

    /** The view, for tests. */
    get look() {
        return { ...this.#look, count: this.#count };
    }

    home() {
        this.#look = { ...HOME };
        this.draw();
    }

    #turn(yaw, pitch) {
        this.#look.yaw += yaw;
        this.#look.pitch = Math.max(-1.5, Math.min(1.5, this.#look.pitch + pitch));
        this.draw();
    }

    #zoom(factor) {
        this.#look.zoom = Math.max(0.2, Math.min(12, this.#look.zoom * factor));
        this.draw();
    }

    #begin() {
        const gl = this.#canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
        this.#gl = gl;
        if (!gl) return;
        const program = gl.createProgram();
        for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
            const shader = gl.createShader(kind);
            gl.shaderSource(shader, text);
            gl.compileShader(shader);
            gl.attachShader(program, shader);
        }
        gl.linkProgram(program);
        gl.useProgram(program);
        this.view = gl.getUniformLocation(program, "view");
        this.size = gl.getUniformLocation(program, "size");
        gl.enable(gl.DEPTH_TEST);
        for (const [at, kind, normal] of [[0, gl.FLOAT, false], [1, gl.UNSIGNED_BYTE, true]]) {
            gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
            gl.enableVertexAttribArray(at);
            gl.vertexAttribPointer(at, 3, kind, normal, 0, 0);
        }
    }

    /** Shows points (three numbers each) with colours (three bytes each). */
    show(points, colors) {
        const gl = this.#gl;
        this.#count = points.length / 3;
        if (!gl) return;
        // In the middle, and 1 deep: by the median distance, which no outlier moves.
        const depths = Float64Array.from({ length: this.#count }, (_, i) => points[3 * i + 2]).sort();
        const middle = depths[depths.length >> 1] || 1;
        const scaled = Float32Array.from(points, (value, i) => (i % 3 === 2 ? (value - middle) / middle : value / middle));
        for (const [at, data] of [[0, scaled], [1, colors]]) {
            gl.bindBuffer(gl.ARRAY_BUFFER, gl.getVertexAttrib(at, gl.VERTEX_ATTRIB_ARRAY_BUFFER_BINDING));
            gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
        }
        this.draw();
    }

    /** With the next frame of the screen, and only if something changed. */
    draw() {
        if (this.#waiting) return;
        this.#waiting = true;
        requestAnimationFrame(() => {
            this.#waiting = false;
            this.#paint();
        });
    }

    #paint() {
        const [gl, canvas] = [this.#gl, this.#canvas];
        const scale = window.devicePixelRatio;
        const [width, height] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
        if (!gl || width === 0) return;
        if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
        gl.viewport(0, 0, width, height);
        gl.clearColor(0.047, 0.07, 0.078, 1);
        gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
        if (this.#count === 0) return;
        const { yaw, pitch, zoom } = this.#look;
        const [c, s, k, t] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
        // y down and z forward become y up and z backward; then the turns, then a camera at the distance of 1.
        const flip = [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1];
        const turns = product([1, 0, 0, 0, 0, k, t, 0, 0, -t, k, 0, 0, 0, 0, 1], [c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0, 0, 0, 1]);
        const away = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 1];
        const [near, far, focus] = [0.02, 60, 2.2 * zoom];
        const lens = [focus * Math.min(1, height / width), 0, 0, 0, 0, focus * Math.min(1, width / height), 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0];
        gl.uniformMatrix4fv(this.view, false, product(lens, product(away, product(turns, flip))));
        gl.uniform1f(this.size, 0.0022 * zoom * Math.max(width, height));
        gl.drawArrays(gl.POINTS, 0, this.#count);
    }
}
