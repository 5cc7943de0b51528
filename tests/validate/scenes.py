"""Renders the four scenes by each unbiased mode and compares the images with the reference images.

Every scene and mode is rendered by RUNS independent runs (seeds 1, 2, ...), whose scatter gives the standard errors. Three checks:

* Means of the image, per channel: the difference lies within MEAN_LIMIT standard errors (of both images) plus the scene's allowance.
* Means of the image against those of the plain runs with the same seeds. These take the same paths, so that what remains is the noise
  of the shifts alone, and no reference's error: at most PAIRED_LIMIT.
* Means of 8x8 blocks: z = difference, less the allowance, over the standard error of both. Their distribution over the blocks (those
  with noise: not all sky) and 3 channels is compared with the normal one: the shares beyond 2 and beyond 3, and the largest.

The allowance is what the references are known to be wrong by (scenes/README.md). As the variance comes from few runs, z is Student's t
with an effective number of degrees of freedom (Welch-Satterthwaite: 15 if all noise is ours, more if the reference has its share); it is
mapped to the normal z of the same probability before anything else.

Significance, if everything is right (16 scenes and modes; channels are so correlated that they count as one):
* means: 16 x 0.27 % = 4 % at an allowance of 0, less with it.
* paired: 12 x 0.05 % = 0.6 %.
* share beyond 2: normal 4.6 %; of 256 independent blocks more than 10 % lie there with probability 2e-4.
* share beyond 3: normal 0.27 %; more than 2 % (5 blocks) with probability 1e-4.
* largest: beyond 5 with probability 6e-7 x 3072 = 0.2 %.
Noise in room and caustic is heavy-tailed: a mean of few runs that missed a rare bright path comes with too small a variance, so that more
z lie far out, on the negative side, than Student's t says. Their limits (HEAVY) are wider: in quick runs 5.5 % were seen beyond 2, 1.3 %
beyond 3, and one at -5.0.
Seeds are fixed: a run that passes once passes always, until the sampler takes other paths.

Can it fail?  --break scale and --break albedo spoil the images by 2 % and the media's albedos by 2 %. The former turns everything red,
also with --quick; the latter smoke, cloud and caustic with --quick (room, darker by 1.2 %, is within its noise: z = 2.8). The column
`sees` is the smallest error of the whole image's brightness that is sure to be seen.
"""
import argparse
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from images import blocks, exposure_of, read, signed, tonemap, upscale, write_side_by_side

RUNS = 16
BLOCK = 8
UNBIASED = ["none", "exact", "two_level", "exchangeable"]
BIASED = ["first_order", "half_order", "log_linear", "linear_depth"]  # rendered in the long run and shown, not judged

MEAN_LIMIT = 3.0
PAIRED_LIMIT = 3.5
ROUNDING = 1e-6  # of float32 pixels: relative standard error of what has no noise, like a sky seen directly
REFERENCE_RUNS = 32  # a lower limit of what the reference's own errors come from


@dataclass
class Scene:
    name: str
    allowance: float  # relative
    quick: int  # samples per pixel and run: 16 runs by three modes take about 40 s on two cores
    long: int
    heavy: bool


SCENES = [
    Scene("smoke", 0.004, 12, 64, False),
    Scene("room", 0.003, 5, 32, True),
    Scene("cloud", 0.003, 10, 64, False),
    Scene("caustic", 0.003, 14, 96, True),
]


@dataclass
class Limits:
    beyond2: float
    beyond3: float
    largest: float


NORMAL = Limits(0.10, 0.02, 5.0)
HEAVY = Limits(0.12, 0.03, 6.0)

# ---- rendering ----


def broken_scene(scene_file, folder):
    """A copy of the scene whose media absorb more: every albedo times 0.98."""
    text = scene_file.read_text()
    spoil = lambda m: m[1] + ", ".join(f"{0.98 * float(v):.6g}" for v in re.split(r"[,\s]+", m[2].strip())) + '"'
    text = re.sub(r'(name="albedo"\s+value=")([^"]*)"', spoil, text)
    text = re.sub(r'(name="filename"\s+value=")', rf"\g<1>{scene_file.parent.resolve()}/", text)
    copy = folder / scene_file.name
    copy.write_text(text)
    return copy


def render_all(jobs, render, workers):
    """jobs: (scene file, output, mode, seed, spp). One thread each, as many at once as there are processors."""

    def one(job):
        scene_file, output, mode, seed, spp = job
        command = [render, scene_file, "-o", output, "--shift", mode, "--seed", str(seed), "--spp", str(spp), "--threads", "1", "--quiet"]
        subprocess.run(command, check=True)

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(one, jobs))


# ---- statistics ----


def normal_of_t(t, freedom):
    """The normal z as improbable as t of Student's distribution, to 0.01 from 10 degrees of freedom on [Wallace 1959]."""
    return np.sign(t) * (8 * freedom + 1) / (8 * freedom + 3) * np.sqrt(freedom * np.log1p(t * t / freedom))


def scores(runs, reference, reference_error, allowance):
    """z of the runs' mean against the reference, the raw relative difference, and its standard error. runs: first axis the run."""
    n = len(runs)
    ours = runs.var(0, ddof=1) / n + (ROUNDING * reference) ** 2
    theirs = reference_error**2
    error = np.sqrt(ours + theirs)
    freedom = (ours + theirs) ** 2 / (ours**2 / (n - 1) + theirs**2 / (REFERENCE_RUNS - 1))
    difference = runs.mean(0) - reference
    beyond = np.sign(difference) * np.maximum(0, np.abs(difference) - allowance * np.abs(reference))
    return normal_of_t(beyond / error, freedom), difference / reference, error / reference


def paired_scores(runs, plain):
    """Of image means against those of the plain runs with the same seeds, which take the same paths: only shifts differ."""
    difference = (runs - plain).mean((1, 2))
    mean = plain.mean((0, 1, 2))
    error = np.hypot(difference.std(0, ddof=1) / np.sqrt(len(runs)), ROUNDING * mean)
    return normal_of_t(difference.mean(0) / error, len(runs) - 1), difference.mean(0) / mean


@dataclass
class Result:
    scene: Scene
    mode: str
    mean_z: np.ndarray
    mean_difference: np.ndarray
    mean_error: np.ndarray
    block_z: np.ndarray
    raw_block_z: np.ndarray  # without allowance
    noisy: np.ndarray  # blocks that are not all background
    paired_z: np.ndarray
    paired_difference: np.ndarray

    @property
    def beyond(self):
        return [float((np.abs(self.block_z[self.noisy]) > k).mean()) for k in (2, 3)]

    def problems(self):
        limits = HEAVY if self.scene.heavy else NORMAL
        if np.abs(self.mean_z).max() > MEAN_LIMIT:
            yield "mean"
        if np.abs(self.paired_z).max() > PAIRED_LIMIT:
            yield "paired"
        if self.beyond[0] > limits.beyond2:
            yield "blocks > 2"
        if self.beyond[1] > limits.beyond3:
            yield "blocks > 3"
        if np.abs(self.block_z).max() > limits.largest:
            yield "largest block"

    def row(self):
        z, raw = self.block_z[self.noisy], self.raw_block_z[self.noisy]
        verdict = ", ".join(self.problems()) or "ok"
        cells = [f"{self.scene.name:8}{self.mode:13}"]
        cells += [f"{1 + d:7.4f}" for d in self.mean_difference]
        cells += [f"{self.mean_error.max():6.2%}", f"{np.abs(self.mean_z).max():4.1f}"]
        cells += [f"{self.scene.allowance + MEAN_LIMIT * self.mean_error.max():5.1%}"]
        worst = np.abs(self.paired_z).argmax()
        cells += [f"{self.paired_difference[worst]:+8.3%}", f"{self.paired_z[worst]:+5.1f}"]
        cells += [f"{self.noisy.sum():5}", f"{np.median(raw):+6.2f}", f"{np.sqrt((raw * raw).mean()):5.2f}"]
        cells += [f"{b:6.1%}" for b in self.beyond] + [f"{z.min():+5.1f}", f"{z.max():+5.1f}"]
        return " ".join(cells) + "  " + (verdict if self.mode in UNBIASED else f"biased, not judged ({verdict})")


HEADER = (
    "                     mean over the reference's                less plain's        8x8 blocks: raw z      z less the allowance\n"
    "scene   mode               R       G       B  error  |z|  sees    paired     z     n median   rms    > 2    > 3   min   max"
)


def judge(scene, mode, images, plain, reference, reference_error):
    pixels = reference.shape[0] * reference.shape[1]
    mean = scores(images.mean((1, 2)), reference.mean((0, 1)), np.sqrt((reference_error**2).sum((0, 1))) / pixels, scene.allowance)
    runs = np.array([blocks(i, BLOCK) for i in images])
    block = runs, blocks(reference, BLOCK), np.sqrt(blocks(reference_error**2, BLOCK)) / BLOCK
    z, _, error = scores(*block, scene.allowance)
    raw, _, _ = scores(*block, 0)
    paired = (np.zeros(3), np.zeros(3)) if mode == "none" else paired_scores(images, plain)
    return Result(scene, mode, *mean, z, raw, error > 10 * ROUNDING, *paired)


# ---- pictures ----

DIFFERENCE_SHOWN = 0.2
Z_SHOWN = 4.0


def draw(path, result, image, reference):
    exposure, scale = exposure_of(reference), 2
    relative = ((image - reference) / (reference + 0.02 * reference.mean())).mean(2)
    z = upscale(signed(result.block_z.mean(2), Z_SHOWN), BLOCK * scale)
    write_side_by_side(
        path,
        [
            (f"{result.scene.name}, {result.mode}", upscale(tonemap(image, exposure), scale)),
            ("reference", upscale(tonemap(reference, exposure), scale)),
            (f"difference, red: brighter, +-{DIFFERENCE_SHOWN:.0%}", upscale(signed(relative, DIFFERENCE_SHOWN), scale)),
            (f"z of 8x8 blocks, +-{Z_SHOWN:.0f}", z),
        ],
    )


# ---- all of it ----


def plan(arguments, scenes_folder, output):
    """Scene file, spp, and the files of every run by scene and mode."""
    runs = output / ("runs-of-broken-scenes" if arguments.broken == "albedo" else "runs")
    runs.mkdir(parents=True, exist_ok=True)
    modes = UNBIASED if arguments.quick else UNBIASED + BIASED
    for scene in SCENES:
        file = scenes_folder / f"{scene.name}.xml"
        if arguments.broken == "albedo":
            file = broken_scene(file, runs)
        spp = scene.quick if arguments.quick else scene.long
        for mode in modes:
            yield scene, file, mode, spp, [runs / f"{scene.name}-{mode}-{seed}.exr" for seed in range(1, RUNS + 1)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", default="build/volgrad-render", help="the renderer")
    parser.add_argument("--output", default="build/validate", help="folder of the images and pictures")
    parser.add_argument("--quick", action="store_true", help="few samples: about three minutes on two cores")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs rendered at the same time")
    parser.add_argument("--reuse", action="store_true", help="keep what an earlier call has rendered")
    parser.add_argument("--break", dest="broken", choices=["scale", "albedo"], help="spoil the images: the checks must fail")
    arguments = parser.parse_args()
    scenes_folder = Path(__file__).resolve().parents[2] / "scenes"
    output = Path(arguments.output)
    todo = list(plan(arguments, scenes_folder, output))

    jobs = [
        (file, run, mode, seed, spp)
        for _, file, mode, spp, runs in todo
        for seed, run in enumerate(runs, 1)
        if not (arguments.reuse and run.exists())
    ]
    render_all(jobs, arguments.render, arguments.jobs)

    print(HEADER)
    passed = failed = 0
    for scene, _, mode, _, runs in todo:
        reference = read(scenes_folder / "reference" / f"{scene.name}.exr")
        reference_error = read(scenes_folder / "reference" / f"{scene.name}_stderr.exr")
        images = np.array([read(r) for r in runs]) * (1.02 if arguments.broken == "scale" else 1)
        if mode == "none":
            plain = images
        result = judge(scene, mode, images, plain, reference, reference_error)
        print(result.row(), flush=True)
        draw(output / f"{'broken-' if arguments.broken else ''}{scene.name}-{mode}.png", result, images.mean(0), reference)
        if mode in UNBIASED:
            bad = any(result.problems())
            passed, failed = passed + (not bad), failed + bad
    print(f"\npictures: {output}/SCENE-MODE.png\n{passed} passed, {failed} failed")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
