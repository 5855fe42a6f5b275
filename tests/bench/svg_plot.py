# SPDX-License-Identifier: Apache-2.0
"""Small line plots as one SVG, of the standard library alone: panels with axes, ticks, labels, legends."""
from xml.sax.saxutils import escape

WIDTH, HEIGHT, COLUMNS = 400, 300, 2  # of one panel; panels of one row
LEFT, RIGHT, TOP, BOTTOM = 58, 16, 44, 50  # from a panel's edge to its axes
COLOURS = ["#1b6ca8", "#c1440e", "#3b7d3a"]


def step_of(top):
    """A round step (1, 2 or 5 times a power of ten) that makes four to ten ticks up to TOP."""
    step = 10.0 ** -6
    while True:
        for factor in (1, 2, 5):
            if top / (step * factor) <= 7:
                return step * factor
        step *= 10


def text(x, y, words, more=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" {more}>{escape(words)}</text>'


class Scale:
    """From a panel's values to its pixels. Both axes begin at 0: what looks twice as long takes twice as long."""

    def __init__(self, panel):
        points = [point for series in panel["series"] for point in series["points"]]
        self.x_top = max(x for x, _ in points) * 1.05
        self.y_top = max(y for _, y in points) * 1.15

    def x(self, value):
        return LEFT + value / self.x_top * (WIDTH - LEFT - RIGHT)

    def y(self, value):
        return HEIGHT - BOTTOM - value / self.y_top * (HEIGHT - TOP - BOTTOM)


def axes(panel, scale):
    left, right, bottom, top = LEFT, WIDTH - RIGHT, HEIGHT - BOTTOM, TOP
    yield f'<path d="M{left} {top}V{bottom}H{right}" stroke="#333" fill="none"/>'
    for value in sorted({x for series in panel["series"] for x, _ in series["points"]}):
        yield f'<path d="M{scale.x(value):.1f} {bottom}v4" stroke="#333"/>'
        yield text(scale.x(value), bottom + 17, f"{value:g}", 'text-anchor="middle"')
    step, i = step_of(scale.y_top), 0
    while i * step <= scale.y_top:
        y = scale.y(i * step)
        yield f'<path d="M{left} {y:.1f}H{right}" stroke="#e4e4e4"/>' if i else ""
        yield text(left - 6, y + 4, f"{i * step:g}", 'text-anchor="end"')
        i += 1
    yield text((left + right) / 2, bottom + 38, panel["x"], 'text-anchor="middle"')
    middle = (top + bottom) / 2
    yield text(14, middle, panel["y"], f'text-anchor="middle" transform="rotate(-90 14 {middle:.1f})"')
    yield text(left, 18, panel["title"], 'font-size="11"')


def lines(panel, scale):
    for i, series in enumerate(panel["series"]):
        colour, dash = COLOURS[i % len(COLOURS)], 'stroke-dasharray="5 3" ' if series.get("dashed") else ""
        places = [(scale.x(x), scale.y(y)) for x, y in series["points"]]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        yield f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6" {dash}/>'
        for x, y in places:
            yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="{colour}"/>'
        at = LEFT + 8 + i * 70
        yield f'<path d="M{at} {TOP - 12}h18" stroke="{colour}" stroke-width="1.6" {dash}/>'
        yield text(at + 22, TOP - 8, series["name"], f'font-size="11" fill="{colour}"')


def write(path, title, panels):
    """panels: title, x and y (labels), series: name, points ((x, y), ...), dashed."""
    rows = (len(panels) + COLUMNS - 1) // COLUMNS
    width, height = WIDTH * COLUMNS, HEIGHT * rows + 34
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
             f'font-family="sans-serif" font-size="12" fill="#222">',
             f'<rect width="{width}" height="{height}" fill="#fff"/>', text(LEFT, 22, title, 'font-size="14"')]
    for i, panel in enumerate(panels):
        scale = Scale(panel)
        parts.append(f'<g transform="translate({i % COLUMNS * WIDTH} {i // COLUMNS * HEIGHT + 34})">')
        parts += [part for part in axes(panel, scale) if part]
        parts += lines(panel, scale)
        parts.append("</g>")
    with open(path, "w", encoding="utf-8") as f:
        f.write("\n".join(parts + ["</svg>\n"]))
