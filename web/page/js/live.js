// A camera that delivers both views side by side in one frame.

const element = (id) => document.getElementById(id);

export class Live {
    #stream;
    #frame;
    #ended;

    /** `frame(bitmap)` is awaited before the next frame; `ended(message)` is called once the camera is off. */
    constructor(frame, ended) {
        this.#frame = frame;
        this.#ended = ended;
        element("cameras").addEventListener("change", () => this.#stream && this.start(element("cameras").value));
    }

    get on() {
        return Boolean(this.#stream);
    }

    async start(id) {
        this.stop("");
        if (!navigator.mediaDevices?.getUserMedia) {
            return this.stop("This browser gives no camera here: the page must come by https or from this computer.");
        }
        const size = { width: { ideal: 2560 }, height: { ideal: 720 } };
        let stream;
        try {
            stream = await navigator.mediaDevices.getUserMedia({ video: { ...size, ...(id ? { deviceId: { exact: id } } : {}) } });
        } catch (error) {
            const why = {
                NotAllowedError: "the camera was not allowed; allow it in the browser's settings of this page",
                NotFoundError: "there is no camera; connect one",
                NotReadableError: "another program has the camera; close it there",
            };
            return this.stop(`No picture: ${why[error.name] ?? error.message}.`);
        }
        this.#stream = stream;
        const [track] = stream.getVideoTracks();
        track.addEventListener("ended", () => this.#stream === stream && this.stop("The camera was disconnected."));
        await this.#list(track.getSettings().deviceId);
        const video = element("video");
        [video.srcObject, video.hidden] = [stream, false];
        await video.play();
        this.#loop(stream, video);
    }

    async #list(chosen) {
        const select = element("cameras");
        const devices = (await navigator.mediaDevices.enumerateDevices()).filter(({ kind }) => kind === "videoinput");
        select.replaceChildren(...devices.map(({ label, deviceId }, i) => new Option(label || `Camera ${i + 1}`, deviceId)));
        select.value = chosen;
    }

    async #loop(stream, video) {
        while (this.#stream === stream) {
            // At most one frame is on its way; those that come meanwhile are left out.
            await new Promise((resolve) => setTimeout(resolve, 15));
            if (video.readyState < 2 || this.#stream !== stream) continue;
            try {
                await this.#frame(await createImageBitmap(video));
            } catch (error) {
                if (this.#stream === stream) this.stop(error.message);
            }
        }
    }

    stop(message = "") {
        this.#stream?.getTracks().forEach((track) => track.stop());
        this.#stream = undefined;
        const video = element("video");
        [video.srcObject, video.hidden] = [null, true];
        this.#ended(message);
    }
}
