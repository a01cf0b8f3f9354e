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
            "motorcycle": "The two hardly differ. Squares give the largest differences in a block more weight, so that SSD "
            "leaves fewer holes with a small block and thicker black outlines with a large one, where a block "
            "sees two depths.",
            "corridor": "In a rendering without noise the two agree almost everywhere; the holes in the side walls, where a "
            "block is too small, are slightly fewer with SSD.",
        },
    ),
    (
        "block-and-width",
        "Block length and search width",
        ["sweep", *BM, "--block", "5,9,15,21", "--disp", "{widths}"],
        {
            "motorcycle": "Down the rows noise disappears and detail with it; at 21 the ground, which no single disparity of so "
            "large a block fits, breaks up again. In the left column the search is too narrow for the machine and "
            "the ground before it, which the tests then remove. The right column searches further than the scene "
            "reaches: it costs time and adds nothing.",
            "corridor": "With 24 disparities all that is nearer than the middle of the corridor is missing, 48 hold the whole "
            "scene, and 72 only take longer. With a block of 21 the slanted walls break up, but not the end of "
            "the corridor, which faces the camera.",
        },
    ),
    (
        "prefilter",
        "Sobel against the normalised prefilter",
        ["sweep", *BM, "--disp", "{disp}", "--prefilter", "none,xsobel,sobel,normalized"],
        {
            "motorcycle": "On plain gray values the smooth ground is lost, where the left photograph is two to four levels "
            "brighter than the right one. A derivative does not see that, nor does the normalised response, from "
            "which the local mean is subtracted. The gradient magnitude, which does not tell a rising edge from a "
            "falling one, leaves more holes in the machine.",
            "corridor": "Both renderings have the same brightness, so plain gray values do well, as does the normalised "
            "response; the gradient magnitude leaves holes in all walls.",
        },
    ),
    (
        "lr-check",
        "Before and after the left-right check",
        ["sweep", *BM, "--disp", "{disp}", "--uniqueness", "off", "--speckle-window", "off", "--lr-check", "off,1"],
        {
            "motorcycle": "The check turns black what only the left camera sees: the left border, and the wrong patches to the "
            "left of handlebar, engine and wheels.",
            "corridor": "To the left of sphere, ball and cone lies the wall that they hide from the right camera: wrong "
            "patches before, black after the check.",
        },
    ),
    (
        "uniqueness",
        "Uniqueness ratios",
        ["sweep", *BM, "--disp", "{disp}", "--lr-check", "off", "--speckle-window", "off"]
        + ["--uniqueness", "off,5,15,30,60"],
        {
            "motorcycle": "A higher ratio removes first the wrong patches around the handlebar, then outlines, then the ground; "
            "at 60 % only strong texture is left.",
            "corridor": "The slanted walls go before sphere, cone and the end of the corridor: where no single disparity fits "
            "a block well, its best cost is not far ahead of the others.",
        },
    ),
    (
        "filters",
        "Before and after all filters",
        ["compare", *CLASSIC, "--disp", "{disp}"]
        + ["--variants", OFF, "classic", "classic+fill=rays+weighted-median=5"],
        {
            "motorcycle": "First the bare winners, with wrong patches left of the machine; then, after uniqueness test, "
            "left-right check, speckle filter and median, holes in their place; then the holes filled from what "
            "lies behind, and the borders of objects drawn to those of the image.",
            "corridor": "The wrong patches beside sphere, ball and cone become holes, and the holes become wall.",
        },
    ),
    (
        "methods",
        "Block matching, semi-global matching, and WLS",
        ["compare", *CLASSIC, "--disp", "{disp}", "--variants", "bm", "sgm", "sgm+wls-lambda=8000"],
        {
            "motorcycle": "Semi-global matching leaves fewer holes than block matching, and thinner ones; WLS fills nearly all of them, "
            "smoothly, up to the edges of the image. It is for the eye: at OpenCV's usual strength, 8000, the even ground falls into "
            "plateaus, and thin objects pale.",
            "corridor": "The rims of sphere and ball are frayed with block matching and sharp with semi-global matching; WLS "
            "fills the hidden strips beside them, right or wrong.",
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
            line, found = study(program, files, section, picture, ["--tile-width", "192"])
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
