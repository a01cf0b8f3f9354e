// The form of settings, made from the library's own table of options.

/** What the page has no weights, or no use, for. */
const HIDDEN = new Set(["align-corners", "memory-check"]);
const HIDDEN_VALUES = new Set(["psmnet"]);
/** Shown beside the preset. */
const ABOVE = new Set(["disp", "min-disp"]);

const LABELS = { disp: "Disparities, px", "min-disp": "Smallest, px" };

export class Settings {
    #form;
    #given = new Map();
    #fields = new Map();
    #presets;

    /** `changed` is called when a visitor changes something. */
    constructor(form, { options, presets, colors }, changed) {
        this.#form = form;
        this.#presets = presets;
        const select = form.querySelector("#preset");
        for (const { name } of presets) select.append(new Option(name, name));
        select.value = "balanced";
        for (const name of colors) form.querySelector("#colors").append(new Option(name, name));
        let heading;
        for (const option of options.filter(({ name }) => !HIDDEN.has(name))) {
            const above = ABOVE.has(option.name);
            const place = form.querySelector(above ? "#range" : "#all");
            if (!above && option.heading !== heading) {
                heading = option.heading;
                const title = document.createElement("h3");
                title.textContent = heading;
                place.append(title);
            }
            place.append(this.#field(option));
        }
        this.#given.set("disp", "70");
        form.addEventListener("submit", (event) => event.preventDefault());
        form.addEventListener("reset", (event) => {
            event.preventDefault();
            this.#given = new Map([["disp", this.#given.get("disp") ?? "64"]]);
            changed("reset");
        });
        form.addEventListener("change", ({ target }) => {
            const name = target.dataset.option;
            if (name) this.#given.set(name, target.value.trim());
            if (target.id === "preset") this.#given = new Map([...this.#given].filter(([known]) => ABOVE.has(known) || known === "schedule"));
            changed(target.id === "colors" ? "colors" : "settings");
        });
    }

    #field({ name, values, placeholder, help }) {
        const label = document.createElement("label");
        label.append(LABELS[name] ?? name);
        label.title = help;
        let input;
        if (values.length > 0) {
            input = document.createElement("select");
            for (const value of values.filter((value) => !HIDDEN_VALUES.has(value.name))) {
                input.append(new Option(value.help ? `${value.name}: ${value.help}` : value.name, value.name));
            }
        } else {
            input = document.createElement("input");
            [input.type, input.placeholder, input.autocomplete] = ["text", placeholder, "off"];
        }
        input.dataset.option = name;
        input.id = `option-${name}`;
        const error = document.createElement("span");
        [error.className, error.id, error.hidden] = ["field-error", `${input.id}-error`, true];
        input.setAttribute("aria-describedby", error.id);
        label.append(input, error);
        this.#fields.set(name, { input, label, error });
        return label;
    }

    /** Disparities searched by default with another pair. */
    set disparities(value) {
        this.#given.set("disp", String(value));
        this.#given.delete("min-disp");
    }

    /** What a matcher is made with. */
    get wanted() {
        const preset = this.#form.querySelector("#preset").value;
        const disparities = this.#given.get("disp") ?? "64";
        const options = [["preset", preset], ...[...this.#given].filter(([name]) => name !== "disp")];
        const choice = this.#form.querySelector('input[name="device"]:checked').value;
        // What is no whole number goes through the table, which says what is allowed.
        if (!/^[1-9]\d{0,8}$/.test(disparities)) return { disparities: 64, options: [...options, ["disp", disparities]], choice };
        return { disparities: Number(disparities), options, choice };
    }

    get colors() {
        return this.#form.querySelector("#colors").value;
    }

    /** Shows what the settings became. */
    show({ values, idle }) {
        const preset = this.#presets.find(({ name }) => name === this.#form.querySelector("#preset").value);
        this.#form.querySelector("#preset-help").textContent = `${preset.help[0].toUpperCase()}${preset.help.slice(1)}.`;
        for (const [name, { input, label, error }] of this.#fields) {
            if (input !== document.activeElement || input.tagName === "SELECT") input.value = values[name]; // nobody's typing is replaced
            input.removeAttribute("aria-invalid");
            error.hidden = true;
            label.classList.toggle("idle", name in idle);
            label.title = name in idle ? `No effect with this ${idle[name]}.` : label.title.startsWith("No effect") ? "" : label.title;
        }
    }

    /** Shows an error by the setting that it names. Returns whether there is one. */
    refuse(message) {
        for (const { input, error } of this.#fields.values()) {
            input.removeAttribute("aria-invalid");
            error.hidden = true;
        }
        const field = this.#fields.get(message.split(" is ")[0]);
        if (!field) return false;
        field.input.setAttribute("aria-invalid", "true");
        field.error.textContent = message;
        field.error.hidden = false;
        for (let node = field.input.parentElement; node; node = node.parentElement) if (node.tagName === "DETAILS") node.open = true;
        return true;
    }
}
