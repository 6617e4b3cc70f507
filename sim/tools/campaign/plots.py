"""A number of the score against an axis of the grid: a dot for each flight, a line through the means."""

import html
import math
from dataclasses import dataclass, field

from campaign_file import as_number
from metrics import label_of
from tables import brief, number_of

WIDTH, LEFT, RIGHT, TOP, HEIGHT, TICK_ROOM, LEGEND_LINE, COLOURS = 640, 58, 16, 52, 250, 44, 18, 6

STYLE = """
.sweep{--i:#1d232b;--m:#66707c;--l:#e3e1dc;--b:#fff;--c1:#2b6aa3;--c2:#c8762b;--c3:#4b8a57;--c4:#8a5a9c;--c5:#b3261e;
--c6:#3f8f94;background:var(--b);font:12px system-ui,-apple-system,"Segoe UI",Roboto,sans-serif}
@media (prefers-color-scheme:dark){.sweep{--i:#e4e7eb;--m:#98a2ae;--l:#2d333b;--b:#1b1f25;--c1:#6fb0e6;--c2:#eaa45e;
--c3:#7fc48d;--c4:#c193d4;--c5:#f08a80;--c6:#74c3c7}}
.sweep .title{fill:var(--i);font-size:14px;font-weight:600}.sweep .tick{fill:var(--m);font-size:11.5px}
.sweep .grid{stroke:var(--l)}.sweep .mean{fill:none;stroke-width:1.8}.sweep .dot{fill-opacity:.75}
""" + "".join(f".sweep .mean.c{i}{{stroke:var(--c{i})}}.sweep .dot.c{i}{{fill:var(--c{i})}}\n" for i in range(1, COLOURS + 1))


@dataclass
class Series:
    name: str
    dots: list = field(default_factory=list)  # x, y of each flight that has both
    means: list = field(default_factory=list)  # rising in x; empty where x is a number of the score


@dataclass
class SweepPlot:
    title: str
    x_label: str
    y_label: str
    log_x: bool  # numbers that are not positive are left out then
    log_y: bool
    x_names: list = field(default_factory=list)  # not empty: x counts these from 0
    series: list = field(default_factory=list)
    without_number: int = 0  # flights of the plot that failed, were not run or lack the number


def sweep_plot(request, jobs, results):
    """Flights without the plot's axes stay out. An axis with a value that is no number is drawn as names, in the order of
    the grids."""
    plot = SweepPlot(request.name, label_of(request.x), label_of(request.y), request.log_x, request.log_y)
    values = list(dict.fromkeys(job.axes[request.x] for job in jobs if request.x in job.axes))
    if any(as_number(value) is None for value in values):
        plot.x_names, plot.log_x = values, False
    by_name = {}
    for job, result in zip(jobs, results):
        if any(key not in job.axes for key in request.series) or (values and request.x not in job.axes):
            continue
        name = ", ".join(job.axes[key] for key in request.series)
        series = by_name.setdefault(name, Series(name))
        if plot.x_names:
            x = plot.x_names.index(job.axes[request.x])
        else:
            x = as_number(job.axes[request.x]) if values else number_of(result, request.x)
        y = number_of(result, request.y)
        if x is None or y is None or (plot.log_x and x <= 0) or (plot.log_y and y <= 0):
            plot.without_number += 1
        else:
            series.dots.append((x, y))
    plot.series = list(by_name.values())
    for series in plot.series if values else []:
        at = {}
        for x, y in series.dots:
            at.setdefault(x, []).append(y)
        series.means = [(x, sum(ys) / len(ys)) for x, ys in sorted(at.items())]
    return plot


def tick_text(value, step):
    """The shortest text that tells neighbouring ticks apart."""
    if abs(value) < step * 1e-6:
        return "0"
    if abs(value) >= 1e6 or step < 1e-5:
        return brief(value)
    return f"{value:.{0 if step >= 1 else math.ceil(-math.log10(step) - 1e-9)}f}"


class Scale:
    """From values to 0..1, with its ticks (value, text)."""

    def __init__(self, low, high, ticks, logarithmic=False):
        self.low, self.high, self.ticks, self.logarithmic = low, high, ticks, logarithmic

    def at(self, value):
        if self.logarithmic:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


def linear_scale(low, high, whole_steps):
    if high - low < 1e-9 * max(1.0, abs(high)):
        margin = max(abs(high) * 0.1, 1e-6)
        low, high = low - margin, high + margin
    raw = (high - low) / 6
    power = 10.0 ** math.floor(math.log10(raw))
    step = next((factor * power for factor in (1, 2, 5) if raw <= factor * power), 10 * power)
    if whole_steps:
        low, high = math.floor(low / step + 1e-9) * step, math.ceil(high / step - 1e-9) * step
    else:
        low, high = low - 0.04 * (high - low), high + 0.04 * (high - low)
    numbers = range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)
    return Scale(low, high, [(i * step, tick_text(i * step, step)) for i in numbers])


def log_scale(low, high):
    low, high = low / 1.1, high * 1.1
    powers = [10.0 ** i for i in range(math.floor(math.log10(low)), math.floor(math.log10(high)) + 1)]
    factors = (1, 2, 5) if high / low < 100 else (1,)
    values = [(factor * power, power) for power in powers for factor in factors if low <= factor * power <= high]
    return Scale(low, high, [(value, tick_text(value, power)) for value, power in values], logarithmic=True)


class Painter:
    def __init__(self, plot):
        self.plot, self.svg = plot, []
        self.x_scale = self.y_scale = None
        dots = [dot for series in plot.series for dot in series.dots]
        if not dots:
            return
        xs, ys = zip(*dots)
        if plot.x_names:
            self.x_scale = Scale(-0.5, len(plot.x_names) - 0.5, list(enumerate(plot.x_names)))
        else:
            self.x_scale = log_scale(min(xs), max(xs)) if plot.log_x else linear_scale(min(xs), max(xs), False)
        self.y_scale = log_scale(min(ys), max(ys)) if plot.log_y else linear_scale(min(0, *ys), max(0, *ys), True)

    def x(self, value):
        return LEFT + self.x_scale.at(value) * (WIDTH - LEFT - RIGHT)

    def y(self, value):
        return TOP + (1 - self.y_scale.at(value)) * HEIGHT

    def text(self, x, y, style, anchor, content):
        self.svg.append(f'<text class="{style}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{html.escape(content)}</text>')

    def line(self, x0, y0, x1, y1):
        self.svg.append(f'<line class="grid" x1="{x0:.1f}" y1="{y0:.1f}" x2="{x1:.1f}" y2="{y1:.1f}"/>')

    def dot(self, x, y, series, radius, title=""):
        self.svg.append(f'<circle class="dot c{series % COLOURS + 1}" cx="{x:.1f}" cy="{y:.1f}" r="{radius}">'
                        f"<title>{html.escape(title)}</title></circle>")

    def draw_axes(self):
        bottom = TOP + HEIGHT
        for value, name in self.y_scale.ticks:
            self.line(LEFT, self.y(value), WIDTH - RIGHT, self.y(value))
            self.text(LEFT - 7, self.y(value) + 4, "tick", "end", name)
        for value, name in self.x_scale.ticks:
            self.line(self.x(value), bottom, self.x(value), bottom + 4)
            self.text(self.x(value), bottom + 17, "tick", "middle", name)
        self.text(WIDTH - RIGHT, bottom + 35, "tick", "end", self.plot.x_label)
        self.text(0, TOP - 15, "tick", "start", self.plot.y_label)

    def draw_series(self, number, series):
        if len(series.means) > 1:
            points = " ".join(f"{self.x(x):.1f},{self.y(y):.1f}" for x, y in series.means)
            self.svg.append(f'<polyline class="mean c{number % COLOURS + 1}" points="{points}"/>')
        for x, y in series.dots:
            self.dot(self.x(x), self.y(y), number, 3, f"{series.name} {brief(y)}")

    def draw_legend(self):
        """The height of the whole picture."""
        x, y = LEFT, TOP + HEIGHT + TICK_ROOM + 8
        if not any(series.name for series in self.plot.series):
            return TOP + HEIGHT + TICK_ROOM
        for number, series in enumerate(self.plot.series):
            room = 30 + 6.6 * len(series.name)
            if LEFT < x and x + room > WIDTH:
                x, y = LEFT, y + LEGEND_LINE
            self.dot(x + 4, y - 4, number, 4.5)
            self.text(x + 13, y, "tick", "start", series.name)
            x += room
        return y + 10

    def draw(self):
        self.text(0, 16, "title", "start", self.plot.title)
        height = TOP + HEIGHT + TICK_ROOM
        if self.x_scale is None:
            self.text(0.5 * WIDTH, TOP + 0.5 * HEIGHT, "tick", "middle", "no data")
        else:
            self.draw_axes()
            for number, series in enumerate(self.plot.series):
                self.draw_series(number, series)
            height = self.draw_legend()
        return (f'<svg class="sweep" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height:.1f}" role="img" '
                f'aria-label="{html.escape(self.plot.title)}">{"".join(self.svg)}</svg>')


def draw(plot):
    """An <svg> element, in the style of `STYLE`."""
    return Painter(plot).draw()


def svg_file(plot):
    """The same as a file of its own."""
    head, mark, rest = draw(plot).partition(">")
    return f"{head}{mark}<style>{STYLE}</style>{rest}\n"
