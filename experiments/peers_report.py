"""Tables and plot from the measurements of peers.py.

The error of a program falls as 1/time: their product, over the 10 %'s square, is the time to 10 %. Products are averaged over the rounds
(long renders only). Intervals are 95 %, by the jackknife over the rounds, of the logarithm.
"""
import csv
from pathlib import Path

import matplotlib
import numpy as np
from measures import TILES, interval_of_log, mean, ratio, reference_name, still, still_text
from tables import markdown, replace_between_markers, shown

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.ticker import LogLocator  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]

ROUNDS = 8
TARGET = 0.1  # relative RMSE
COLUMNS = ["scene", "program", "length", "round", "spp", "cpu_seconds", "relative_mse", "image_mean"]
SCENES = ["smoke", "room", "cloud", "caustic"]
SPECULAR = ["room", "caustic"]  # scenes with surfaces beside which paths do not move
OURS = PLAIN, SHIFTED, BDPT, BDPT_SHIFTED, MMLT, MMLT_SHIFTED = "path", "path + shifts", "bdpt", "bdpt + shifts", "mmlt", "mmlt + shifts"


def tile_name(pixels):
    return f"path + tile of {pixels}"


# ---- measurements and statistics ----


class Measurements:
    def __init__(self, path):
        lines = path.read_text().splitlines()
        self.about = lines[0].removeprefix("# ")
        self.rows = list(csv.DictReader(lines[1:]))
        self.programs = list(dict.fromkeys(r["program"] for r in self.rows if r["program"] not in map(tile_name, TILES)))
        self.ours = [p for p in OURS if p in self.programs]

    def column(self, scene, program, name, length="long"):
        """By round, the warm-up left out."""
        found = [r for r in self.rows if (r["scene"], r["program"], r["length"]) == (scene, program, length) and r["round"] != "0"]
        return np.array([float(r[name]) for r in found])

    def warm_up(self, scene, program):
        """CPU-seconds that the first render of a sample count takes more than the others: compilation."""
        first = sum(float(r["cpu_seconds"]) for r in self.rows if (r["scene"], r["program"], r["round"]) == (scene, program, "0"))
        return (first - sum(np.median(self.column(scene, program, "cpu_seconds", n)) for n in ("long", "short"))) / 2

    def cost(self, scene, program, length="long"):
        """CPU-seconds to the target, by round."""
        return self.column(scene, program, "relative_mse", length) * self.column(scene, program, "cpu_seconds", length) / TARGET**2

    def best(self, scene, ours):
        """The program of volgrad's, or of the others, that takes the least time to the target."""
        return min((p for p in self.programs if (p in OURS) == ours), key=lambda p: self.cost(scene, p).mean())


# ---- the part that can be shifted ----


def movable(m, scene):
    """How much shifts gain in equal time on what can be shifted, and the share of the error that cannot."""
    if scene not in SPECULAR:
        return "the same", "–"
    programs = [PLAIN, *map(tile_name, TILES)]
    errors = [m.column(scene, p, "relative_mse", "short") for p in programs]
    tile = int(np.argmin([m.cost(scene, p, "short").mean() for p in programs[1:]])) + 1
    times = [m.column(scene, p, "cpu_seconds", "short") for p in (PLAIN, programs[tile])]

    def gain(*means):
        left = still(*means[:3])
        return (1 - left) / (means[tile] / means[0] - left) * means[3] / means[4]

    return shown(*interval_of_log(gain, *errors, *times)), still_text(*errors)


# ---- tables ----


def readme_row(m, scene):
    ours, peer = m.best(scene, True), m.best(scene, False)
    costs = {p: shown(*mean(m.cost(scene, p))) for p in (*m.ours, peer)}
    costs[ours] = f"**{costs[ours]}**"
    costs[peer] += f" {peer.removeprefix('Mitsuba ')}"
    return [scene, *costs.values(), shown(*ratio(m.cost(scene, peer), m.cost(scene, ours)))]


README = """CPU-seconds to an image of 128 x 128 pixels with 10 % relative RMSE, with 95 % intervals, of `--integrator path`, `bdpt` and `mmlt`, and of
the faster variant of Mitsuba's `volpath`. The last column is also by how much the squared error of volgrad's best is lower in equal time.
{about}.
All measurements: [experiments/peers.md](experiments/peers.md); again with `make peers`.

{table}"""


def readme_text(m):
    header = ["scene", *m.ours, "Mitsuba's best", "Mitsuba's best : volgrad's best"]
    return README.format(about=m.about, table=markdown(header, [readme_row(m, s) for s in SCENES]))


def bias(m, scene, program):
    """Ratio of the image's mean to the reference's, and how many standard errors of both that is from 1."""
    from images import read
    from scenes import scores

    reference, stderr = (read(ROOT / "scenes" / "reference" / f"{reference_name(scene)}{kind}.exr").mean(2) for kind in ("", "_stderr"))
    z, difference, _ = scores(m.column(scene, program, "image_mean"), reference.mean(), np.sqrt((stderr**2).sum()) / stderr.size, 0)
    return f"{1 + difference:.4f}", f"{z:+.1f}"


def detail_row(m, scene, program):
    seconds, spp = (m.column(scene, program, c) for c in ("cpu_seconds", "spp"))
    law = ratio(m.cost(scene, program, "short"), m.cost(scene, program))
    cells = [scene, program, f"{spp[0]:.0f}", f"{np.median(seconds):.2f}", f"{np.median(spp / seconds) * 128 * 128 / 1e6:.3f}"]
    cells += [shown(*mean(m.cost(scene, program))), shown(*law), *bias(m, scene, program)]
    return cells + [f"{max(0, m.warm_up(scene, program)):.1f}" if program not in OURS else "in the time"]


DETAILS = """# Whole renders beside Mitsuba 3
Written by `make peers`. {about}. How it was measured: [peers.py](peers.py). Every render: [peers.csv](peers.csv).

{table}

* *per pixel*: samples; for `mmlt`, mutations.
* *time to 10 %*: CPU-seconds, mean over {rounds} rounds of relative MSE x time, over 0.01; 95 % intervals.
* *short : long* is that from the short renders over that from the long: 1 where the squared error falls as 1/time. Where it is far from
  1, or its interval wide, as for chains that find the brightness of the image from few samples, the time to 10 % is but a guess: there
  the error is mostly that of the brightness, and of rare paths on which chains stay long.
* *mean* is the whole image's over the reference's, *z* the difference in standard errors of both. The reference of `smoke` itself is only
  known to 0.3 % (scenes/README.md).
* *compiling*: CPU-seconds per scene and sample count before the first image, not in the time. volgrad-render's start-up is in the time.

## What shifts do to the path sampler
{shifts}

In `room` and `caustic` no shift moves a path whose first or second vertex lies on the mirror or the glass sphere. They are
rendered once more with the seeds of `path`, and so its paths, and shifts over tiles of m = {tiles} pixels. If all paths moved, and all pixels of
a tile got the same of each, the squared error V(m) would be that of `path` over m. What V(m) = still + moving/m leaves for large m is the *error
that cannot* (be shifted), as a share of that of `path` at equal samples. Paths that move, but that light does not reach from elsewhere in the
tile, count there too. *Of what can be shifted* is the ratio of the moving parts without and with shifts, in equal time.

![error over time](peers.png)
"""


def details_text(m):
    header = ["scene", "program", "per pixel", "CPU-seconds", "M per CPU-second", "time to 10 %", "short : long", "mean", "z", "compiling"]
    table = markdown(header, [detail_row(m, s, p) for s in SCENES for p in m.programs])
    gains = [[s, shown(*ratio(m.cost(s, PLAIN), m.cost(s, SHIFTED))), *movable(m, s)] for s in SCENES]
    shifts = markdown(["scene", "path : path + shifts", "the same, of what can be shifted", "error that cannot"], gains)
    return DETAILS.format(about=m.about, table=table, shifts=shifts, rounds=ROUNDS, tiles=" and ".join(map(str, TILES)))


# ---- plot ----


def draw_program(axes, m, scene, program, colour):
    """A dot per render; the line through the mean product of squared error and time."""
    time, error = (np.concatenate([m.column(scene, program, c, n) for n in ("short", "long")]) for c in ("cpu_seconds", "relative_mse"))
    axes.plot(time, np.sqrt(np.maximum(error, 1e-8)), ".", color=colour, markersize=3)
    ends = np.array([time.min() / 1.5, time.max() * 1.5])
    axes.plot(ends, TARGET * np.sqrt(m.cost(scene, program).mean() / ends), color=colour, linewidth=1, label=program)


def draw(m, path):
    figure, panels = plt.subplots(1, len(SCENES), figsize=(13, 3.8), layout="constrained")
    for axes, scene in zip(panels, SCENES):
        for i, program in enumerate(m.programs):
            draw_program(axes, m, scene, program, f"C{i}")
        axes.set(title=scene, xlabel="CPU-seconds", xscale="log", yscale="log")
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_minor_locator(LogLocator(subs=(2, 5)))
            axis.set_minor_formatter("{x:g}")
            axis.set_major_formatter("{x:g}")
    panels[0].set_ylabel("relative RMSE")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(m.programs), frameon=False)
    figure.savefig(path, dpi=90)


# ---- files ----


def write(table):
    m = Measurements(table)
    draw(m, table.with_suffix(".png"))
    table.with_suffix(".md").write_text(details_text(m))
    replace_between_markers(ROOT / "README.md", "peers", readme_text(m))
    print(readme_text(m))
