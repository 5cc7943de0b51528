#!/usr/bin/env python3
"""Criterion's medians as a table in README.md, and as a plot of what bricks are for.

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
CALLS = [("tau", "τ"), ("gradients", "τ, both gradients"), ("distance", "distance"),
         ("distance and gradients", "distance, both gradients")]


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


def write_table(readme, picture, ns):
    text = readme.read_text()
    before, rest = text.split(BEGIN)
    _, after = rest.split(END)
    table = "\n".join([*line_integrals(ns), "", *paths(ns), "", f"![τ with bricks and without]({picture.as_posix()})"])
    readme.write_text(f"{before}{BEGIN}\n{table}\n{END}{after}")


def plot(picture, ns):
    figure, axes = plt.subplots(figsize=(5, 3.5), layout="constrained")
    for name in ["no bricks", "bricks"]:
        prefix = f"{name}/sparse "
        points = sorted((int(key.removeprefix(prefix)), value) for key, value in ns.items() if key.startswith(prefix))
        axes.loglog(*zip(*points), "o-", base=2, label=name)
    axes.set_xlabel("samples along a side of the grid")
    axes.set_ylabel("ns per τ, nine tenths of the grid empty")
    axes.legend()
    figure.savefig(picture, dpi=120)


def main():
    target, readme, picture = map(pathlib.Path, sys.argv[1:])
    ns = medians(target)
    write_table(readme, picture, ns)
    plot(picture, ns)


main()
