"""Every result of section 6 of the thesis [Lu20] again on this code, what it left out, and what others' programs do: `make figures`.

Renders what figures_plan.py lists, one thread each, PROCESSORS at a time, each pinned to a processor of its own. Every render is written
down at once, so that a run that was stopped goes on where it was, as long as renderer, scenes, references and Mitsuba are the same. Then

    experiments/figures/renders.csv    a line per render: command, seed, CPU-seconds, errors, a hash of its bits
    experiments/figures/cells.csv      a line per program, scene and count, over its seeds: bias, variance, z
    build/figures/*.png                plots (figures_plots.py) and pictures (figures_pictures.py)
    build/figures/figures.html         the page with all of it, in one file (figures_page.py)
    README.md                          two of the plots, which are copied into experiments/figures, and tables

CPU-seconds are user + system time: of volgrad-render's whole process, of Mitsuba's render call alone.
Errors: measures.py. At other resolutions than the references' 128 x 128 the finer of the two images is averaged over blocks.
"""
import argparse
import csv
import hashlib
import multiprocessing
import os
import re
import subprocess
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from importlib.metadata import version
from multiprocessing.util import Finalize
from pathlib import Path

import figures_page
import figures_pictures
import numpy as np
from figures_files import Copy, Files, load, render_transmittances
from figures_plan import PEERS, PROCESSORS, SCENES, VARIANTS, make_plan
from measures import (ALLOWANCE, ROOT, bias_and_variance, bias_and_variance_errors, block_scores, errors, share_of_variance,
                      share_of_variance_error, z_of_pairs, z_of_reference)  # fmt: skip
from mitsuba_renders import Mitsuba
from peers import SEED as MITSUBA_SEED
from peers import Volgrad, machine, write_rows

DATA = ROOT / "experiments" / "figures"
MEASURED = ["relative_mse", "blurred_mse", "outside_mse", "flip", "image_mean"]
SETTINGS = ["experiment", "scene", "program", "integrator", "mode", "setting", "count", "seed"]
COLUMNS = [*SETTINGS, "cpu_seconds", *MEASURED, "shifts_per_path", "bits", "command"]
SPREAD = ["bias2", "bias2_error", "variance", "variance_error"]
CELL_COLUMNS = [*SETTINGS[:-1], "seeds", *SPREAD, "z_reference", "z_paired", "energy", "blocks_beyond_2", "share", "share_error"]


# ---- one render, in a process that has a processor to itself ----


class Worker:
    def __init__(self, files, renderer, folder):
        self.files, self.renderer, self.folder = files, renderer, folder
        self.folder.mkdir(parents=True, exist_ok=True)
        self.mitsubas, self.compiled = {}, set()
        self.references = {s: files.reference(s) for s in SCENES}

    def render(self, job):
        """Image, CPU-seconds, and shifts per path."""
        if job.program.variant:
            return *self.render_by_mitsuba(job), ""
        program = Volgrad("", self.renderer, self.folder, lambda scene, count: f"--stats {job.options}")
        image, seconds = program.render(Copy(job.scene, self.files.scene(job.scene)), job.count, job.seed)
        program.file.rename(self.files.image(job))
        return image, seconds, shifts_per_path(program.printed) if job.program.integrator == "path" else ""

    def render_by_mitsuba(self, job):
        variant = job.program.variant
        if variant not in self.mitsubas:
            self.mitsubas[variant] = Mitsuba(variant, self.folder / "home")
        mitsuba = self.mitsubas[variant]
        file = self.files.scene(job.scene, job.program.integrator)
        cell = job.scene, job.program, job.count
        if variant.startswith("llvm") and cell not in self.compiled:
            mitsuba.render(file, job.count, 0)
            self.compiled.add(cell)
        image, seconds = mitsuba.render(file, job.count, MITSUBA_SEED + job.seed)
        np.save(self.files.image(job).with_suffix(".npy"), image.astype(np.float32))
        return image, seconds

    def close(self):
        for mitsuba in self.mitsubas.values():
            mitsuba.close()

    def row(self, job):
        image, seconds, shifts = self.render(job)
        found = errors(image, self.references[job.scene])
        bits = hashlib.sha256(image.astype(np.float32).tobytes()).hexdigest()[:16]
        return [*cell_of(job), job.seed, f"{seconds:.4f}", *(f"{found[m]:.6g}" for m in MEASURED), shifts, bits, job.command]


def shifts_per_path(stats):
    """Of the path sampler."""
    paths, shifts = (float(re.search(rf"^{name} +(\d+)", stats, re.M)[1]) for name in ("paths", "shifts"))
    return f"{shifts / paths:.4f}"


_worker = None


def start_worker(numbers, files, renderer):
    global _worker
    number = numbers.get()
    available = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {available[number % len(available)]})
    _worker = Worker(files, renderer, files.folder / f"worker-{number}")
    Finalize(None, _worker.close, exitpriority=100)  # before the queues to them close, at 10


def work(job):
    return _worker.row(job)


# ---- all renders ----


def read_done(file):
    """Rows of an earlier run; one that was cut off is left out."""
    lines = file.read_text().splitlines()[2:] if file.exists() else []
    return by_command(r for r in csv.reader(lines) if len(r) == len(COLUMNS))


def by_command(rows):
    return {(r[0], r[-1]): r for r in rows}


def key(job):
    return job.experiment, job.command


def measured(jobs, processes, files, renderer):
    """Rows as they come. Seed by seed, so that all programs see the same machine."""
    context = multiprocessing.get_context("spawn")
    numbers = context.Queue()
    for n in range(processes):
        numbers.put(n)
    jobs = sorted(jobs, key=lambda j: j.seed)
    start = time.monotonic()
    with ProcessPoolExecutor(processes, context, start_worker, (numbers, files, renderer)) as pool:
        for n, future in enumerate(as_completed([pool.submit(work, j) for j in jobs]), 1):
            yield future.result()
            if n % 50 == 0 or n == len(jobs):
                print(f"{n} of {len(jobs)} renders, {(time.monotonic() - start) / 60:.1f} minutes", flush=True)


def cell_of(job):
    p = job.program
    return job.experiment, job.scene, p.name, p.integrator, p.mode, p.setting, job.count


def cells(jobs, files):
    """Bias and variance over the seeds."""
    by_cell, references = {}, {s: files.reference(s) for s in SCENES}
    for j in jobs:
        if j.experiment != "repeated":
            by_cell.setdefault(cell_of(j), []).append(j)
    plain = {}  # images without shifts, by the rest of the cell: the same paths, or mutations
    for cell, of_cell in by_cell.items():
        reference = references[cell[1]]
        images = np.array([reference.matched(load(files.image(j))) for j in of_cell])
        means = images.mean((1, 2, 3))
        _, scene, _, integrator, mode, _, count = cell
        if mode == "none":
            plain[scene, integrator, count] = images
        paired = plain.get((scene, integrator, count))
        pairs, share = ["", ""], ["", ""]  # z, and the relative difference; of a layer, in the variance
        if mode != "none" and paired is not None:
            others = paired.mean((1, 2, 3))
            pairs = [f"{z_of_pairs(means, others):.2f}", f"{means.mean() / others.mean() - 1:.6g}"]
        if mode == "layer":
            share = [f"{f(images, paired, reference):.6g}" for f in (share_of_variance, share_of_variance_error)]
        (bias2, variance), (bias2_error, variance_error) = bias_and_variance(images, reference), bias_and_variance_errors(images, reference)
        beyond = (np.abs(block_scores(images, reference, ALLOWANCE[scene])) > 2).mean()
        numbers = [bias2, bias2_error, variance, variance_error]
        z = z_of_reference(means, reference, ALLOWANCE[scene])
        yield [*cell, len(images), *(f"{v:.6g}" for v in numbers), f"{z:.2f}", *pairs, f"{beyond:.4f}", *share]


def resolution(text):
    """That references can be compared in."""
    pixels = int(text)
    if pixels <= 0 or (128 % pixels and pixels % 128):
        raise argparse.ArgumentTypeError(f"{pixels} is neither a divisor nor a multiple of 128")
    return pixels


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", default="build/volgrad-render", help="the renderer")
    parser.add_argument("--output", default="build/figures", help="folder for what is not kept")
    parser.add_argument("--minutes", type=float, default=40, help="of rendering on two processors, roughly")
    parser.add_argument("--resolution", type=resolution, default=128, help="pixels along a side: 128 divided or multiplied by a whole number")
    parser.add_argument("--processes", type=int, default=PROCESSORS, help="renders at a time")
    parser.add_argument("--report", action="store_true", help="render nothing, write the plots and the page of the CSV files anew")
    arguments = parser.parse_args()
    output = Path(arguments.output).resolve()
    if not arguments.report:
        measure(arguments, output)
    figures_page.write(DATA, output)


def measure(arguments, output):
    renderer = str(Path(arguments.render).resolve())
    files = Files(output / f"{inputs_hash(renderer)}-{arguments.resolution}", arguments.resolution)
    DATA.mkdir(exist_ok=True)
    render_transmittances(files, renderer)
    for name in SCENES:
        for integrator in PEERS:
            files.scene(name, integrator)
    plan = make_plan(arguments.minutes, arguments.resolution, help_of(renderer), list(usable_variants(files)))
    table = files.folder / "renders.csv"
    done = read_done(table)
    left = [j for j in plan.jobs if key(j) not in done]
    print(f"{len(plan.jobs)} renders, {len(plan.jobs) - len(left)} of them done before", flush=True)
    about = f"Mitsuba {version('mitsuba')}, {machine(renderer)}, {arguments.minutes:g} minutes planned, {arguments.resolution} x {arguments.resolution} pixels"
    replace_table(table, about, COLUMNS, done.values())
    add_rows(table, measured(left, arguments.processes, files, renderer))
    done = read_done(table)
    replace_table(DATA / "renders.csv", about, COLUMNS, (done[key(j)] for j in plan.jobs))
    replace_table(DATA / "cells.csv", about, CELL_COLUMNS, cells(plan.jobs, files))
    figures_pictures.write(plan.jobs, files, output)


def inputs_hash(renderer):
    """Of what renders and their errors depend on, beside the command."""
    found = hashlib.sha256(version("mitsuba").encode())
    scenes = sorted(f for f in (ROOT / "scenes").rglob("*") if f.suffix in (".xml", ".vol", ".exr"))
    for file in (Path(renderer), *scenes):
        found.update(file.read_bytes())
    return found.hexdigest()[:8]


def replace_table(file, about, columns, rows):
    """All or nothing: who is stopped in between leaves the old one."""
    new = file.with_suffix(".new")
    write_rows(new, about, columns, rows)
    new.replace(file)


def add_rows(table, rows):
    """Each as soon as it is there."""
    with open(table, "a", newline="", buffering=1) as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


def usable_variants(files):
    for variant in VARIANTS:
        mitsuba = Mitsuba(variant, files.folder / "home")
        try:
            mitsuba.render(files.scene("smoke"), 1, 0)
            yield variant
        except BrokenProcessPool:
            print(f"Mitsuba {variant} does not run here, left out (llvm variants need libLLVM, of Debian's libllvm19 for example)", flush=True)
        mitsuba.close()


def help_of(renderer):
    return subprocess.run([renderer, "--help"], check=True, capture_output=True, text=True).stdout


if __name__ == "__main__":
    main()
