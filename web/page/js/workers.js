// The worker that computes, and another one where it was stopped.

export class Compute {
    #worker;
    #jobs = new Map();
    #last = 0;
    #lost;
    #restarted;

    /** `lost(reason)` is called when the device is lost, `restarted(reason)` when another worker takes over. */
    constructor(lost, restarted) {
        this.#lost = lost;
        this.#restarted = restarted;
        this.#begin();
    }

    #begin() {
        this.#worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
        this.#worker.onmessage = ({ data }) => {
            if (data.lost !== undefined) return this.#lost(data.lost);
            const job = this.#jobs.get(data.id);
            this.#jobs.delete(data.id);
            if (data.error) {
                const error = Object.assign(new Error(data.error.message), { kind: data.error.kind });
                // Its memory is not to be trusted any more.
                if (data.error.kind === "stopped") this.restart(error);
                job?.reject(error);
            } else job?.resolve(data.value);
        };
        this.#worker.onerror = (event) => {
            const error = new Error(event.message || "the worker could not be loaded; reload the page");
            // One that cannot be loaded is not tried for ever.
            for (const { reject } of this.#jobs.values()) reject(error);
            this.#jobs.clear();
        };
    }

    /** Does a job. */
    ask(job, given = {}, transfer = []) {
        return new Promise((resolve, reject) => {
            const id = ++this.#last;
            this.#jobs.set(id, { resolve, reject });
            this.#worker.postMessage({ id, job, ...given }, transfer);
        });
    }

    /** Ends what is computed, and begins anew. */
    restart(reason = Object.assign(new Error("stopped"), { kind: "ended" })) {
        this.#worker.terminate();
        const jobs = [...this.#jobs.values()];
        this.#jobs.clear();
        this.#begin();
        this.#restarted(reason);
        for (const { reject } of jobs) reject(reason);
    }
}
