"""A campaign file: which flights to fly with which parameters, and what to show of them.

[campaign]  name, about, frames, timeout_s (of one flight and its score), jobs (in parallel), columns = KEY | KEY,
            compare = AXIS: tables show the differences from the flights with the axis' first value in each grid
[grid]      KEY = VALUE | VALUE ...; KEY is scenario, seed, frames or section.name; whole numbers also as 1..3
[group G]   another grid, beside [grid]
[set]       KEY = VALUE for every flight; the axis of a grid goes before it
            section map has the options of ilp-lab world-map: such a flight carries a map of its world (--map), which is
            made before it; the settings of section world and the seed are those of the flight
[plot P]    x (an axis of a grid or a number of the score), y (a number of the score), series = AXIS | AXIS, log_x and
            log_y = true | false
Paths among the values are relative to the campaign file. A line that begins with ; or # is a comment, and so is what
follows " ;". An indented line continues the value before it.
"""

import hashlib
import itertools
import os
import re
from dataclasses import dataclass, field

from metrics import METRICS

MOST_JOBS = 10000
LONGEST_RANGE = 10000
LONGEST_NAME = 100
DEFAULT_COLUMNS = ["posed_share", "position_mean_percent", "position_max_percent", "rotation_mean_deg",
                   "height_median_percent", "completeness"]


class CampaignError(Exception):
    """What is wrong, for the person who started the campaign."""


@dataclass
class Plot:
    name: str
    line: int
    x: str = ""
    y: str = ""
    series: list = field(default_factory=list)
    log_x: bool = False
    log_y: bool = False


@dataclass
class Campaign:
    file: str
    name: str = ""
    about: str = ""
    frames: int = 0  # 0: the simulator's own number
    timeout_s: float = 900
    jobs: int = 0  # 0: one for each core
    columns: list = field(default_factory=list)
    compare: str = ""  # an axis
    grids: dict = field(default_factory=dict)  # name ("" for [grid]) -> {key: (values, line)}
    settings: dict = field(default_factory=dict)
    plots: dict = field(default_factory=dict)

    def axes(self):
        return {key for grid in self.grids.values() for key in grid}

    def folder(self):
        return os.path.dirname(os.path.abspath(self.file))


@dataclass
class Job:
    name: str  # fit for a folder; follows from the grid's name and the values of its axes alone
    grid: str
    axes: dict  # in the file's order
    scenario: str = ""  # a preset, an absolute path, or empty
    seed: int = 1
    frames: int = 0
    settings: dict = field(default_factory=dict)  # section.name -> value, sorted
    map: dict = field(default_factory=dict)  # option of ilp-lab world-map -> value, sorted; empty: a flight without a map

    def cell(self):
        """The axes without the seed: what the job's row in a table is called."""
        return {key: value for key, value in self.axes.items() if key != "seed"}

    def arguments(self):
        """For the simulator, without the program and the folder."""
        words = ["--scenario", self.scenario] if self.scenario else []
        for key, value in self.settings.items():
            words += ["--set", f"{key}={value}"]
        words += ["--seed", str(self.seed)]
        return words + (["--frames", str(self.frames)] if self.frames > 0 else [])

    def map_arguments(self):
        """For ilp-lab, without the program and the folder of the map; empty for a flight without a map."""
        if not self.map:
            return []
        words = ["world-map"] + ([self.scenario] if self.scenario else [])
        for key, value in self.settings.items():
            if key.startswith("world."):
                words += ["--set", f"{key}={value}"]
        words += ["--set", f"world.seed={self.seed}"]
        return words + [f"--{key.replace('_', '-')}={value}" for key, value in self.map.items()]


def is_scenario_file(scenario):
    return "/" in scenario or scenario.endswith(".ini")


def read_entries(file):
    """The entries of an INI file: (section, key, value, line)."""
    if os.path.isdir(file):
        raise CampaignError(f"{file} is a folder, not a file")
    try:
        with open(file, encoding="utf-8", errors="surrogateescape") as stream:
            text = stream.read()
    except OSError as error:
        raise CampaignError(f"cannot read {file}: {error.strerror}") from error
    entries, lines, section, going_on = [], {}, "", False
    for number, line in enumerate(text.removeprefix("\ufeff").split("\n"), 1):
        if "\0" in line:
            raise CampaignError(f"{file}:{number}: not a text file")
        indented, line = line[:1].isspace(), re.sub(r"(^|\s);.*", "", line).strip()
        if not line or line[0] == "#":
            continue
        entry = re.fullmatch(r"([^=:]*?)\s*[=:]\s*(.*)", line)
        if indented and going_on:
            entries[-1][2] += " " + line
        elif line[0] == "[" and "]" in line:
            section, going_on = line[1:line.index("]")], False
        elif line[0] != "[" and entry:
            key = entry[1]
            if (section, key) in lines:
                raise CampaignError(f"{file}:{number}: [{section}] {key} stands in line {lines[section, key]} already")
            lines[section, key], going_on = number, True
            entries.append([section, key, entry[2], number])
        else:
            raise CampaignError(f"{file}:{number}: neither a [section] nor key = value nor a comment")
    return entries


class Reader:
    """Fills a Campaign entry by entry; what is wrong is named with its line."""

    def __init__(self, file):
        self.campaign = Campaign(file)

    def read(self):
        for self.section, self.key, self.value, self.line in read_entries(self.campaign.file):
            self.take()
        self.check()
        return self.campaign

    def refuse_line(self, message, line=None):
        raise CampaignError(f"{self.campaign.file}:{line or self.line}: {message}")

    def refuse(self, expected):
        self.refuse_line(f"[{self.section}] {self.key} = {self.value}: expected {expected}")

    def take(self):
        kind, _, name = self.section.partition(" ")
        name = name.strip()
        if self.section == "campaign":
            self.take_campaign()
        elif self.section == "grid":
            self.take_axis("")
        elif kind == "group" and re.fullmatch(r"[a-z0-9_-]+", name):
            self.take_axis(name)
        elif self.section == "set":
            self.check_key()
            self.check_value(self.value)
            self.campaign.settings[self.key] = self.value
        elif kind == "plot":
            self.take_plot(name)
        else:
            self.refuse_line(f"section [{self.section}]: expected campaign, grid, group NAME (small letters, digits, _, -), "
                             "set or plot NAME")

    def take_campaign(self):
        campaign, value = self.campaign, self.value
        if self.key == "name":
            campaign.name = value or self.refuse("a name")
        elif self.key == "about":
            campaign.about = value
        elif self.key in ("frames", "jobs"):
            highest = 1000000 if self.key == "frames" else 1024
            if not re.fullmatch(r"\d{1,9}", value) or not 1 <= int(value) <= highest:
                self.refuse(f"a whole number from 1 to {highest}")
            setattr(campaign, self.key, int(value))
        elif self.key == "timeout_s":
            campaign.timeout_s = as_number(value) or 0
            if not 0 < campaign.timeout_s <= 1e6:
                self.refuse("seconds, above 0 to 1e6")
        elif self.key == "columns":
            campaign.columns = self.values()
            for column in campaign.columns:
                self.check_metric(column)
        elif self.key == "compare":
            campaign.compare = value
        else:
            self.refuse_line(f"[campaign] {self.key}: expected name, about, frames, timeout_s, jobs, columns or compare")

    def values(self):
        """What stands between the bars; none empty, none twice; 1..3 is 1, 2, 3."""
        values, seen = [], set()
        for item in map(str.strip, self.value.split("|")):
            if not item:
                self.refuse("values separated by |, none of them empty")
            span = re.fullmatch(r"(\d+)\.\.(\d+)", item)
            if span and not 0 <= int(span[2]) - int(span[1]) < LONGEST_RANGE:
                self.refuse(f"a range that rises, of at most {LONGEST_RANGE} values")
            for value in map(str, range(int(span[1]), int(span[2]) + 1)) if span else [item]:
                if value in seen:
                    self.refuse(f"each value once, not {value} twice")
                seen.add(value)
                values.append(value)
        return values

    def check_key(self):
        if not re.fullmatch(r"scenario|seed|frames|[a-z0-9_-]+\.[a-z0-9_-]+", self.key):
            self.refuse_line(f"[{self.section}] {self.key}: expected scenario, seed, frames or section.name")

    def check_value(self, value):
        if not value:
            self.refuse("a value")
        if self.key == "seed" and not (re.fullmatch(r"\d{1,20}", value) and int(value) < 2**64):
            self.refuse("whole numbers")
        if self.key == "frames" and not (re.fullmatch(r"\d{1,9}", value) and int(value) > 0):
            self.refuse("whole numbers from 1 on")
        if self.key == "scenario" and is_scenario_file(value):
            path = os.path.join(os.path.dirname(self.campaign.file), value)
            if not os.path.isfile(path):
                self.refuse(f"a preset's name or a file, and there is no {path}")

    def take_axis(self, grid):
        self.check_key()
        values = self.values()
        for value in values:
            self.check_value(value)
        self.campaign.grids.setdefault(grid, {})[self.key] = (values, self.line)

    def take_plot(self, name):
        if not name:
            self.refuse_line("[plot]: expected a name: [plot NAME]")
        plot = self.campaign.plots.setdefault(name, Plot(name, self.line))
        if self.key == "y":
            self.check_metric(self.value)
        if self.key in ("x", "y"):
            setattr(plot, self.key, self.value)
        elif self.key == "series":
            plot.series = self.values()
        elif self.key in ("log_x", "log_y"):
            if self.value not in ("true", "false"):
                self.refuse("true or false")
            setattr(plot, self.key, self.value == "true")
        else:
            self.refuse_line(f"[{self.section}] {self.key}: expected x, y, series, log_x or log_y")

    def check_metric(self, key):
        if key not in METRICS:
            self.refuse("a key of the score's summary: " + ", ".join(METRICS))

    def check(self):
        campaign = self.campaign
        if not campaign.grids:
            raise CampaignError(f"{campaign.file}: no flights: expected a section [grid] or [group NAME]")
        axes = campaign.axes()
        if campaign.compare and campaign.compare not in axes - {"seed"}:
            raise CampaignError(f"{campaign.file}: [campaign] compare = {campaign.compare}: expected an axis of a grid, not the seed")
        for plot in campaign.plots.values():
            where = f"[plot {plot.name}] "
            if not plot.x or not plot.y:
                self.refuse_line(where + "expected both x and y", plot.line)
            if plot.x not in axes and plot.x not in METRICS:
                self.refuse_line(f"{where}x = {plot.x}: expected an axis of a grid or a key of the score's summary", plot.line)
            for key in plot.series:
                if key not in axes:
                    self.refuse_line(f"{where}series = {key}: expected axes of a grid", plot.line)
        campaign.name = campaign.name or os.path.splitext(os.path.basename(campaign.file))[0]
        campaign.columns = campaign.columns or DEFAULT_COLUMNS


def read_campaign(file):
    """Raises CampaignError "FILE:LINE: what is wrong, what was expected"."""
    return Reader(str(file)).read()


def as_number(text):
    """None where the text is no finite number."""
    try:
        number = float(text) if re.fullmatch(r"[-+.\deE]+", text) else None
    except ValueError:
        return None
    return number if number is not None and abs(number) < float("inf") else None


def job_name(grid_name, grid, axes):
    """Distinct axes and values give distinct names: what is not shown as it is comes in as a digest."""
    lasts = [key.split(".")[-1] for key in grid]
    shown = []
    for key, value in axes.items():
        last = key.split(".")[-1]
        if key == "scenario":
            shown.append(os.path.splitext(os.path.basename(value))[0] if is_scenario_file(value) else value)
        else:
            shown.append((key if lasts.count(last) > 1 else last) + "=" + value)
    text = (grid_name + "+" if grid_name else "") + "_".join(shown)
    name = re.sub(r"[^A-Za-z0-9._+=-]", "-", text[:LONGEST_NAME])
    faithful = name == text and text[0] not in ".-" and not any(
        re.search("[_+]", value) or is_scenario_file(value) for value in axes.values())
    name = "_" + name if name[0] in ".-" else name
    exact = "\n".join([grid_name] + [f"{key}={value}" for key, value in axes.items()])
    return name if faithful else name + "~" + hashlib.sha256(exact.encode("utf-8", "surrogateescape")).hexdigest()[:8]


def job_at(campaign, grid_name, grid, values):
    axes = dict(zip(grid, values))
    job = Job(job_name(grid_name, grid, axes), grid_name, axes, frames=campaign.frames)
    for key, value in {**campaign.settings, **axes}.items():
        if key == "scenario":
            is_file = is_scenario_file(value)
            job.scenario = os.path.normpath(os.path.join(campaign.folder(), value)) if is_file else value
        elif key in ("seed", "frames"):
            setattr(job, key, int(value))
        elif key.startswith("map."):
            job.map[key.removeprefix("map.")] = value
        else:
            job.settings[key] = value
    job.settings, job.map = dict(sorted(job.settings.items())), dict(sorted(job.map.items()))
    return job


def expand(campaign):
    """The flights: the cartesian products of the grids, the last axis fastest."""
    jobs = []
    for name, grid in campaign.grids.items():
        count = 1
        for values, line in grid.values():
            count *= len(values)
            if len(jobs) + count > MOST_JOBS:
                raise CampaignError(f"{campaign.file}:{line}: with this axis there are more than {MOST_JOBS} flights: "
                                    "expected fewer values or axes")
        jobs += [job_at(campaign, name, grid, values) for values in itertools.product(*(v for v, _ in grid.values()))]
    return jobs
