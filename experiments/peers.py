"""Whole renders beside Mitsuba 3: what error for how much processor time, of volgrad-render plain and with shifts and of four Mitsubas.

Every program renders every scene ROUNDS times, with other seeds, at two sample counts; all programs take turns, so that they see the same
machine. Each uses one thread. The sample counts are such that a render of any program takes the same time, the short ones SHORT of that.

* Time is user + system CPU-seconds: for volgrad-render of the whole process, with start-up, reading the scene and writing the image; for
  Mitsuba of the render call alone. What Mitsuba needs before (compiling kernels above all) is written down apart.
* Error is relative_mse of tests/validate/images.py: the mean over pixels and channels of (difference^2 - standard error of the
  reference^2) / (reference^2 + (mean reference / 1000)^2). Its root is the relative RMSE.

room and caustic hold a mirror and a glass sphere. No shift moves a path whose first or second vertex lies there. What such paths add to the
error is measured by shifts over tiles of two sizes, with the seeds and sample counts of plain's short renders: these take the same paths,
and the larger the tile, the less remains of the error of those that move (peers_report.py).

Writes peers.csv (all measurements), and from that peers.md, peers.png and the table in README.md (peers_report.py).
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
from peers_report import PLAIN, ROUNDS, SHIFTED, SPECULAR, TILES, tile_name  # noqa: E402
from images import read, relative_mse  # noqa: E402
from mitsuba_renders import Mitsuba  # noqa: E402

# The unbiased options that were best in each scene, found in trial runs with other seeds.
SHIFTS = {
    "smoke": "--shift exchangeable --shift-kernel tile --shift-run 3 --shift-count 3",
    "room": "--shift exchangeable --shift-kernel tile --shift-run 1 --shift-count 15",
    "cloud": "--shift exchangeable --shift-kernel tile --shift-run 1 --shift-count 3",
    "caustic": "--shift exchangeable --shift-kernel tile --shift-run 1 --shift-count 8",
}
MITSUBAS = [(v, i) for v in ("scalar_rgb", "llvm_ad_rgb") for i in ("volpath", "volpathmis")]
SHORT = 1 / 4  # sample count of the short renders, by which error ~ 1/time is checked
TILE_COST = 2  # of all tile renders together, in cells, roughly
PILOT = 4  # samples per pixel of the render that tells the speed
SEED = 1_000_000  # Mitsuba's references were made with seeds 0, 1, 2...: the same seed is the same noise


@dataclass
class Scene:
    name: str
    shift: list

    @property
    def file(self):
        return ROOT / "scenes" / f"{self.name}.xml"

    def reference(self):
        return (read(ROOT / "scenes" / "reference" / f"{self.name}{kind}.exr") for kind in ("", "_stderr"))


# ---- programs: (scene, spp, seed) -> image, CPU-seconds ----


class Volgrad:
    def __init__(self, name, renderer, output, options):
        """options: of a scene."""
        self.name, self.renderer, self.file, self.options = name, renderer, output / "volgrad.exr", options

    def render(self, scene, spp, seed):
        options = ["--spp", str(spp), "--seed", str(seed), "--threads", "1", "--quiet", *self.options(scene)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([self.renderer, scene.file, "-o", self.file, *options], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return read(self.file), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Peer:
    def __init__(self, variant, integrator, process):
        self.name, self.integrator, self.process = f"Mitsuba {variant.split('_')[0]} {integrator}", integrator, process

    def render(self, scene, spp, seed):
        return self.process.render(scene.file, self.integrator, spp, SEED + seed)


def all_programs(renderer, output):
    """volgrad's two, and those Mitsubas that run here."""
    programs = [Volgrad(PLAIN, renderer, output, lambda scene: []), Volgrad(SHIFTED, renderer, output, lambda scene: scene.shift)]
    processes = {variant: Mitsuba(variant, output / "home") for variant, _ in MITSUBAS}
    for variant, integrator in MITSUBAS:
        peer = Peer(variant, integrator, processes[variant])
        try:
            peer.render(Scene("smoke", []), 1, 0)
            programs.append(peer)
        except BrokenProcessPool:
            print(f"{peer.name}: does not run here, left out (llvm variants need libLLVM, of Debian's libllvm19 for example)", flush=True)
    return programs


def tile_programs(renderer, output):
    for pixels in TILES:
        count = ["--shift-count", str(pixels - 1)]  # the last one given counts
        yield Volgrad(tile_name(pixels), renderer, output, lambda scene, count=count: scene.shift + count)


# ---- measurement ----


@dataclass
class Cell:
    """What one program renders of one scene in each round: samples per pixel of the long and the short render."""

    scene: Scene
    program: object
    counts: dict


def plan(scene, program, seconds):
    """The sample counts that take so long. The first render may compile something; the second tells the speed."""
    program.render(scene, PILOT, 0)
    _, pilot = program.render(scene, PILOT, 1)
    spp = max(2, round(PILOT * seconds / pilot))
    print(f"{scene.name:8} {program.name:26} {spp:6} samples per pixel in {seconds:.1f} s", flush=True)
    return Cell(scene, program, {"long": spp, "short": max(1, round(spp * SHORT))})


def make_cells(programs, tiles, minutes):
    seconds = 60 * minutes / (len(SHIFTS) * len(programs) + TILE_COST) / (ROUNDS + 1) / (1 + SHORT)
    for name, shift in SHIFTS.items():
        scene = Scene(name, shift.split())
        cells = [plan(scene, p, seconds) for p in programs]
        yield from cells
        if name in SPECULAR:
            yield from (Cell(scene, t, {"short": cells[0].counts["short"]}) for t in tiles)


def measure(cells):
    """Round 0 warms up: Mitsuba compiles its kernels anew for each sample count."""
    for number in range(ROUNDS + 1):
        for cell in cells:
            reference, stderr = cell.scene.reference()
            for length, spp in cell.counts.items():
                seed = 2 * number + (length == "short") + 2  # after the pilots'
                image, seconds = cell.program.render(cell.scene, spp, seed)
                mse = relative_mse(image, reference, stderr)
                yield cell.scene.name, cell.program.name, length, number, spp, f"{seconds:.4f}", f"{mse:.6g}", f"{image.mean():.7g}"
        print(f"round {number} of {ROUNDS}", flush=True)


def machine(renderer):
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text()) if os.path.exists("/proc/cpuinfo") else None
    version = subprocess.run([renderer, "--version"], capture_output=True, text=True).stdout.strip()
    import mitsuba

    return (f"{time.strftime('%Y-%m-%d')}, {model[1] if model else platform.processor()}, {version}, Mitsuba {mitsuba.__version__}, "
            f"one thread each, load of the machine before: {os.getloadavg()[0]:.1f}")


def measure_all(renderer, output, minutes, table):
    shutil.rmtree(output / "home", ignore_errors=True)  # kernels compiled by an earlier call
    (output / "home").mkdir(parents=True)
    about = machine(renderer)
    programs = all_programs(renderer, output)
    rows = list(measure(list(make_cells(programs, list(tile_programs(renderer, output)), minutes))))
    with open(table, "w", newline="") as file:
        file.write(f"# {about}\n")
        csv.writer(file, lineterminator="\n").writerows([peers_report.COLUMNS, *rows])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", default="build/volgrad-render", help="the renderer")
    parser.add_argument("--output", default="build/peers", help="folder for what is not kept")
    parser.add_argument("--minutes", type=float, default=28, help="of rendering; planning takes two more")
    parser.add_argument("--report", action="store_true", help="measure nothing, write the tables of peers.csv anew")
    arguments = parser.parse_args()
    table = ROOT / "experiments" / "peers.csv"
    if not arguments.report:
        measure_all(arguments.render, Path(arguments.output).resolve(), arguments.minutes, table)
    peers_report.write(table)


if __name__ == "__main__":
    main()
