"""Whole renders beside Mitsuba 3: what error for how much processor time, of volgrad-render plain and with shifts and of four Mitsubas.

Every program renders every scene ROUNDS times, with other seeds, at two sample counts; all programs take turns, so that they see the same
machine. Each uses one thread. The sample counts are such that a render of any program takes the same time, the short ones SHORT of that.

* Time is user + system CPU-seconds: for volgrad-render of the whole process, with start-up, reading the scene and writing the image; for
  Mitsuba of the render call alone. What Mitsuba needs before (compiling kernels above all) is written down apart.
* Error is relative_mse of tests/validate/images.py: the mean over pixels and channels of (difference^2 - standard error of the
  reference^2) / (reference^2 + (mean reference / 1000)^2). Its root is the relative RMSE.

room and caustic hold a mirror and a glass sphere. No shift moves a path whose first or second vertex lies there. Both scenes are therefore
measured once more with these surfaces painted black, in which case every path can be shifted. There is no reference for that: the error is
the variance over the rounds, with the weights of the scene as it is.

Writes peers.csv (all measurements), and from that peers.md, peers.png and the table in README.md (peers_report.py).
"""
import argparse
import csv
import os
import platform
import re
import resource
import subprocess
import sys
import time
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "validate"))

import peers_report  # noqa: E402
from images import attribute, read, relative_mse, squared_error  # noqa: E402
from mitsuba_renders import Mitsuba  # noqa: E402

# The unbiased options that were best in each scene, found in trial runs with other seeds.
SHIFTS = {
    "smoke": "--shift exchangeable --shift-kernel tile --shift-run 3 --shift-count 3",
    "room": "--shift exchangeable --shift-kernel tile --shift-run 1 --shift-count 15",
    "cloud": "--shift exchangeable --shift-kernel tile --shift-run 1 --shift-count 8",
    "caustic": "--shift exchangeable --shift-kernel tile --shift-run 3 --shift-count 8",
}
MITSUBAS = [(v, i) for v in ("scalar_rgb", "llvm_ad_rgb") for i in ("volpath", "volpathmis")]
ROUNDS = peers_report.ROUNDS
SHORT = 1 / 4  # sample count of the short renders, by which error ~ 1/time is checked
PILOT = 4  # samples per pixel of the render that tells the speed
SEED = 1_000_000  # Mitsuba's references were made with seeds 0, 1, 2...: the same seed is the same noise


@dataclass
class Scene:
    name: str
    file: Path
    shift: list
    painted: bool  # its specular surfaces, black

    def reference(self):
        return (read(ROOT / "scenes" / "reference" / f"{self.name}{kind}.exr") for kind in ("", "_stderr"))


def painted_black(file, folder):
    """A copy of the scene whose mirrors and glass are black."""
    black = r'<bsdf type="diffuse" id="\1"><rgb name="reflectance" value="0, 0, 0"/></bsdf>'
    text, n = re.subn(r'<bsdf type="(?:conductor|dielectric)" id="(\w+)">.*?</bsdf>', black, file.read_text(), flags=re.DOTALL)
    copy = folder / f"{file.stem}-black.xml"
    copy.write_text(re.sub(r'(name="filename"\s+value=")', rf"\g<1>{file.parent}/", text))
    return copy if n else None


def all_scenes(folder):
    for name, shift in SHIFTS.items():
        file = ROOT / "scenes" / f"{name}.xml"
        yield Scene(name, file, shift.split(), False)
        if black := painted_black(file, folder):
            yield Scene(name, black, shift.split(), True)


# ---- programs: (scene, spp, seed) -> image, CPU-seconds ----


class Volgrad:
    def __init__(self, renderer, output, shifted):
        self.renderer, self.file, self.shifted = renderer, output / "volgrad.exr", shifted
        self.name = "volgrad, shifts" if shifted else "volgrad"

    def render(self, scene, spp, seed):
        options = ["--spp", str(spp), "--seed", str(seed), "--threads", "1", "--quiet"] + (scene.shift if self.shifted else [])
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([self.renderer, scene.file, "-o", self.file, *options], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return read(self.file), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


class Peer:
    def __init__(self, variant, integrator, process):
        self.name, self.integrator, self.process = f"Mitsuba {variant.split('_')[0]} {integrator}", integrator, process

    def render(self, scene, spp, seed):
        return self.process.render(scene.file, self.integrator, spp, SEED + seed)


def all_programs(renderer, output, some_scene):
    """volgrad's two, and those Mitsubas that run here."""
    programs = [Volgrad(renderer, output, False), Volgrad(renderer, output, True)]
    processes = {variant: Mitsuba(variant, output / "home") for variant, _ in MITSUBAS}
    for variant, integrator in MITSUBAS:
        peer = Peer(variant, integrator, processes[variant])
        try:
            peer.render(some_scene, 1, 0)
            programs.append(peer)
        except BrokenProcessPool:
            print(f"{peer.name}: does not run here, left out (llvm variants need libLLVM, of Debian's libllvm19 for example)", flush=True)
    return programs


# ---- measurement ----


@dataclass
class Cell:
    scene: Scene
    program: object
    spp: int = 0

    def plan(self, seconds):
        """How many samples take so long. The first render may compile something; the second tells the speed."""
        self.program.render(self.scene, PILOT, 0)
        _, pilot = self.program.render(self.scene, PILOT, 1)
        self.spp = max(2, round(PILOT * seconds / pilot))

    def counts(self):
        return {"long": self.spp, "short": max(1, round(self.spp * SHORT))}


def make_cells(scenes, programs, minutes):
    cells = [Cell(s, p) for s in scenes for p in programs if not s.painted or isinstance(p, Volgrad)]
    seconds = 60 * minutes / len(cells) / (ROUNDS + 1) / (1 + SHORT)
    for cell in cells:
        cell.plan(seconds)
        print(f"{cell.scene.file.stem:14} {cell.program.name:26} {cell.spp:6} samples per pixel in {seconds:.1f} s", flush=True)
    return cells


def rows_of_round(cells, number, images):
    """Round 0 warms up: Mitsuba compiles its kernels anew for each sample count."""
    for length in ("long", "short"):
        for cell in cells:
            seed = 2 * number + (length == "short")
            spp = cell.counts()[length]
            image, seconds = cell.program.render(cell.scene, spp, seed + 2)  # after the pilots' seeds
            reference, stderr = cell.scene.reference()
            mse = None if cell.scene.painted else relative_mse(image, reference, stderr)
            scene = cell.scene.name + (", black" if cell.scene.painted else "")
            row = [scene, cell.program.name, length, number, spp, round(seconds, 4), mse, image.mean()]
            if cell.scene.painted:
                images.setdefault((scene, cell.program.name, length), []).append((row, image, reference))
            yield row


def set_variances(images):
    """For scenes without a reference: the error against the mean of all rounds, enlarged by what that mean has in common with each."""
    for renders in images.values():
        renders = [r for r in renders if r[0][3] > 0]
        mean = sum(image for _, image, _ in renders) / len(renders)
        for row, image, reference in renders:
            error, _ = squared_error(reference + image - mean, reference)
            row[6] = error.mean() * len(renders) / (len(renders) - 1)


def measure(cells):
    rows, images = [], {}
    for number in range(ROUNDS + 1):
        rows += rows_of_round(cells, number, images)
        print(f"round {number} of {ROUNDS}", flush=True)
    set_variances(images)
    return rows


def machine(renderer):
    model = re.search(r"model name\s*: (.*)", Path("/proc/cpuinfo").read_text()) if os.path.exists("/proc/cpuinfo") else None
    version = subprocess.run([renderer, "--version"], capture_output=True, text=True).stdout.strip()
    import mitsuba

    return (f"{time.strftime('%Y-%m-%d')}, {model[1] if model else platform.processor()}, {version}, Mitsuba {mitsuba.__version__}, "
            f"one thread each, load of the machine before: {os.getloadavg()[0]:.1f}")


def measure_all(renderer, output, minutes, table):
    (output / "home").mkdir(parents=True, exist_ok=True)
    about = machine(renderer)
    scenes = list(all_scenes(output))
    programs = all_programs(renderer, output, scenes[0])
    rows = measure(make_cells(scenes, programs, minutes))
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
