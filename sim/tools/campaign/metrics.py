"""The numbers of a flight's score (score.json, "summary"), from the table that the C++ programs use."""

import os
import re
from dataclasses import dataclass

SIM = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


@dataclass
class Metric:
    label: str  # with the unit
    better: str  # lower, higher, nearer (to the ideal) or neither
    ideal: str

    def worst(self, values):
        """The value that is farthest from good; None for no values, and where no value is better than another."""
        badness = {"lower": lambda v: v, "higher": lambda v: -v,
                   "nearer": lambda v: abs(v - float(self.ideal))}
        return max(values, key=badness[self.better]) if values and self.better != "neither" else None


def read_metrics():
    with open(os.path.join(SIM, "host", "metrics.inc"), encoding="utf-8") as table:
        rows = re.findall(r'^ILP_METRIC\("(\w+)", "[^"]*", "([^"]*)", (\w+), "([^"]*)"\)$', table.read(), re.M)
    return {key: Metric(label, better, ideal) for key, label, better, ideal in rows}


METRICS = read_metrics()


def label_of(key):
    return METRICS[key].label if key in METRICS else key
