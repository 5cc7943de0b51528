"""Metropolis chains, plain and with shifts: how fast they are, what they accept, and what the shifts cost and gain.

volgrad-render --integrator mmlt --stats renders each scene with SEEDS seeds and one thread: without shifts, and with those of MODES at every
mutation (T = 1) and at every fourth (T = 4, the default of --shift-every), all with the same mutations, bootstrap samples and chains.
Shifts draw from random numbers of their own, so with one seed the chains are the same: they differ in what they splat alone.

* Cost: CPU time of the chains per mutation, over that without shifts. Bootstrap, burn-in and path sampler, the same for all, are not in it.
* Gain at equal mutations: mean relative MSE without shifts over that with them. At equal time: that over the cost.
* +- and (intervals) are 95 %, by the jackknife over the seeds (peers_report.py).

Writes chains.csv, and from that chains.md and the table in README.md.
"""
import argparse
import csv
import re
from pathlib import Path

import numpy as np
from measures import interval_of_log, student
from peers import CHAIN_SHIFTS, Scene, Volgrad, machine, write_rows
from peers_report import ROOT, SCENES
from tables import markdown, replace_between_markers, shown

from images import relative_mse

SEEDS = 5
FIRST_SEED = 100  # others than those of peers.py and of the trials
MODES = ["exchangeable", "exact", "two_level"]
EVERY = [1, 4]
SETTINGS = "--integrator mmlt --stats --chains 32 --bootstrap 65536"
MUTATIONS = {"smoke": 8, "room": 6, "cloud": 8, "caustic": 12}  # per pixel: one second without shifts, roughly
PLAIN = ("none", 0)
VARIANTS = [PLAIN, *((mode, every) for mode in MODES for every in EVERY)]
# As --stats names them, in the order of the file.
COUNTS = ["mutations", "burn-in", "large steps", "large accepted", "small steps", "small accepted", "dark", "shifted paths", "shifts", "stays"]
COLUMNS = ["scene", "mode", "every", "seed", "per_core_second", *COUNTS, "brightness", "brightness_error_percent", "relative_mse"]


# ---- measurement ----


def read_stats(text):
    """Of the chains: the counts, mutations per second, brightness and its error in percent."""
    lines = [line.split("  ") for line in text[text.index("brightness") :].splitlines() if line.strip()]
    found, steps = {}, ""
    for cells in lines:
        name, numbers = cells[0] or "accepted", re.findall(r"[\d.e+-]*\d[\d.e+-]*", " ".join(cells[1:]))
        steps = name.removesuffix(" steps") if name.endswith(" steps") else steps
        found[f"{steps} accepted" if name == "accepted" else name] = [float(n) for n in numbers]
    return found


def options(mode, every, scene, count):
    shift = "" if mode == "none" else f"{CHAIN_SHIFTS[scene]} --shift {mode} --shift-every {every}"  # the last mode given counts
    return f"{SETTINGS} --mutations {count} {shift}"


def measure(renderer, output):
    for seed in range(FIRST_SEED, FIRST_SEED + SEEDS):
        for scene in map(Scene, SCENES):
            for mode, every in VARIANTS:
                program = Volgrad(mode, renderer, output, lambda name, count: options(mode, every, name, count))
                image, _ = program.render(scene, MUTATIONS[scene.name], seed)
                stats = read_stats(program.printed)
                row = [scene.name, mode, every, seed, f"{stats['mutations'][1]:.0f}", *(f"{stats[c][0]:.0f}" for c in COUNTS)]
                yield [*row, *stats["brightness"], f"{relative_mse(image, *scene.reference()):.6g}"]
        print(f"seed {seed - FIRST_SEED + 1} of {SEEDS}", flush=True)


# ---- tables ----


class Measurements:
    def __init__(self, path):
        lines = path.read_text().splitlines()
        self.about, self.rows = lines[0].removeprefix("# "), list(csv.DictReader(lines[1:]))

    def column(self, scene, variant, name):
        """By seed."""
        found = [r for r in self.rows if (r["scene"], r["mode"], int(r["every"])) == (scene, *variant)]
        return np.array([float(r[name]) for r in found])


def spread(values, scale=1, digits=1):
    """Mean and 95 % interval of a normal distribution's mean."""
    reach = student(len(values)) * values.std(ddof=1) / np.sqrt(len(values))
    return f"{scale * values.mean():.{digits}f} ± {scale * reach:.{digits}f}"


def chain_row(m, scene):
    def share(part, whole):
        return spread(m.column(scene, PLAIN, part) / whole, 100) + " %"

    large, small = (m.column(scene, PLAIN, f"{size} steps") for size in ("large", "small"))
    known = m.column(scene, PLAIN, "brightness_error_percent").mean()
    cells = [scene, spread(m.column(scene, PLAIN, "per_core_second"), 1e-3, 0), share("large accepted", large), share("small accepted", small)]
    return cells + [share("dark", large + small), f"{m.column(scene, PLAIN, 'brightness').mean():.4g} ± {known:.2g} %"]


def shift_row(m, scene, variant):
    burn_in = m.column(scene, variant, "burn-in").sum() / m.column(scene, variant, "mutations").sum()

    def cost(before, after):
        """Of speeds, mutations with those of burn-in per second."""
        return (before / after - burn_in) / (1 - burn_in)

    speeds, errors = ([m.column(scene, v, c) for v in (PLAIN, variant)] for c in ("per_core_second", "relative_mse"))
    shifts, stays = (m.column(scene, variant, c).sum() for c in ("shifts", "stays"))
    cells = [scene, f"`{variant[0]}`", str(variant[1]), f"{stays / shifts:.0%}", shown(*interval_of_log(cost, *speeds))]
    cells += [shown(*interval_of_log(lambda before, after: before / after, *errors))]
    return cells + [shown(*interval_of_log(lambda s0, s, e0, e: e0 / e / cost(s0, s), *speeds, *errors))]


def chain_table(m):
    header = ["scene", "thousand mutations per core-second", "large steps accepted", "small steps accepted", "dark", "brightness"]
    return markdown(header, [chain_row(m, s) for s in SCENES])


def shift_table(m):
    header = ["scene", "shifts", "T", "offsets that stay", "cost per mutation", "gain at equal mutations", "gain at equal time"]
    return markdown(header, [shift_row(m, s, v) for s in SCENES for v in VARIANTS[1:]])


DETAILS = """# Metropolis chains, plain and with shifts
Written by `make chains`. {about}; {seeds} seeds, means with 95 % intervals. How it was measured: [chains.py](chains.py). Every render:
[chains.csv](chains.csv).

{chains}

* *large steps* are new, independent paths, *small steps* changes of the present one. *dark*: proposals that carry no light.
* *brightness*: mean over the bootstraps of {bootstrap} samples ± standard error of one, as volgrad-render prints it.

{shifts}

* *T*: mutations per batch of shifted paths. The other options of the shifts are those of [peers.py](peers.py). *Offsets that stay* reach
  no light, or cannot move for another reason.
* *cost*: CPU time of chains per mutation, over that without shifts. *gain*: mean relative MSE without shifts over that with them, at as many
  mutations; and in as much time of chains. The error of the brightness is the same with and without shifts and pulls the gain towards 1
  where it is large, in `room` and `cloud`.
"""


def write(table):
    m = Measurements(table)
    bootstrap = SETTINGS.split()[-1]
    table.with_suffix(".md").write_text(
        DETAILS.format(about=m.about, seeds=SEEDS, bootstrap=bootstrap, chains=chain_table(m), shifts=shift_table(m))
    )
    replace_between_markers(ROOT / "README.md", "chains", chain_table(m))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", default="build/volgrad-render", help="the renderer")
    parser.add_argument("--output", default="build/chains", help="folder for what is not kept")
    parser.add_argument("--report", action="store_true", help="measure nothing, write the tables of chains.csv anew")
    arguments = parser.parse_args()
    table, output = ROOT / "experiments" / "chains.csv", Path(arguments.output).resolve()
    if not arguments.report:
        output.mkdir(parents=True, exist_ok=True)
        write_rows(table, machine(arguments.render), COLUMNS, measure(arguments.render, output))
    write(table)


if __name__ == "__main__":
    main()
