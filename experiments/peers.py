"""Whole renders beside Mitsuba 3: what error for how much processor time, of volgrad-render's integrators with and without shifts, and of
Mitsuba's volpath in its scalar and its compiled (llvm) variant.

Every program renders every scene ROUNDS times, with other seeds, at two sample counts; all programs take turns, so that they see the same
machine. Each uses one thread. The sample counts are such that a render of a scene takes every program the same time, the short ones SHORT
of that.

* Time is user + system CPU-seconds: for volgrad-render of the whole process, with start-up, reading the scene and writing the image; for
  Mitsuba of the render call alone. What Mitsuba needs before (compiling kernels above all) is written down apart.
* Error is relative_mse of tests/validate/images.py: the mean over pixels and channels of (difference^2 - standard error of the
  reference^2) / (reference^2 + (mean reference / 1000)^2). Its root is the relative RMSE.

room and caustic hold a mirror and a glass sphere. No shift moves a path whose first or second vertex lies there. What such paths add to the
error is measured by shifts over tiles of two sizes, with the seeds and sample counts of the path sampler's short renders: these take the
same paths, and the larger the tile, the less remains of the error of those that move (peers_report.py).

Writes peers.csv (all measurements), and from that peers.md, peers.png and the table in README.md (peers_report.py); pictures of the last
renders, to look at, into the output folder.
"""
import argparse
import csv
import os
import platform
import re
import resource
import shutil
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "validate"))

import peers_report  # noqa: E402
from peers_report import BDPT, BDPT_SHIFTED, MMLT, MMLT_SHIFTED, PLAIN, ROUNDS, SCENES, SHIFTED, SPECULAR, tile_name  # noqa: E402
from images import exposure_of, read, relative_mse, tonemap, upscale, write_side_by_side  # noqa: E402
from measures import TILES, reference_name  # noqa: E402
from mitsuba_renders import Mitsuba  # noqa: E402

# The unbiased options that were best in each scene, found in trial runs with other seeds.
TILE = "--shift exchangeable --shift-kernel tile"
SHIFTS = {
    "smoke": f"{TILE} --shift-run 3 --shift-count 3",
    "room": f"{TILE} --shift-run 1 --shift-count 35",
    "cloud": f"{TILE} --shift-run 1 --shift-count 3",
    "caustic": f"{TILE} --shift-run 1 --shift-count 8",
}
BIDIRECTIONAL_SHIFTS = {
    "smoke": f"{TILE} --shift-count 8",
    "room": f"{TILE} --shift-count 35",
    "cloud": f"{TILE} --shift-count 8",
    "caustic": f"{TILE} --shift-count 8",
}
CHAIN_SHIFTS = {
    "smoke": f"{TILE} --shift-run 3 --shift-count 8",
    "room": f"{TILE} --shift-run 1 --shift-count 15",
    "cloud": f"{TILE} --shift-run 1 --shift-count 8",
    "caustic": f"{TILE} --shift-run 1 --shift-count 15",
}
# Samples that tell the brightness are so many for each mutation that both errors fall alike. By default volgrad-render takes more of them
# in short renders, fewer in long ones.
BOOTSTRAP = 1 / 5
VARIANTS = ["scalar_rgb", "llvm_ad_rgb"]
SECONDS = {"smoke": 0.5, "room": 1.5, "cloud": 0.5, "caustic": 1.5}  # of a long render, relative to the mean: more where 10 % is far
SHORT = 1 / 4  # sample count of the short renders, by which error ~ 1/time is checked
PIXELS = 128 * 128
PILOTS = 2  # renders that tell the speed, beside ROUNDS + 1 that count or warm up
TILE_COST = 1  # of all tile renders together, in cells of mean length, roughly
FIRST = 4  # samples per pixel of the first render
SEED = 1_000_000  # Mitsuba's references were made with seeds 0, 1, 2...: the same seed is the same noise
ZOOM = 2  # of pictures


@dataclass
class Scene:
    name: str

    @property
    def file(self):
        return ROOT / "scenes" / f"{self.name}.xml"

    def reference(self):
        return tuple(read(ROOT / "scenes" / "reference" / f"{reference_name(self.name)}{kind}.exr") for kind in ("", "_stderr"))


# ---- programs: (scene, count per pixel, seed) -> image, CPU-seconds ----


class Volgrad:
    def __init__(self, name, renderer, output, options):
        """options: a command line's, of a scene's name and a count."""
        self.name, self.renderer, self.file, self.options = name, renderer, output / "volgrad.exr", options
        self.printed = ""

    def render(self, scene, count, seed):
        options = ["--seed", str(seed), "--threads", "1", "--quiet", *self.options(scene.name, count).split()]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run([self.renderer, scene.file, "-o", self.file, *options], check=True, stdout=subprocess.PIPE, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.printed = done.stdout
        return read(self.file), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


COUNTED = {
    "path": "--integrator path --spp {count}",
    "bdpt": "--integrator bdpt --spp {count}",
    "mmlt": "--integrator mmlt --mutations {count} --bootstrap {samples}",
}


def command(integrator, shifts=None):
    """The options of a scene's name and a count; `shifts`: by scene."""
    def options(scene, count):
        plain = COUNTED[integrator].format(count=count, samples=round(BOOTSTRAP * count * PIXELS))
        return f"{plain} {shifts[scene]}" if shifts else plain

    return options


class Peer:
    def __init__(self, variant, home):
        self.name, self.process = f"Mitsuba {variant.split('_')[0]}", Mitsuba(variant, home)

    def render(self, scene, count, seed):
        return self.process.render(scene.file, count, SEED + seed)


def all_programs(renderer, output):
    """volgrad's, and those Mitsubas that run here."""
    commands = {PLAIN: command("path"), SHIFTED: command("path", SHIFTS), BDPT: command("bdpt"),
                BDPT_SHIFTED: command("bdpt", BIDIRECTIONAL_SHIFTS), MMLT: command("mmlt"), MMLT_SHIFTED: command("mmlt", CHAIN_SHIFTS)}
    programs = [Volgrad(name, renderer, output, options) for name, options in commands.items()]
    for peer in [Peer(v, output / "home") for v in VARIANTS]:
        try:
            peer.render(Scene("smoke"), 1, 0)
            programs.append(peer)
        except BrokenProcessPool:
            print(f"{peer.name}: does not run here, left out (llvm variants need libLLVM, of Debian's libllvm19 for example)", flush=True)
    return programs


def tile_programs(renderer, output):
    for pixels in TILES:
        tiles = {scene: f"{options} --shift-count {pixels - 1}" for scene, options in SHIFTS.items()}  # the last one given counts
        yield Volgrad(tile_name(pixels), renderer, output, command("path", tiles))


# ---- measurement ----


@dataclass
class Cell:
    """What one program renders of one scene in each round: samples, or mutations, per pixel of the long and the short render."""

    scene: Scene
    program: object
    counts: dict


def plan(scene, program, seconds):
    """The counts that take so long. The first render may compile something, and its time is mostly starting up."""
    count = FIRST
    for pilot in range(PILOTS):
        _, took = program.render(scene, count, pilot)
        count = max(2, round(count * seconds / took))
    print(f"{scene.name:8} {program.name:26} {count:6} per pixel in {seconds:.1f} s", flush=True)
    return Cell(scene, program, {"long": count, "short": max(1, round(count * SHORT))})


def make_cells(programs, tiles, minutes):
    mean_seconds = 60 * minutes / (len(SCENES) * len(programs) + TILE_COST) / ((ROUNDS + 1) * (1 + SHORT) + PILOTS - 1)
    for scene in map(Scene, SCENES):
        cells = [plan(scene, p, mean_seconds * SECONDS[scene.name]) for p in programs]
        yield from cells
        if scene.name in SPECULAR:
            yield from (Cell(scene, t, {"short": cells[0].counts["short"]}) for t in tiles)


def measure(cells, pictures):
    """Round 0 warms up: Mitsuba compiles its kernels anew for each sample count."""
    for number in range(ROUNDS + 1):
        for cell in cells:
            reference, stderr = cell.scene.reference()
            for length, count in cell.counts.items():
                seed = 2 * number + (length == "short") + PILOTS
                image, seconds = cell.program.render(cell.scene, count, seed)
                mse = relative_mse(image, reference, stderr)
                yield cell.scene.name, cell.program.name, length, number, count, f"{seconds:.4f}", f"{mse:.6g}", f"{image.mean():.7g}"
                if length == "long" and number > 0:
                    pictures.add(cell, image)
        print(f"round {number} of {ROUNDS}", flush=True)


class Pictures:
    """The last long renders and their means over the rounds, beside the references."""

    def __init__(self):
        self.images = {}

    def add(self, cell, image):
        self.images.setdefault(cell.scene.name, {}).setdefault(cell.program.name, []).append(image)

    def write(self, folder):
        for scene, programs in self.images.items():
            reference, _ = Scene(scene).reference()
            exposure = exposure_of(reference)
            for name, choose in (("last", lambda all: all[-1]), ("mean", lambda all: sum(all) / len(all))):
                parts = [("reference", reference), *((p, choose(all)) for p, all in programs.items())]
                write_side_by_side(folder / f"{scene}-{name}.png", [(p, upscale(tonemap(i, exposure), ZOOM)) for p, i in parts])


def machine(renderer):
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text()) if os.path.exists("/proc/cpuinfo") else None
    version = subprocess.run([renderer, "--version"], capture_output=True, text=True).stdout.strip()
    return (f"{time.strftime('%Y-%m-%d')}, {model[1] if model else platform.processor()}, {version}, one thread each, "
            f"load of the machine before: {os.getloadavg()[0]:.1f}")


def write_rows(table, about, columns, rows):
    """Each as soon as it is there."""
    with open(table, "w", newline="", buffering=1) as file:
        file.write(f"# {about}\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)


def measure_all(renderer, output, minutes, table):
    import mitsuba

    shutil.rmtree(output / "home", ignore_errors=True)  # kernels compiled by an earlier call
    (output / "home").mkdir(parents=True)
    about = f"Mitsuba {mitsuba.__version__}, {machine(renderer)}"
    programs, pictures = all_programs(renderer, output), Pictures()
    cells = list(make_cells(programs, list(tile_programs(renderer, output)), minutes))
    write_rows(table, about, peers_report.COLUMNS, measure(cells, pictures))
    pictures.write(output)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", default="build/volgrad-render", help="the renderer")
    parser.add_argument("--output", default="build/peers", help="folder for what is not kept")
    parser.add_argument("--minutes", type=float, default=28, help="of rendering, roughly")
    parser.add_argument("--report", action="store_true", help="measure nothing, write the tables of peers.csv anew")
    arguments = parser.parse_args()
    table = ROOT / "experiments" / "peers.csv"
    if not arguments.report:
        measure_all(arguments.render, Path(arguments.output).resolve(), arguments.minutes, table)
    peers_report.write(table)


if __name__ == "__main__":
    main()
