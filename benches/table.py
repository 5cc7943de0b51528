#!/usr/bin/env python3
"""Criterion's medians as tables in README.md, and as plots of how costs grow.

Reads target/criterion/**/new/estimates.json, writes between the two benchmark markers of README.md, and to the given picture.
Needs matplotlib. Usage: benches/table.py TARGET_FOLDER README.md PICTURE.png
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

BEGIN, END = "<!-- benchmarks:begin -->", "<!-- benchmarks:end -->"
SIDES = [64, 128, 256]
CALLS = [("tau", "τ"), ("gradients", "τ, both gradients"), ("distance", "distance")]
MODES = ["first_order", "half_order", "log_linear", "linear_depth", "exact", "two_level", "exchangeable"]
TILED_MODES = MODES[3:]
# As in shifts.rs: offsets of a batch, of a larger one, and lengths of the run.
COUNT, MANY = 8, 32
RUNS = [1, 2, 4, 8]


def medians(target):
    """Nanoseconds per call by the benchmark's full name."""
    result = {}
    for file in pathlib.Path(target, "criterion").glob("**/new/estimates.json"):
        name = json.loads((file.parent / "benchmark.json").read_text())["full_id"]
        result[name] = json.loads(file.read_text())["median"]["point_estimate"]
    return result


def line_integrals(ns):
    yield "| ns per call | " + " | ".join(f"{side}³" for side in SIDES) + " |"
    yield "|---|" + "---:|" * len(SIDES)
    for shape in ["full", "sparse"]:
        for depth in ["thin", "dense"]:
            for key, words in CALLS:
                cells = [f"{ns[f'{key}/{shape} {depth} {side}']:.0f}" for side in SIDES]
                yield f"| {words}, {shape}, {depth} | " + " | ".join(cells) + " |"


def paths(ns):
    yield "| ns per path of 3 vertices | f | gradient | ratio |"
    yield "|---|---:|---:|---:|"
    for medium in ["homogeneous", "grid"]:
        f, gradient = ns[f"f/{medium}"], ns[f"gradient/{medium}"]
        yield f"| {medium} | {f:.0f} | {gradient:.0f} | {gradient / f:.2f} |"


def shifts(ns):
    def row(words, cells):
        return f"| {words} | " + " | ".join(cells) + " |"

    def cost(kernel, mode, run, count=COUNT):
        return ns[f"{kernel}/{mode} {run} {count}"]

    def further(mode, run):
        return (cost("disk", mode, run, MANY) - cost("disk", mode, run)) / (MANY - COUNT)

    yield row("ns per splat: one more (all of a batch / 8)", [f"run of {run}" for run in RUNS])
    yield "|---|" + "---:|" * len(RUNS)
    for mode in MODES:
        yield row(f"`{mode}`, disk", [f"{further(mode, run):.0f} ({cost('disk', mode, run) / COUNT:.0f})" for run in RUNS])
    for mode in TILED_MODES:
        yield row(f"`{mode}`, tile", [f"({cost('tile', mode, run) / COUNT:.0f})" for run in RUNS])
    yield row("`exact`, disk ÷ its optical depths and queries", [
        f"{cost('disk', 'exact', run) / cost('edges', 'exact', run):.2f}" for run in RUNS])


def write_table(readme, picture, ns):
    text = readme.read_text()
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    plots = f"![τ with bricks and without; exact batches by offsets and by length of the run]({picture.as_posix()})"
    table = "\n".join([*line_integrals(ns), "", *paths(ns), "", *shifts(ns), "", plots])
    readme.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}")


def points(ns, prefix, suffix=""):
    """The benchmarks whose names differ in a number between the two, by that number."""
    cut = [(name.removeprefix(prefix).removesuffix(suffix), value) for name, value in ns.items()
           if name.startswith(prefix) and name.endswith(suffix)]
    return sorted((int(number), value) for number, value in cut if number.isdigit())


def plot(picture, ns):
    figure, (side, count, run) = plt.subplots(1, 3, figsize=(11, 3.2), layout="constrained")
    for name in ["no bricks", "bricks"]:
        side.loglog(*zip(*points(ns, f"{name}/sparse ")), "o-", base=2, label=name)
    side.set(xlabel="samples along a side of the grid", ylabel="ns per τ, sparse grid")
    side.legend()
    in_us = lambda pairs: zip(*[(number, value / 1000) for number, value in pairs])
    count.plot(*in_us(points(ns, "disk/exact 1 ")), "o-")
    count.set(xlabel="offsets", ylabel="µs per exact batch, run of 1", xlim=0, ylim=0)
    run.plot(*in_us(points(ns, "disk/exact ", f" {COUNT}")), "o-", label="all")
    run.plot(*in_us(points(ns, "edges/exact ", f" {COUNT}")), "o-", label="its optical depths and queries")
    run.set(xlabel="vertices of the run", ylabel=f"µs per exact batch, {COUNT} offsets", xlim=0, ylim=0)
    run.legend()
    figure.savefig(picture, dpi=90)


def main():
    target, readme, picture = map(pathlib.Path, sys.argv[1:])
    ns = medians(target)
    write_table(readme, picture, ns)
    plot(picture, ns)


main()
