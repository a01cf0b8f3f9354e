"""How much the true disparities of neighbours differ: the table and the chart of docs/GALLERY.md. Needs Python 3.8 alone."""

import math
import pathlib

from pixels import read_truth

ROOT = pathlib.Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared" / "data"
# Name, truth, and what of it stands for 1 px.
TRUTHS = [
    ("Tsukuba", SHARED / "middlebury2001/tsukuba/disp_left.png", 16),
    ("Venus", SHARED / "middlebury2001/venus/disp_left.png", 8),
    ("Teddy", SHARED / "middlebury2003/teddy/disp_left.png", 4),
    ("Cones", SHARED / "middlebury2003/cones/disp_left.png", 4),
    ("Art", SHARED / "middlebury2005_full/art/disp_left.png", 1),
    ("Motorcycle", ROOT / "data/motorcycle/disp_left.pfm", 1),
    ("corridor", ROOT / "data/corridor/disp_left.pfm", 1),
]
MOST = 40
BINS = [(0, 0), (1, 1), (2, 2), (3, 3), (4, 4), (5, 5), (6, 9), (10, 19), (20, None)]


def shares(truth):
    """The share of each |dx| in whole px, nearest, among neighbours in a row that both have a truth."""
    counts = {}
    for row in truth:
        for a, b in zip(row, row[1:]):
            if a is not None and b is not None:
                step = math.floor(abs(b - a) + 0.5)
                counts[step] = counts.get(step, 0) + 1
    total = sum(counts.values())
    return {step: count / total for step, count in counts.items()}


def measured():
    """Name and shares of each truth that is there."""
    return [(name, shares(read_truth(path, scale))) for name, path, scale in TRUTHS if path.is_file()]


def mean(found):
    steps = {step for _, of in found for step in of}
    return {step: sum(of.get(step, 0) for _, of in found) / len(found) for step in steps}


def table(found):
    title = [f"{a}" if a == b else f"{a} to {b}" if b else f"{a} and more" for a, b in BINS]
    lines = ["| \\|dx\\|, px | " + " | ".join(title) + " |", "|---" * (len(BINS) + 1) + "|"]
    for name, of in [*found, ("mean", mean(found))]:
        parts = [sum(share for step, share in of.items() if a <= step <= (b if b is not None else step)) for a, b in BINS]
        lines.append(f"| {name} | " + " | ".join(f"{100 * part:.2f}" for part in parts) + " |")
    return lines


def fitted(of):
    """Slope and truncation of the truncated line that comes nearest to -ln(share / share of 0), and the square of its distance;
    the same of a line without truncation."""
    known = [(k, math.log(of[0] / of[k])) for k in range(MOST + 1) if of.get(k)]

    def line(truncation):
        # The best slope of min(slope k, slope t) is that of least squares over min(k, t).
        reach = [(min(k, truncation), value) for k, value in known]
        slope = sum(a * b for a, b in reach) / sum(a * a for a, _ in reach)
        return sum((slope * a - b) ** 2 for a, b in reach), slope, truncation

    return min(line(t / 10) for t in range(1, 10 * MOST)), line(MOST)


def chart(found, path):
    """-ln of the share over |dx|: thin lines of the truths, a thick one of their mean, and what fits it."""
    width, height, left, bottom, top = 640, 330, 56, 286, 14
    x = lambda k: left + k * (width - left - 16) / MOST
    y = lambda value: bottom - value * (bottom - top) / 14
    curve = lambda of: [(k, -math.log(of[k])) for k in range(MOST + 1) if of.get(k)]
    path_of = lambda points: " ".join(f"{x(k):.1f},{y(value):.1f}" for k, value in points)
    middle = mean(found)
    (_, slope, truncation), (_, straight, _) = fitted(middle)
    base = -math.log(middle[0])
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">',
             f'<rect width="{width}" height="{height}" fill="white"/>']
    for value in range(0, 15, 2):
        lines.append(f'<line x1="{left}" y1="{y(value):.1f}" x2="{width - 16}" y2="{y(value):.1f}" stroke="#ddd"/>'
                     f'<text x="{left - 8}" y="{y(value) + 4:.1f}" text-anchor="end">{value}</text>')
    for k in range(0, MOST + 1, 5):
        lines.append(f'<text x="{x(k):.1f}" y="{bottom + 18}" text-anchor="middle">{k}</text>')
    lines.append(f'<text x="{(left + width) / 2:.0f}" y="{height - 8}" text-anchor="middle">|dx|, difference of two neighbours '
                 'in a row, px</text>'
                 f'<text x="16" y="{(top + bottom) / 2:.0f}" text-anchor="middle" '
                 f'transform="rotate(-90 16 {(top + bottom) / 2:.0f})">-ln of its share</text>')
    for _, of in found:
        lines.append(f'<polyline points="{path_of(curve(of))}" fill="none" stroke="#bbb"/>')
    ideal = [(k / 10, base + slope * min(k / 10, truncation)) for k in range(10 * MOST + 1)]
    plain = [(k, base + straight * k) for k in range(MOST + 1)]
    for points, colour, dash, thick in (
        (plain, "#0072b2", "6 4", 2), (ideal, "#d55e00", "", 2), (curve(middle), "black", "", 2.5),
    ):
        lines.append(f'<polyline points="{path_of([p for p in points if p[1] <= 14])}" fill="none" stroke="{colour}" '
                     f'stroke-width="{thick}" stroke-dasharray="{dash}"/>')
    for i, (colour, text) in enumerate((
        ("black", "mean of the truths (gray: each)"),
        ("#d55e00", f"min({slope:.2f} |dx|, {slope * truncation:.2f}): truncated at {truncation:.1f} px"),
        ("#0072b2", f"{straight:.2f} |dx|: not truncated"),
    )):
        lines.append(f'<text x="{left + 250}" y="{bottom - 52 + 16 * i}" fill="{colour}">{text}</text>')
    path.write_text("\n".join(lines) + "\n</svg>\n", encoding="utf-8")
    return slope, truncation
