"""Cost against accuracy as a picture: a panel a mean, time on the logarithmic x axis, D1-all on the y axis; SVG."""

import html
import math

WIDTH, HEIGHT = 540, 400  # a panel
LEFT, RIGHT, TOP, BOTTOM = 52, 96, 44, 48
INK, QUIET, RULE, OURS = "#1c2833", "#5d6d7e", "#e3e7ea", "#1f6fb2"
STYLE = (
    f"text{{font:12px sans-serif;fill:{INK}}} .quiet{{fill:{QUIET}}} .title{{font-size:14px;font-weight:600}} "
    f".rule{{stroke:{RULE}}} .axis{{stroke:{QUIET}}}"
)


def decades(low, high):
    """The ticks 1, 2 and 5 of each decade from `low` to `high`."""
    exponents = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks = [digit * 10**exponent for exponent in exponents for digit in (1, 2, 5)]
    return [tick for tick in ticks if low <= tick <= high]


def text(x, y, words, anchor="start", kind="", turn=""):
    named = f' class="{kind}"' if kind else ""
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"{named}{turn}>{html.escape(words)}</text>'


def labels(points):
    """Where the name of each point stands, (x, y, anchor), so that no two lines of text cover each other."""
    taken, placed = [], []
    for x, y, name, _ in sorted(points):
        length = 6.4 * len(name)
        places = [(x + 8, y + 4, "start"), (x - 8, y + 4, "end"), (x, y - 9, "middle"), (x, y + 18, "middle"),
                  (x + 6, y - 9, "start"), (x + 6, y + 18, "start"), (x - 6, y + 18, "end"), (x - 6, y - 9, "end")]
        for u, v, anchor in places:
            start = u - {"start": 0, "middle": length / 2, "end": length}[anchor]
            box = (start, v - 11, start + length, v + 3)
            dots = [(p - 5, q - 5, p + 5, q + 5) for p, q, *_ in points if (p, q) != (x, y)]
            if box[0] > LEFT and all(box[2] < b[0] or b[2] < box[0] or box[3] < b[1] or b[3] < box[1] for b in taken + dots):
                break
        taken.append(box)
        placed.append((u, v, anchor, name))
    return placed


def panel(title, rows, peers):
    """One mean: `rows` of setting, ms and D1-all."""
    times, errors = [row["ms"] for row in rows], [row["d1_all"] for row in rows]
    low, high = min(times) / 3, max(times) * 1.4
    top = 1.12 * max(errors)
    inner, tall = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM

    def x_of(ms):
        return LEFT + inner * math.log(ms / low) / math.log(high / low)

    def y_of(error):
        return TOP + tall * (1 - error / top)

    parts = [text(LEFT, 22, title, kind="title")]
    step = next(step for step in (0.5, 1, 2, 5, 10, 20) if top / step <= 8)
    for i in range(int(top / step) + 1):
        y = y_of(i * step)
        parts.append(f'<line class="{"rule" if i else "axis"}" x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
        parts.append(text(LEFT - 8, y + 4, f"{i * step:g}", "end", "quiet"))
    for tick in decades(low, high):
        parts.append(text(x_of(tick), HEIGHT - BOTTOM + 18, f"{tick:g}", "middle", "quiet"))
    parts.append(text(LEFT + inner / 2, HEIGHT - 10, "ms a frame", "middle", "quiet"))
    middle = TOP + tall / 2
    parts.append(text(16, middle, "D1-all, %", "middle", "quiet", f' transform="rotate(-90 16 {middle:.1f})"'))
    points = [(x_of(row["ms"]), y_of(row["d1_all"]), row["setting"], row["setting"] in peers) for row in rows]
    for x, y, _, peer in points:
        paint = f'fill="white" stroke="{QUIET}" stroke-width="2"' if peer else f'fill="{OURS}"'
        parts.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" {paint}/>')
    parts += [text(u, v, name, anchor) for u, v, anchor, name in labels(points)]
    return "\n".join(parts)


def picture(means, peers):
    """The SVG of `means`, rows of mean, setting, ms and d1_all; the settings of `peers` are drawn as rings."""
    names = list(dict.fromkeys(row["mean"] for row in means))
    panels = [panel(f"mean of {name}", [row for row in means if row["mean"] == name], peers) for name in names]
    moved = [f'<g transform="translate({i * WIDTH} 0)">\n{drawn}\n</g>' for i, drawn in enumerate(panels)]
    whole = WIDTH * len(panels)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {whole} {HEIGHT}" width="{whole}" height="{HEIGHT}">'
    return "\n".join([head, f"<style>{STYLE}</style>", '<rect width="100%" height="100%" fill="white"/>', *moved, "</svg>", ""])
