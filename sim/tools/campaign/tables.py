"""The numbers of a campaign: every job for programs, cells over seeds for people."""

import csv
import io
import math
import statistics
from dataclasses import dataclass, field

from metrics import METRICS


def scored(result):
    return result is not None and not result.failure


def number_of(result, key):
    """None where a flight does not tell."""
    return result.summary.get(key) if scored(result) else None


def brief(value):
    """About three digits; a dash for what is not known."""
    if value is None or not math.isfinite(value):
        return "–"
    size = abs(value)
    for limit, decimals in ((100, 0), (10, 1), (1, 2), (0.01, 3), (0.0001, 5)):
        if size >= limit:
            return f"{value:.3g}" if size >= 1e12 else f"{value:.{decimals}f}"
    return f"{value:.2g}"


def exact(value):
    return "" if value is None else repr(value).removesuffix(".0")


def table_csv(jobs, results):
    """One row for each job in the order of the grids: its axes, done, failed or not run, all numbers of the scores in full
    precision. Empty where there is no number. RFC 4180, with a header."""
    axes = list(dict.fromkeys(key for job in jobs for key in job.axes))
    others = sorted({key for result in results if result for key in result.summary} - set(METRICS))
    numbers = list(METRICS) + others
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(["job", "grid", *axes, "result", "complete", *numbers, "failure"])
    for job, result in zip(jobs, results):
        state = "not run" if result is None else "failed" if result.failure else "done"
        complete = str(result.complete).lower() if scored(result) else ""
        table.writerow([job.name, job.grid, *(job.axes.get(key, "") for key in axes), state, complete,
                        *(exact(number_of(result, key)) for key in numbers), result.failure if result else ""])
    return text.getvalue()


# 97.5 % quantiles of Student's distribution by degrees of freedom.
STUDENT = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262)


def student(freedom):
    return STUDENT[freedom - 1] if freedom <= len(STUDENT) else 1.96 + 2.372 / freedom + 2.823 / freedom**2


@dataclass
class Cell:
    """Flights that differ in nothing but the seed."""
    axes: dict
    results: list = field(default_factory=list)
    base: "Cell | None" = None  # with what its flights are compared, seed by seed

    def scored(self):
        return sum(map(scored, self.results))

    def flights(self):
        """"3", or "2 of 3" where some have no score."""
        return str(len(self.results)) if self.scored() == len(self.results) else f"{self.scored()} of {len(self.results)}"

    def text(self, key):
        """"1.23 (2.34)", mean and worst; " of 2" after it where not every scored flight of the cell has the number. With a
        base "+0.12 ± 0.03": the mean difference and the half of its 95 % interval."""
        if self.base:
            return self.difference(key)
        values = [v for v in (number_of(result, key) for result in self.results) if v is not None]
        text = brief(sum(values) / len(values) if values else None)
        if len(values) > 1 and METRICS[key].better != "neither":
            text += f" ({brief(METRICS[key].worst(values))})"
        return text + (f" of {len(values)}" if 0 < len(values) < self.scored() else "")

    def difference(self, key):
        pairs = [(number_of(a, key), number_of(b, key)) for a, b in zip(self.results, self.base.results)]
        differences = [a - b for a, b in pairs if a is not None and b is not None]
        if len(differences) < 2:
            return f"{differences[0]:+.3g}" if differences else brief(None)
        mean = statistics.fmean(differences)
        half = student(len(differences) - 1) * statistics.stdev(differences) / math.sqrt(len(differences))
        digits = max(0, min(6, 1 - math.floor(math.log10(half)))) if half > 0 else 4
        return f"{mean:+.{digits}f} ± {half:.{digits}f}"


@dataclass
class CellTable:
    grids: list
    axes: list
    cells: list = field(default_factory=list)  # in the order of their first jobs


def set_bases(cells, axis):
    """The first value of the axis is the base of the others, where all other axes are the same."""
    bases = {}
    for grid, cell in cells:
        if axis in cell.axes:
            place = (grid, *((key, value) for key, value in cell.axes.items() if key != axis))
            cell.base = bases.get(place)
            bases.setdefault(place, cell)


def cell_tables(jobs, results, compare=""):
    """Grids that follow each other with the same axes share a table."""
    tables, places, grid = [], {}, None
    for job, result in zip(jobs, results):
        axes = job.cell()
        if job.grid != grid or not tables:
            grid = job.grid
            if tables and tables[-1].axes == list(axes):
                tables[-1].grids.append(grid)
            else:
                tables.append(CellTable([grid], list(axes)))
        place = (job.grid, *axes.items())
        if place not in places:
            places[place] = Cell(axes)
            tables[-1].cells.append(places[place])
        places[place].results.append(result)
    if compare:
        set_bases([(place[0], cell) for place, cell in places.items()], compare)
    return tables


def how_to_read(campaign):
    if not campaign.compare:
        return "Mean over the seeds, and the worst in parentheses."
    return (f"Mean over the seeds, and the worst in parentheses, for the first {campaign.compare} of each grid; for the others "
            "the mean difference from it with its 95 % interval.")


def table_markdown(campaign, jobs, results):
    """The campaign's columns, mean and worst over the seeds."""
    text = f"# {campaign.name}\n" + (f"\n{campaign.about}\n" if campaign.about else "")
    text += f"\n{how_to_read(campaign)}\n"
    for table in cell_tables(jobs, results, campaign.compare):
        grids = ", ".join(table.grids)
        numbers = ["flights", *campaign.columns]
        rows = [table.axes + numbers, ["---"] * len(table.axes) + ["---:"] * len(numbers)]
        for cell in table.cells:
            names = [value.replace("|", "\\|") for value in cell.axes.values()]
            rows.append(names + [cell.flights()] + [cell.text(column) for column in campaign.columns])
        text += (f"\n## {grids}\n\n" if grids else "\n") + "".join(f"| {' | '.join(row)} |\n" for row in rows)
    return text
