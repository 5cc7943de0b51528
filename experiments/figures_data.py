"""The CSV files that `make figures` writes, read again: what plots and tables are made of."""
import csv

import numpy as np
from figures_plan import UNBIASED
from measures import ALLOWANCE, interval_of_log, student

TARGETS = [0.10, 0.03]  # relative RMSE
NO_NUMBER = np.full(3, np.nan)


class Data:
    def __init__(self, folder):
        self.about, self.rows = read(folder / "renders.csv")
        _, self.cells = read(folder / "cells.csv")

    def find(self, rows=None, **wanted):
        wanted = {k: str(v) for k, v in wanted.items()}
        return [r for r in (self.rows if rows is None else rows) if all(r[k] == v for k, v in wanted.items())]

    def column(self, name, **wanted):
        """By seed."""
        return np.array([float(r[name] or "nan") for r in self.find(**wanted)])

    def values(self, name, **wanted):
        """Different ones, in the order of the file."""
        return list(dict.fromkeys(r[name] for r in self.find(**wanted)))

    def counts(self, **wanted):
        return sorted(int(c) for c in self.values("count", **wanted))

    def cell(self, **wanted):
        return self.find(self.cells, **wanted)[0]

    def command(self, **wanted):
        rows = self.find(**wanted)
        return f"{rows[0]['command']} (seeds {rows[0]['seed']} to {rows[-1]['seed']})" if rows else ""


def read(file):
    lines = file.read_text().splitlines()
    return lines[0].removeprefix("# "), list(csv.DictReader(lines[1:]))


def safely(statistic, *columns):
    """An interval, or none where a mean is no positive number: an error so small that the reference's noise hides it."""
    if len(columns[0]) < 2 or any(not np.isfinite(c).all() or c.mean() <= 0 for c in columns):
        return NO_NUMBER
    with np.errstate(invalid="ignore"):
        return interval_of_log(statistic, *columns)


def part(cell, name):
    """bias2 or variance, and half its interval; bias2 may also be off by the square of what the reference is known to be wrong by."""
    allowance = ALLOWANCE[cell["scene"]] if name == "bias2" else 0
    return float(cell[name]), student(int(cell["seeds"])) * float(cell[name + "_error"]) + allowance**2


def rmse(squared):
    return safely(np.sqrt, squared)


def ratio(above, below):
    return safely(lambda x, y: x / y, above, below)


def products(above, below):
    """Ratio of the means' products: of squared errors and times."""
    return safely(lambda a, b, c, d: a * b / (c * d), *above, *below)


def time_to(data, target, **wanted):
    """CPU-seconds to a relative RMSE, by squared error ~ 1/time, and whether they are less or more than all renders took. From the longest
    renders; where there is bias, from the shortest that reach the target, and not at all if the longest do not."""
    counts = data.counts(**wanted)
    reached = [c for c in counts if data.column("relative_mse", count=c, **wanted).mean() <= target**2]
    extrapolated = counts[-1] not in reached or counts[0] in reached
    biased = data.find(**wanted)[0]["mode"] not in UNBIASED
    if biased and counts[-1] not in reached:
        return NO_NUMBER, extrapolated
    squared, seconds = (data.column(c, count=reached[0] if biased else counts[-1], **wanted) for c in ("relative_mse", "cpu_seconds"))
    return safely(lambda e, t: e * t / target**2, squared, seconds), extrapolated
