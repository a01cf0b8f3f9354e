#!/usr/bin/env python3
"""Makes GALLERY.md and its pictures, from a clean checkout, in about a minute after the build:

    python3 docs/gallery.py [PROGRAM]

PROGRAM is the built command; without it, cargo builds a release. Needs Python 3.8 alone. Of the pairs that lie beside
the project in ../shared/data, where they do, the same sheets are written to target/gallery: their terms are not known.
"""

import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
PICTURES = ROOT / "docs" / "images" / "gallery"
REPORT = ROOT.parent / "shared" / "data" / "student_report"

# Folder, names of the images, disparities, and the search widths of the section on them.
OWN = {
    "motorcycle": ("data/motorcycle", "left.png", "right.png", "64", "41,61,81"),
    "corridor": ("data/corridor", "left.png", "right.png", "48", "24,48,72"),
}
BESIDE = {
    "report-corridor": (REPORT / "corridor", "corridorl.jpg", "corridorr.jpg", "16", "8,16,24"),
    "report-triclops": (REPORT / "triclops", "triclopsi2l.jpg", "triclopsi2r.jpg", "24", "11,16,24"),
}

CLASSIC = ["--preset", "classic"]
BM = [*CLASSIC, "--method", "bm"]
OFF = "uniqueness=off+lr-check=off+speckle-window=off+median=off"

# Name, title, the study with its options ({disp}, {widths}: the pair's), and what to see in the picture of each pair.
SECTIONS = [
    (
        "costs",
        "SAD against SSD",
        ["sweep", *BM, "--disp", "{disp}", "--cost", "sad,ssd", "--block", "5,9,15,21"],
        {
            "motorcycle": "Squares give the strongest edge in a block more weight, so with SSD the outlines of tank and "
            "wheels grow a little thicker than with SAD; the larger the block, the smoother both maps and the fatter "
            "the spokes.",
            "corridor": "Walls and floor are the same with both; at the rims of ball and cone, where a block sees two "
            "depths, SSD decides for the one with the stronger contrast.",
        },
    ),
    (
        "block-and-width",
        "Block length and search width",
        ["sweep", *BM, "--block", "5,9,15,21", "--disp", "{widths}"],
        {
            "motorcycle": "Down the rows noise disappears and detail with it, the cables first; in the left column the "
            "search is too narrow for the machine and the ground before it, which the tests then remove; a search "
            "wider than the scene costs time and a strip at the left border, and adds nothing.",
            "corridor": "With 24 disparities only the end of the corridor is found and everything nearer is noise or "
            "black; from 48 on the whole depth is there.",
        },
    ),
    (
        "prefilter",
        "Sobel against the normalised prefilter",
        ["sweep", *BM, "--disp", "{disp}", "--prefilter", "none,xsobel,sobel,normalized"],
        {
            "motorcycle": "Without a prefilter the difference in brightness between the two cameras leaves holes in the "
            "wall; a derivative does not see it, and the normalised response, which subtracts the local mean, is about "
            "as good as the horizontal derivative; the gradient magnitude has lost the sign of an edge.",
            "corridor": "Both images have the same brightness here, so all four agree on the walls; they differ in how "
            "far the ball's rim reaches out.",
        },
    ),
    (
        "lr-check",
        "Before and after the left-right check",
        ["sweep", *BM, "--disp", "{disp}", "--uniqueness", "off", "--speckle-window", "off", "--lr-check", "off,1"],
        {
            "motorcycle": "The check removes what only the left camera sees, the dark bands to the left of the wheels "
            "and of the tank, and the left border.",
            "corridor": "The shadows to the left of cone and ball are the parts of the wall that they hide from the "
            "right camera.",
        },
    ),
    (
        "uniqueness",
        "Uniqueness ratios",
        ["sweep", *BM, "--disp", "{disp}", "--lr-check", "off", "--speckle-window", "off"]
        + ["--uniqueness", "off,5,15,30,60"],
        {
            "motorcycle": "The higher the ratio, the more goes of what has a second disparity as good as the first: "
            "smooth metal, the repeated slats of the bench, and in the end nearly everything but strong texture.",
            "corridor": "Brick and marble repeat little, so that the map lasts longer; the ball's stripes, which look "
            "alike along a row, go first.",
        },
    ),
    (
        "filters",
        "Before and after all filters",
        ["compare", *CLASSIC, "--disp", "{disp}"]
        + ["--variants", OFF, "classic", "classic+fill=rays+weighted-median=5"],
        {
            "motorcycle": "First the bare winners; then the uniqueness test, the left-right check, the speckle filter "
            "and the median, which leave holes where nothing can be trusted; then the holes filled from what lies "
            "behind, and edges drawn to those of the image.",
            "corridor": "The wrong matches beside ball and cone become holes, and the holes the wall behind them.",
        },
    ),
    (
        "methods",
        "Block matching, semi-global matching, and WLS",
        ["compare", *CLASSIC, "--disp", "{disp}", "--variants", "bm", "sgm", "sgm+wls"],
        {
            "motorcycle": "Semi-global matching keeps cables and spokes that a block of 15 pixels smears, and closes "
            "smooth surfaces; WLS then fills every hole smoothly and stops at the edges of the image.",
            "corridor": "The cone's tip and the rim of the ball are sharp with semi-global matching, and WLS leaves no "
            "hole, right or wrong.",
        },
    ),
]


def study(program, pair, section, picture, tile_width):
    """Runs a study; its command line as a reader would type it, and what it found."""
    folder, left, right, disp, widths = pair
    kind, *options = (part.format(disp=disp, widths=widths) for part in section[2])
    line = ["gpu-stereo", kind, f"{folder}/{left}", f"{folder}/{right}", *options]
    more = ["-o", str(picture), "--repeat", "3", "--json", *tile_width]
    done = subprocess.run([program, *line[1:], *more], cwd=ROOT, stdout=subprocess.PIPE, check=True)
    return " ".join(line), json.loads(done.stdout)


def cost_table(found):
    """Times of the first section: a row for each block, a column for each cost."""
    times = {(v["settings"]["block"], v["settings"]["cost"]): v["frame_ms"]["median"] for v in found["variants"]}
    blocks, costs = (list(dict.fromkeys(key[i] for key in times)) for i in (0, 1))
    rows = [["block", *(f"`{cost}`, ms" for cost in costs)], ["---"] * (1 + len(costs))]
    rows += [[block, *(f"{times[block, cost]:.1f}" for cost in costs)] for block in blocks]
    where = f"{found['width']} x {found['height']} pixels, {found['variants'][0]['disparities']} disparities"
    return [f"Whole frames on {found['adapter']}, {where}:", "", *("| " + " | ".join(row) + " |" for row in rows), ""]


def wrapped(text, width=120):
    lines = [""]
    for word in text.split():
        if lines[-1] and len(lines[-1]) + 1 + len(word) > width:
            lines.append("")
        lines[-1] += (" " if lines[-1] else "") + word
    return lines


def main():
    if len(sys.argv) > 1:
        program = str(pathlib.Path(sys.argv[1]).resolve())
    else:
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
        target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
        program = str(ROOT / target / "release" / "gpu-stereo")
    PICTURES.mkdir(parents=True, exist_ok=True)
    for old in PICTURES.glob("*.jpg"):
        old.unlink()
    page = ["# Gallery", ""]
    page += wrapped(
        "What the settings do, on the pairs of [data](../data/README.md): motorcycle, a photograph, and corridor, "
        "rendered. Colours go from the smallest disparity searched, blue, to the largest, red; black is no disparity. "
        "Made, with this page, by `python3 docs/gallery.py`."
    )
    page.append("")
    for section in SECTIONS:
        name, title, _, see = section
        page += [f"## {title}", ""]
        for pair, files in OWN.items():
            picture = PICTURES / f"{name}-{pair}.jpg"
            line, found = study(program, files, section, picture, ["--tile-width", "200"])
            if pair == "motorcycle" and name == "costs":
                page += cost_table(found)
            link = f"![{title}: {pair}]({picture.relative_to(ROOT / 'docs').as_posix()})"
            page += [f"    {line}", "", *wrapped(see[pair]), "", link, ""]
    (ROOT / "docs" / "GALLERY.md").write_text("\n".join(page), encoding="utf-8")
    size = sum(picture.stat().st_size for picture in PICTURES.iterdir())
    print(f"docs/GALLERY.md, and {size / 1e6:.2f} MB of pictures in {PICTURES.relative_to(ROOT)}")

    beside = ROOT / "target" / "gallery"
    for pair, files in BESIDE.items():
        if not files[0].is_dir():
            print(f"{files[0]} is not there; no sheets of {pair}")
            continue
        beside.mkdir(parents=True, exist_ok=True)
        for section in SECTIONS:
            study(program, files, section, beside / f"{section[0]}-{pair}.png", [])
        print(f"sheets of {pair} in {beside.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
