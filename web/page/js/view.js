// The left image and its map: beside each other or one over the other, and the pixel that is read.

const element = (id) => document.getElementById(id);

export class View {
    #pictures = element("pictures");
    #canvases = [element("left"), element("map")];
    #probes = [...document.querySelectorAll(".probe")];
    #read;
    #at;

    /** `read(x, y)` returns the text of a pixel. */
    constructor(read) {
        this.#read = read;
        for (const canvas of this.#canvases) {
            canvas.addEventListener("pointermove", (event) => {
                const box = canvas.getBoundingClientRect();
                const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
                if (this.mode === "wipe" && event.buttons & 1) this.wipe = 100 * x;
                this.probe(Math.floor(x * canvas.width), Math.floor(y * canvas.height));
            });
            canvas.addEventListener("pointerdown", (event) => {
                canvas.setPointerCapture(event.pointerId);
                const box = canvas.getBoundingClientRect();
                if (this.mode === "wipe") this.wipe = (100 * (event.clientX - box.left)) / box.width;
            });
            canvas.addEventListener("keydown", (event) => this.#key(event, canvas));
        }
        element("wipe").addEventListener("input", ({ target }) => (this.wipe = Number(target.value)));
    }

    #key(event, canvas) {
        const step = event.shiftKey ? 16 : 1;
        const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
        const move = moves[event.key];
        if (!move || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        const [x, y] = this.#at ?? [canvas.width >> 1, canvas.height >> 1];
        this.probe(x + move[0], y + move[1]);
        element("spoken").textContent = element("readout").textContent;
    }

    get mode() {
        return document.querySelector('input[name="mode"]:checked').value;
    }

    /** In per cent from the left. */
    set wipe(value) {
        const share = Math.max(0, Math.min(100, value));
        element("wipe").value = share;
        this.#pictures.style.setProperty("--wipe", `${share}%`);
    }

    /** Shows what the mode is for. */
    arrange() {
        const { mode } = this;
        for (const name of ["beside", "wipe"]) this.#pictures.classList.toggle(name, mode === name);
        this.#pictures.hidden = mode === "cloud";
        element("wipe-row").hidden = mode !== "wipe";
        document.querySelector(".seam").hidden = mode !== "wipe";
        element("cloud-box").hidden = mode !== "cloud";
    }

    /** The left image. */
    image({ width, height, data }) {
        for (const canvas of this.#canvases) if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
        this.#canvases[0].getContext("2d").putImageData(new ImageData(data, width, height), 0, 0);
        this.reread();
    }

    /** The picture of its map; without one the map is empty. */
    map(picture) {
        const [, canvas] = this.#canvases;
        const context = canvas.getContext("2d");
        if (picture) context.putImageData(picture, 0, 0);
        else context.clearRect(0, 0, canvas.width, canvas.height);
        this.stale = false;
        this.reread();
    }

    /** Whether the map that is shown is of other images or settings. */
    set stale(stale) {
        this.#pictures.classList.toggle("stale", stale);
    }

    probe(x, y) {
        const { width, height } = this.#canvases[0];
        this.#at = [Math.max(0, Math.min(width - 1, x)), Math.max(0, Math.min(height - 1, y))];
        const [px, py] = this.#at;
        for (const probe of this.#probes) {
            probe.hidden = false;
            [probe.style.left, probe.style.top] = [`${(100 * (px + 0.5)) / width}%`, `${(100 * (py + 0.5)) / height}%`];
        }
        element("readout").textContent = this.#read(px, py);
    }

    reread() {
        const [canvas] = this.#canvases;
        if (!this.#at) return;
        if (this.#at[0] < canvas.width && this.#at[1] < canvas.height) this.probe(...this.#at);
        else this.#at = undefined;
    }
}
