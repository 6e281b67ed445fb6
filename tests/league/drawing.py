"""Pictures of the report as SVG: error profiles, signed maps, errors against effort. Colours are the page's own."""
import math
from html import escape

WIDE, LEFT, RIGHT = 640, 64, 12


def nice(lo, hi, count=4):
    """Round numbers between two, some four of them."""
    span = hi - lo or 1.0
    step = 10 ** math.floor(math.log10(span / count))
    step *= next((m for m in (1, 2, 5, 10) if span / (m * step) <= count + 1), 10)
    return [round(k * step, 12) for k in range(math.ceil(lo / step - 1e-9), math.floor(hi / step + 1e-9) + 1)]


class Panel:
    """A frame with axes; the y axis may be logarithmic."""

    def __init__(self, top, height, x, y, logarithmic=False, label="", unit=""):
        self.top, self.height, self.x, self.y, self.log = top, height, x, y, logarithmic
        self.parts = [f'<text class="label" x="{LEFT}" y="{top - 8}">{escape(label)}</text>']
        if logarithmic:
            low, high = math.floor(math.log10(y[0])), math.ceil(math.log10(y[1]))
            self.y = (10.0**low, 10.0**high)
            ticks = [10.0**k for k in range(low, high + 1)]
        else:
            ticks = nice(*y)
        for t in ticks:
            at = self.py(t)
            said = f"1e{round(math.log10(t))}" if logarithmic else f"{t:g}"
            self.parts.append(f'<line class="grid" x1="{LEFT}" x2="{WIDE - RIGHT}" y1="{at:.1f}" y2="{at:.1f}"/>'
                              f'<text class="tick" x="{LEFT - 6}" y="{at + 4:.1f}" text-anchor="end">{said}{unit}</text>')

    def px(self, x):
        return LEFT + (x - self.x[0]) / (self.x[1] - self.x[0]) * (WIDE - LEFT - RIGHT)

    def py(self, y):
        if self.log:
            share = (math.log10(max(y, self.y[0])) - math.log10(self.y[0])) / (math.log10(self.y[1]) - math.log10(self.y[0]))
        else:
            share = (y - self.y[0]) / ((self.y[1] - self.y[0]) or 1)
        return self.top + self.height * (1 - share)

    def under(self, words, ticks=None, said="{:g}".format):
        base = self.top + self.height
        for t in ticks if ticks is not None else nice(*self.x, 6):
            self.parts.append(f'<text class="tick" x="{self.px(t):.1f}" y="{base + 16}" text-anchor="middle">{said(t)}</text>')
        self.parts.append(f'<text class="tick" x="{(LEFT + WIDE - RIGHT) / 2}" y="{base + 33}" text-anchor="middle">{escape(words)}</text>')

    def line(self, xs, ys, kind):
        path = " ".join(f"{self.px(x):.1f},{self.py(y):.1f}" for x, y in zip(xs, ys))
        self.parts.append(f'<polyline class="{kind}" points="{path}"/>')

    def dots(self, xs, ys, errors=None):
        for i, (x, y) in enumerate(zip(xs, ys)):
            if errors is not None and errors[i] > 0:
                self.parts.append(f'<line class="bar" x1="{self.px(x):.1f}" x2="{self.px(x):.1f}" y1="{self.py(y - 2 * errors[i]):.1f}" '
                                  f'y2="{self.py(y + 2 * errors[i]):.1f}"/>')
            self.parts.append(f'<circle class="dot" cx="{self.px(x):.1f}" cy="{self.py(y):.1f}" r="3"/>')


def svg(height, parts, title):
    return (f'<svg class="plot" viewBox="0 0 {WIDE} {height}" role="img" aria-label="{escape(title)}"><title>{escape(title)}</title>'
            + "".join(parts) + "</svg>")


def profile(x, exact, mean, error, predicted, title, along="along the line of points, m", peak=None):
    """Irradiance above, deviation in per cent of the brightest point below, and what was predicted of it."""
    peak = peak or max(exact)
    deviation = [100 * (m - e) / peak for m, e in zip(mean, exact)]
    bars = [100 * s / peak for s in error]
    curves = [[100 * (p - e) / peak for p, e in zip(values, exact)] for _, values in predicted]
    low = min([0, *(d - 2 * b for d, b in zip(deviation, bars)), *(v for c in curves for v in c)])
    high = max([0, *(d + 2 * b for d, b in zip(deviation, bars)), *(v for c in curves for v in c)])
    margin = 0.08 * ((high - low) or 1)
    span = (min(x), max(x))
    above = Panel(26, 130, span, (0, 1.05), label="irradiance, of the brightest: exact (line) and measured (dots)")
    above.line(x, [e / peak for e in exact], "exact")
    above.dots(x, [m / peak for m in mean])
    words = "deviation in % of the brightest, with two standard errors" + (": dots measured, dashes predicted" if predicted else "")
    below = Panel(196, 150, span, (low - margin, high + margin), label=words)
    below.line(span, (0, 0), "exact")
    for curve in curves:
        below.line(x, curve, "predicted")
    below.dots(x, deviation, bars)
    below.under(along)
    return svg(396, above.parts + below.parts, title)


def convergence(series, title):
    """Errors against effort, both logarithmic: [(name, [(effort, error)...])]."""
    points = [p for _, s in series for p in s]
    xs = [math.log10(p[0]) for p in points]
    ys = [max(p[1], 1e-7) for p in points]
    panel = Panel(26, 220, (min(xs) - 0.1, max(xs) + 0.1), (min(ys), max(ys)), logarithmic=True, label="error, of the brightest point / of the mean")
    for k, (name, values) in enumerate(series):
        here = [math.log10(p[0]) for p in values]
        panel.line(here, [max(p[1], 1e-7) for p in values], f"series s{k}")
        panel.dots(here, [max(p[1], 1e-7) for p in values])
        panel.parts.append(f'<text class="tick" x="{panel.px(here[-1]) - 6:.1f}" y="{panel.py(max(values[-1][1], 1e-7)) - 14:.1f}" '
                           f'text-anchor="end">{escape(name)}</text>')
    panel.under("samples on the light", ticks=sorted({round(x, 6) for x in xs}), said=lambda x: f"{round(10**x):,}")
    return svg(300, panel.parts, title)


def signed_map(columns, rows, deviation, z, title):
    """Deviation of each pixel in per cent of the exact value, coloured by sign and size in standard errors."""
    cell = min(60, (WIDE - 20) // columns)
    parts = []
    for i, (d, score) in enumerate(zip(deviation, z)):
        x, y = 10 + i % columns * cell, 10 + i // columns * cell
        kind = "none" if d is None else "plus" if d > 0 else "minus"
        strength = 0 if score is None else min(0.85, abs(score) / 12)
        parts.append(f'<rect class="cell {kind}" style="fill-opacity:{strength:.2f}" x="{x}" y="{y}" width="{cell - 2}" height="{cell - 2}"/>')
        said = "0" if d is None else f"{d:+.2f}" if abs(d) < 10 else f"{d:+.0f}"
        value = "value strong" if strength > 0.5 else "value"
        parts.append(f'<text class="{value}" x="{x + cell / 2 - 1}" y="{y + cell / 2 + 4}" text-anchor="middle">{said}</text>')
    height = rows * cell + 34
    parts.append(f'<text class="tick" x="10" y="{height - 8}">mean over images against the exact pixel average, %; colour: 12 standard errors and more is full</text>')
    return svg(height, parts, title)
