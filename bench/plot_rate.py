"""Draws rate-distortion curves as SVG: PSNR over bytes, these on a logarithmic scale."""

import math
from dataclasses import dataclass

from plot_memory import COLOURS, line, nice_step, text

WIDTH, PLOT_HEIGHT = 900, 400
LEFT, RIGHT, TOP, BOTTOM = 66, 218, 46, 52
PLOT_WIDTH = WIDTH - LEFT - RIGHT
HEIGHT = TOP + PLOT_HEIGHT + BOTTOM
TICKS = (1, 2, 5)
LABEL_HEIGHT = 15
FAINT = "#8fb6d3"
LIMIT_ROOM = 8  # dB above the curves up to which the limit is drawn; else it is only named


@dataclass
class Curve:
    label: str  # written at its end
    points: list  # (bytes, PSNR), by ascending bytes
    colour: str
    width: float = 1.8
    dots: bool = True


def bytes_text(count):
    return f"{count / 1000:g} kB" if count >= 1000 else f"{count:g} B"


def ticks_between(low, high):
    """1, 2 and 5 times the powers of ten between two numbers."""
    exponents = range(math.floor(math.log10(low)), math.floor(math.log10(high)) + 1)
    return [t * 10**e for e in exponents for t in TICKS if low <= t * 10**e <= high]


def spread(wanted, low, high):
    """Places for labels as near to the wanted ones as keeps them apart, in the same order; from low to high."""
    order = sorted(range(len(wanted)), key=lambda i: wanted[i])
    places, least = [0.0] * len(wanted), low
    for i in order:
        places[i] = max(wanted[i], least)
        least = places[i] + LABEL_HEIGHT
    most = high
    for i in reversed(order):
        places[i] = min(places[i], most)
        most = places[i] - LABEL_HEIGHT
    return places


class Scale:
    def __init__(self, curves, limit):
        all_bytes = [b for curve in curves for b, _ in curve.points]
        values = [v for curve in curves for _, v in curve.points]
        self.left, self.right = min(all_bytes) / 1.08, max(all_bytes) * 1.08
        self.low, self.high = math.floor(min(values) - 0.5), math.ceil(max(values) + 0.5)
        self.limit_drawn = limit is not None and limit <= max(values) + LIMIT_ROOM
        if self.limit_drawn:
            self.high = max(self.high, math.ceil(limit + 0.5))

    def x(self, count):
        return LEFT + PLOT_WIDTH * math.log(count / self.left) / math.log(self.right / self.left)

    def y(self, psnr):
        return TOP + PLOT_HEIGHT * (self.high - psnr) / (self.high - self.low)


def draw_axes(scale):
    bottom, right = TOP + PLOT_HEIGHT, LEFT + PLOT_WIDTH
    parts = []
    step = max(1, nice_step(scale.high - scale.low))
    for value in range(step * math.ceil(scale.low / step), scale.high + 1, step):
        y = scale.y(value)
        parts.append(line(LEFT, y, right, y, 'stroke="#e4e4e4"'))
        parts.append(text(LEFT - 8, y + 4, f"{value}", 'text-anchor="end"'))
    for count in ticks_between(scale.left, scale.right):
        x = scale.x(count)
        parts.append(line(x, TOP, x, bottom, 'stroke="#efefef"'))
        parts.append(line(x, bottom, x, bottom + 5, 'stroke="#333"'))
        parts.append(text(x, bottom + 19, bytes_text(count), 'text-anchor="middle"'))
    parts.append(text((LEFT + right) / 2, bottom + 40, "bytes of the file (1 kB = 1,000; logarithmic)",
                      'text-anchor="middle"'))
    parts.append(text(LEFT - 8, TOP - 10, "PSNR, dB", 'text-anchor="end"'))
    parts.append(line(LEFT, TOP, LEFT, bottom, 'stroke="#333"'))
    parts.append(line(LEFT, bottom, right, bottom, 'stroke="#333"'))
    return parts


def draw_curve(scale, curve):
    points = [(scale.x(b), scale.y(v)) for b, v in curve.points]
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    parts = [f'<polyline points="{path}" fill="none" stroke="{curve.colour}" stroke-width="{curve.width}" '
             'stroke-linejoin="round"/>']
    if curve.dots:
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" fill="{curve.colour}"><title>{b:,} bytes, {v:.2f} dB'
                  f'</title></circle>' for (x, y), (b, v) in zip(points, curve.points)]
    return parts


def draw_labels(scale, curves):
    """Names beside the plot, each as high as its curve ends, with a thread to that end."""
    right = LEFT + PLOT_WIDTH
    ends = [(scale.x(curve.points[-1][0]), scale.y(curve.points[-1][1])) for curve in curves]
    parts = []
    for curve, (x, y), place in zip(curves, ends, spread([y for _, y in ends], TOP + 6, TOP + PLOT_HEIGHT - 4)):
        parts.append(f'<polyline points="{x:.1f},{y:.1f} {max(x, right) + 2:.1f},{y:.1f} {right + 14:.1f},{place:.1f}" '
                     f'fill="none" stroke="{curve.colour}" stroke-width="0.8" stroke-dasharray="2 2"/>')
        parts.append(text(right + 18, place + 4, curve.label, f'fill="{curve.colour}" font-weight="bold"'))
    return parts


def draw_limit(scale, limit, label):
    right = LEFT + PLOT_WIDTH
    if not scale.limit_drawn:
        return [text(right - 6, TOP + PLOT_HEIGHT - 10, f"{label}: {limit:.1f} dB, above this figure",
                     'text-anchor="end" fill="#555"')]
    y = scale.y(limit)
    return [line(LEFT, y, right, y, 'stroke="#555" stroke-dasharray="7 4"'),
            text(LEFT + 8, y - 5, f"{label}: {limit:.1f} dB", 'fill="#555"')]


def draw(title, curves, limit=None, limit_label=""):
    """The figure as SVG text. limit: a PSNR that the first curve cannot pass, or None."""
    curves = [curve for curve in curves if curve.points]
    scale = Scale(curves, limit)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" '
        'font-family="sans-serif" font-size="12" fill="#222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
        text(LEFT, 22, title, 'font-size="15" font-weight="bold"'),
        *draw_axes(scale),
    ]
    if limit is not None:
        parts += draw_limit(scale, limit, limit_label)
    for curve in reversed(curves):  # the first one on top
        parts += draw_curve(scale, curve)
    parts += [*draw_labels(scale, curves), "</svg>"]
    return "\n".join(parts) + "\n"


def curves_of(archive, others, decimated, full):
    """The curves of a figure: each a list of points with bytes and psnr; others are archives of other bases."""
    def pairs(points):
        return [(point["bytes"], point["psnr"]) for point in sorted(points, key=lambda point: point["bytes"])]
    faint = [Curve(label, pairs(points), FAINT, 1.2, dots=False) for label, points in others]
    return [Curve("remaps", pairs(archive), COLOURS[0], 2.6),
            Curve("decimated × Draco, best", pairs(decimated), COLOURS[1]),
            Curve("Draco, full mesh", pairs(full), COLOURS[2]), *faint]
