#!/usr/bin/env python3
"""Makes GALLERY.md and its pictures, from a clean checkout, in a few minutes after the build:

    python3 docs/gallery.py [PROGRAM] [--only SECTION,..]

PROGRAM is the built command; without it, cargo builds a release. With --only the other sections of the page and their pictures
stay as they are. Needs Python 3.8 alone. Of the pairs that lie beside the project in ../shared/data, where they do, the same
sheets are written to target/gallery: their terms are not known. The derivatives are of the truths that lie there, too.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "images"))
import derivatives
import pixels
import scene_of_failures

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
        "Block matching, semi-global matching, belief propagation, and WLS",
        ["compare", *CLASSIC, "--disp", "{disp}", "--variants", "bm", "sgm", "bp", "sgm+wls-lambda=8000"],
        {
            "motorcycle": "Semi-global matching leaves fewer holes than block matching, and thinner ones. Belief propagation, which "
            "weighs all neighbours of a pixel at once, leaves as many and takes many times as long: the cost is the same, and holes "
            "are mostly what one camera alone sees. WLS fills nearly all of them, "
            "smoothly, up to the edges of the image. It is for the eye: at OpenCV's usual strength, 8000, the even ground falls into "
            "plateaus, and thin objects pale.",
            "corridor": "The rims of sphere and ball are frayed with block matching and sharp with the two others; WLS "
            "fills the hidden strips beside them, right or wrong.",
            "report": "Of the two pairs of the report, corridor and triclops, the same sheets lie in target/gallery. The ceiling and the "
            "walls of its corridor have no texture: block matching leaves holes and wrong patches there, semi-global matching has "
            "streaks along its paths, belief propagation patches of equal disparity, and only WLS, which follows the edges "
            "of the image, looks like a corridor. In triclops the paved way is empty with block matching, frayed with semi-global "
            "matching and closed with belief propagation, but for false patches at the right border. (The times in these four sheets "
            "were taken while the machine had other work, about twice those of an idle one.)",
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


# What fails: the scene, the crop (x, y, width, height), the title, and what to see.
FAILURES = [
    ("textureless", "made", (20, 16, 104, 76), "Without texture", (
        "On the gray plate every disparity costs the same, but for noise. Block matching follows the noise. Along the paths of "
        "semi-global matching the wall's disparity goes on into the plate. Belief propagation carries the plate's outline inwards "
        "and finds nearly all of it, in two steps, and WLS takes a mean of plate and wall, which is neither."
    )),
    ("repetitive", "made", (132, 16, 104, 76), "Repetitive texture", (
        "The stripes come again every 8 px, so they match at the wall's 6 px as well as at their own 30. The smoothness prefers the "
        "wall: semi-global matching and belief propagation see stripes painted on it, and of the plate only the ends, where the "
        "pattern stops, belief propagation the right one a period too near; block matching takes now one period, now another."
    )),
    ("occluded", "motorcycle", (92, 206, 104, 76), "Occluded", (
        "The floor to the left of the rear wheel is hidden from the right camera by the wheel. It has no match there, and whatever "
        "resembles it wins: patches of any disparity, in smaller pieces or larger ones by the method. The left-right check removes them."
    )),
    ("specular", "motorcycle", (576, 250, 104, 76), "Specular", (
        "The reflection of a lamp on the front fender lies at another place of the metal for each camera. It matches well, at a disparity of "
        "its own: a dent in every map. The tests remove it from that of block matching, and a part of it from those of semi-global "
        "matching and belief propagation. WLS smooths it away."
    )),
]
COLUMNS = [("bm", ["--method", "bm"]), ("sgm", []), ("bp", ["--method", "bp"]), ("wls", ["--wls-lambda", "8000"])]
UNTESTED = "--uniqueness off --lr-check off --speckle-window off --median off".split()


def failures(program):
    """The section of failures: of each a strip of crops, of the left image, the truth and what the methods make of it."""
    work = ROOT / "target" / "gallery"
    work.mkdir(parents=True, exist_ok=True)
    scene_of_failures.write(work)
    scenes = {"made": (work, 48), "motorcycle": (ROOT / "data" / "motorcycle", 64)}
    strips = {}
    for scene, (folder, disp) in scenes.items():
        pair = [str(folder / f"{side}.png") for side in ("left", "right")]
        truth = pixels.coloured(pixels.read_pfm(folder / "disp_left.pfm"), disp - 1)
        strips[scene] = [pixels.read_png(pair[0]), truth]
        for name, options in COLUMNS:
            color = work / f"failures-{scene}-{name}.png"
            line = [program, *pair, *CLASSIC, *UNTESTED, "--disp", str(disp), *options, "--color", str(color), "--quiet"]
            subprocess.run(line, check=True)
            strips[scene].append(pixels.read_png(color))
    strips = {scene: [grayed(picture) for picture in pictures] for scene, pictures in strips.items()}
    page = wrapped(
        "What a pair does not show, no method can see; it can only guess. From the left: the left image, the truth (black: unknown), "
        "block matching, semi-global matching, belief propagation, and semi-global matching with WLS; all as `classic`, without the "
        "tests and the median, which would remove most of what is wrong here. The first two crops are of a scene that "
        "images/scene_of_failures.py makes, the others of motorcycle."
    )
    page.append("")
    for name, scene, crop, title, see in FAILURES:
        picture = PICTURES / f"failures-{name}.png"
        pixels.write_png(picture, pixels.beside([pixels.crop(rows, *crop, 2) for rows in strips[scene]]))
        page += [*wrapped(f"**{title}.** {see}"), "", f"![{title}]({picture.relative_to(ROOT / 'docs').as_posix()})", ""]
    return page


def grayed(picture):
    """Three samples a pixel."""
    return [[pixel if len(pixel) == 3 else pixel[:1] * 3 for pixel in row] for row in picture]


def prior(_):
    """The section of the derivatives of true maps."""
    found = derivatives.measured()
    slope, truncation = derivatives.chart(found, PICTURES / "derivatives.svg")
    page = wrapped(
        "How much the true disparities of two neighbours in a row differ, to the nearest pixel, in per cent of all neighbours that both "
        "have a truth. (KITTI's truth has hardly any neighbours across an outline, so it is not here.)"
    )
    page += ["", *derivatives.table(found), ""]
    page += wrapped(
        "Nearly all neighbours have the same disparity, to the pixel. Of the other steps those of one pixel are the most frequent, but "
        "beyond a few pixels the shares fall slowly, and a step of 30 px is several times rarer than one of 10, not thousands of times: "
        "there the surface ends, and the next one may lie anywhere behind it. If "
        "disparities are a Markov random field, the smoothness of a step is the negative logarithm of its share, up to a factor. "
        f"Drawn below, it rises and then stays: the line that comes nearest to it is truncated at {truncation:.1f} px, while one without "
        "truncation makes outlines by far too dear and small steps too cheap. So the smoothness of `--method bp` is truncated, "
        "at 10 px (`--smoothness-weight 2`, `--smoothness-truncation 20`), and P2 of semi-global matching is a constant."
    )
    return [*page, "", "![The distribution of derivatives](images/gallery/derivatives.svg)", ""]


def studies(section):
    """What makes the section of a study of our pairs."""

    def make(program):
        name, title, _, see = section
        page = []
        for pair, files in OWN.items():
            picture = PICTURES / f"{name}-{pair}.jpg"
            line, found = study(program, files, section, picture, ["--tile-width", "192"])
            if pair == "motorcycle" and name == "costs":
                page += cost_table(found)
            link = f"![{title}: {pair}]({picture.relative_to(ROOT / 'docs').as_posix()})"
            page += [f"    {line}", "", *wrapped(see[pair]), "", link, ""]
        return page + ([*wrapped(see["report"]), ""] if "report" in see else [])

    return make


# Name, title, and what makes the text and the pictures.
PAGE = [(section[0], section[1], studies(section)) for section in SECTIONS]
PAGE += [("failures", "What fails", failures), ("prior", "Why the smoothness is truncated", prior)]


def kept():
    """The sections that the page has, by their titles."""
    path = ROOT / "docs" / "GALLERY.md"
    sections = path.read_text(encoding="utf-8").split("\n## ")[1:] if path.exists() else []
    return {title: text.strip("\n").split("\n") + [""] for title, _, text in (part.partition("\n") for part in sections)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?")
    parser.add_argument("--only", help="sections, with commas between them: " + ", ".join(name for name, *_ in PAGE))
    given = parser.parse_args()
    if given.program:
        program = str(pathlib.Path(given.program).resolve())
    else:
        subprocess.run(["cargo", "build", "--release", "--locked"], cwd=ROOT, check=True)
        target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", "target"))
        program = str(ROOT / target / "release" / "gpu-stereo")
    names = given.only.split(",") if given.only else [name for name, *_ in PAGE]
    PICTURES.mkdir(parents=True, exist_ok=True)
    before = kept()
    page = ["# Gallery", ""]
    page += wrapped(
        "What the settings do, on the pairs of [data](../data/README.md): motorcycle, a photograph, and corridor, "
        "rendered. Colours go from the smallest disparity searched, blue, to the largest, red; black is no disparity. "
        "Made, with this page, by `python3 docs/gallery.py`."
    )
    page.append("")
    for name, title, make in PAGE:
        if name not in names and title not in before:
            raise SystemExit(f"{name} is not among --only, and not on the page yet")
        page += [f"## {title}", "", *(make(program) if name in names else before[title])]
    (ROOT / "docs" / "GALLERY.md").write_text("\n".join(page), encoding="utf-8")
    size = sum(picture.stat().st_size for picture in PICTURES.iterdir())
    print(f"docs/GALLERY.md, and {size / 1e6:.2f} MB of pictures in {PICTURES.relative_to(ROOT)}")

    beside = ROOT / "target" / "gallery"
    for pair, files in BESIDE.items():
        if not files[0].is_dir():
            print(f"{files[0]} is not there; no sheets of {pair}")
            continue
        beside.mkdir(parents=True, exist_ok=True)
        for section in (section for section in SECTIONS if section[0] in names):
            study(program, files, section, beside / f"{section[0]}-{pair}.png", [])
        print(f"sheets of {pair} in {beside.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
