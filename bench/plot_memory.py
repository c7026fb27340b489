#!/usr/bin/env python3
"""Draws resident memory over time for several budgets as SVG, as the paper's figure 4.

    bench/plot_memory.py --title "Earth" --output memory.svg REPORT.json...

The reports are those of `remaps remesh --report`. The bench calls `draw` with what it has stored.
"""

import argparse
import json
import math
from dataclasses import dataclass
from html import escape

MIB = 2**20
PHASES = ("ingest", "sweeps", "map", "resample", "measure")
PHASE_FILLS = ("#9fb8d0", "#f3d3a4", "#bfe3c7", "#dcc7ea", "#e2e2e2")
# Told apart by those who do not see all colours (Okabe and Ito).
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")

WIDTH, PLOT_HEIGHT = 900, 330
LEFT, RIGHT, TOP = 66, 178, 46
STRIP, STRIP_GAP, AXIS_SPACE = 15, 4, 46
PLOT_WIDTH = WIDTH - LEFT - RIGHT


@dataclass
class Run:
    label: str  # as the budget was stated, 64M
    budget: int  # bytes
    trace: list  # (seconds, bytes)
    phases: dict  # seconds by phase; may lack some
    peak: int  # bytes, of the whole run: the trace may miss it


def size_text(mib):
    return f"{mib / 1024:g} GiB" if mib >= 1024 else f"{mib:g} MiB"


def nice_step(length):
    """A round step that divides a length into four to ten."""
    step = 10 ** math.floor(math.log10(length / 4))
    for factor in (1, 2, 5, 10):
        if length / (factor * step) <= 8:
            return factor * step
    return 10 * step


class Scale:
    """From seconds and bytes to the page; memory on a scale of powers of two."""

    def __init__(self, runs):
        self.seconds = max(max(run.trace[-1][0], sum(run.phases.get(p) or 0 for p in PHASES)) for run in runs)
        high = max(max(run.peak, run.budget) for run in runs) / MIB
        low = min(max(bytes_, MIB) for run in runs for _, bytes_ in run.trace) / MIB
        self.high = math.log2(high) + 0.25  # room above the topmost line
        self.low = min(math.floor(math.log2(low)), math.floor(self.high) - 2)

    def x(self, seconds):
        return LEFT + PLOT_WIDTH * seconds / self.seconds

    def y(self, bytes_):
        exponent = max(math.log2(max(bytes_, 1) / MIB), self.low)
        return TOP + PLOT_HEIGHT * (self.high - exponent) / (self.high - self.low)


def line(x1, y1, x2, y2, style):
    return f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" {style}/>'


def text(x, y, words, style=""):
    return f'<text x="{x:.1f}" y="{y:.1f}" {style}>{escape(words)}</text>'


def draw_axes(scale):
    bottom, right = TOP + PLOT_HEIGHT, LEFT + PLOT_WIDTH
    parts = []
    for exponent in range(scale.low, math.floor(scale.high) + 1):
        y = scale.y(2**exponent * MIB)
        parts.append(line(LEFT, y, right, y, 'stroke="#e4e4e4"'))
        parts.append(text(LEFT - 8, y + 4, size_text(2**exponent), 'text-anchor="end"'))
    step = nice_step(scale.seconds)
    for i in range(int(scale.seconds / step) + 1):
        x = scale.x(i * step)
        parts.append(line(x, bottom, x, bottom + 5, 'stroke="#333"'))
        parts.append(text(x, bottom + 18, f"{i * step:g}", 'text-anchor="middle"'))
    parts.append(text((LEFT + right) / 2, bottom + 36, "seconds since the start", 'text-anchor="middle"'))
    parts.append(line(LEFT, TOP, LEFT, bottom, 'stroke="#333"'))
    parts.append(line(LEFT, bottom, right, bottom, 'stroke="#333"'))
    return parts


def draw_run(scale, run, colour):
    budget = scale.y(run.budget)
    points = " ".join(f"{scale.x(s):.1f},{scale.y(b):.1f}" for s, b in run.trace)
    return [
        line(LEFT, budget, LEFT + PLOT_WIDTH, budget,
             f'stroke="{colour}" stroke-dasharray="7 4" stroke-opacity="0.75"'),
        f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="1.8" stroke-linejoin="round"/>',
    ]


def draw_legend(runs):
    x = LEFT + PLOT_WIDTH + 18
    parts = [text(x, TOP + 8, "--memory", 'font-weight="bold"'), text(x + 76, TOP + 8, "peak", 'font-weight="bold"')]
    for i, run in enumerate(runs):
        y = TOP + 30 + 20 * i
        parts.append(line(x, y - 4, x + 22, y - 4, f'stroke="{COLOURS[i % len(COLOURS)]}" stroke-width="3"'))
        parts.append(text(x + 28, y, run.label))
        parts.append(text(x + 76, y, f"{run.peak / MIB:,.0f} MiB"))
    y = TOP + 38 + 20 * len(runs)
    parts.append(line(x, y - 4, x + 22, y - 4, 'stroke="#555" stroke-dasharray="7 4"'))
    parts.append(text(x + 28, y, "the budget"))
    return parts


def draw_strips(scale, runs):
    """Under the plot, on the same time axis: which phase each run was in."""
    parts = []
    for i, run in enumerate(runs):
        top = TOP + PLOT_HEIGHT + AXIS_SPACE + i * (STRIP + STRIP_GAP)
        colour = COLOURS[i % len(COLOURS)]
        parts.append(text(LEFT - 8, top + 12, run.label, f'text-anchor="end" fill="{colour}"'))
        start = 0.0
        for phase, fill in zip(PHASES, PHASE_FILLS):
            seconds = run.phases.get(phase) or 0
            width = PLOT_WIDTH * seconds / scale.seconds
            if width >= 0.5:
                parts.append(f'<rect x="{scale.x(start):.1f}" y="{top}" width="{width:.1f}" height="{STRIP}" '
                             f'fill="{fill}" stroke="white" stroke-width="0.8">'
                             f'<title>{phase}, {seconds:.1f} s</title></rect>')
            if width > 7.5 * len(phase):
                parts.append(text(scale.x(start) + width / 2, top + 11.5, phase, 'text-anchor="middle" font-size="11"'))
            start += seconds
    return parts


def draw_phase_key(runs):
    """Names of the phases, below the strips."""
    y = TOP + PLOT_HEIGHT + AXIS_SPACE + len(runs) * (STRIP + STRIP_GAP) + 6
    parts = []
    for i, (phase, fill) in enumerate(zip(PHASES, PHASE_FILLS)):
        x = LEFT + 92 * i
        parts.append(f'<rect x="{x}" y="{y}" width="12" height="12" fill="{fill}"/>')
        parts.append(text(x + 17, y + 10, phase, 'font-size="11"'))
    return parts


def draw(title, runs):
    """The figure as SVG text."""
    scale = Scale(runs)
    height = TOP + PLOT_HEIGHT + AXIS_SPACE + len(runs) * (STRIP + STRIP_GAP) + 30
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" height="{height}" '
        'font-family="sans-serif" font-size="12" fill="#222">',
        f'<rect width="{WIDTH}" height="{height}" fill="white"/>',
        text(LEFT, 22, title, 'font-size="15" font-weight="bold"'),
        text(LEFT - 8, TOP - 10, "resident", 'text-anchor="end"'),
        *draw_axes(scale),
    ]
    for i, run in enumerate(runs):
        parts += draw_run(scale, run, COLOURS[i % len(COLOURS)])
    parts += [*draw_legend(runs), *draw_strips(scale, runs), *draw_phase_key(runs), "</svg>"]
    return "\n".join(parts) + "\n"


def run_of_report(path):
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    budget = report["memory_budget_bytes"]
    return Run(f"{budget / MIB:g}M", budget, [(s["seconds"], s["rss_bytes"]) for s in report["memory_trace"]],
               report["seconds"], report["peak_rss_bytes"])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("reports", nargs="+", metavar="REPORT.json")
    parser.add_argument("--title", default="Resident memory over time")
    parser.add_argument("--output", required=True, help="the SVG to write")
    arguments = parser.parse_args()
    with open(arguments.output, "w", encoding="utf-8") as file:
        file.write(draw(arguments.title, [run_of_report(path) for path in arguments.reports]))


if __name__ == "__main__":
    main()
