"""The CSV files that `make figures` writes, read again: what plots and tables are made of."""
import csv

import numpy as np
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
    """CPU-seconds to a relative RMSE, from the longest renders by squared error ~ 1/time, and whether that is beyond what was rendered."""
    top = data.counts(**wanted)[-1]
    squared, seconds = (data.column(c, count=top, **wanted) for c in ("relative_mse", "cpu_seconds"))
    cost = safely(lambda e, t: e * t / target**2, squared, seconds)
    return cost, not squared.mean() <= target**2
