// What a comparison with the reference found, in words and as a table.

const element = (id) => document.getElementById(id);
const count = (number) => number.toLocaleString("en");

function row({ stage, compared, different, first }) {
    const [row, head, all, other] = ["tr", "th", "td", "td"].map((name) => document.createElement(name));
    head.scope = "row";
    [head.textContent, all.textContent] = [stage, count(compared)];
    other.textContent = different === 0 ? "0" : `${count(different)}, first at ${first ? `(${first.x}, ${first.y})` : "the end"}`;
    other.className = different === 0 ? "equal" : "differs";
    row.append(head, all, other);
    return row;
}

/** Shows what comes of a check, if it is still of what is shown (`present()`). */
export async function compare(checked, present) {
    const verdict = element("verdict");
    verdict.className = "";
    verdict.textContent = "Comparing; this takes some seconds.";
    try {
        const { stages, ms } = await checked;
        if (!present()) return;
        const sum = (key) => stages.reduce((sum, stage) => sum + stage[key], 0);
        const [compared, different] = [sum("compared"), sum("different")];
        verdict.className = different === 0 ? "equal" : "differs";
        verdict.textContent =
            different === 0
                ? `Equal: all ${count(compared)} numbers of ${stages.length} stages, in ${(ms / 1000).toFixed(1)} s.`
                : `${count(different)} of ${count(compared)} numbers differ. Please report this browser and its GPU.`;
        element("stages").querySelector("tbody").replaceChildren(...stages.map(row));
        element("stages").hidden = false;
    } catch (error) {
        verdict.textContent = error.kind === "ended" ? "Stopped." : error.message;
    }
}
