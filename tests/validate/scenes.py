"""Renders the four scenes by each integrator and unbiased mode and compares the images with the reference images.

Every scene and mode is rendered by RUNS independent runs (seeds 1, 2, ...; bdpt and mmlt with --quick: OTHER_QUICK_RUNS), whose scatter
gives the standard errors. Four checks:

* Means of the image, per channel: the difference lies within MEAN_LIMIT standard errors (of both images) plus the scene's allowance.
* Means of the image against those of the plain runs with the same seeds. These take the same paths, or mutations, so that what remains
  is the noise of the shifts alone, and no reference's error: at most PAIRED_LIMIT.
* Means of blocks of 8x8 pixels, mmlt's of 16x16: z = difference, less the allowance, over the standard error of both. Their distribution
  over the blocks (those with noise: not all sky) and 3 channels is compared with the normal one: the shares beyond 2 and beyond 3, and the
  largest.
* mmlt only: the spread of the image means of TEN_SEEDS seeds is no more than the printed error of the brightness b: (n - 1) times the
  ratio of the variances stays below the point of chi-square that it exceeds once in 1000. On the part `quiet` of the image, where no
  light is seen directly or in glass: that is the path sampler's, and has noise of its own.

Most of mmlt's noise is that of b, which all blocks share and the means have been checked for. For the blocks each image is therefore
divided by its own b, found by least squares over the blocks; light seen directly, rendered alone, is taken out before and put back after.

The allowance is what the references are known to be wrong by (scenes/README.md). As the variance comes from few runs, z is Student's t
with an effective number of degrees of freedom (Welch-Satterthwaite: 15 if all noise is ours, more if the reference has its share); it is
mapped to the normal z of the same probability before anything else.

Significance, if everything is right (36 scenes and modes; channels are so correlated that they count as one):
* means: 36 x 0.27 % = 10 % at an allowance of 0, less with it; mmlt's four modes have the same b, so it is rather 24 x 0.27 %.
* paired: 24 x 0.05 % = 1.2 %.
* spread: 4 x 0.1 %, with --quick, where it is checked on caustic alone, 0.1 %.
* share beyond 2: normal 4.6 %; of 256 independent blocks more than 10 % lie there with probability 2e-4.
* share beyond 3: normal 0.27 %; more than 2 % (5 blocks) with probability 1e-4.
* largest: beyond 5 with probability 6e-7 x 3072 = 0.2 %.
* mmlt's blocks are fewer and their noise is not normal (below): wider limits (SPOTS), from quick runs that had 12 % beyond 2, 3.6 % beyond
  3, and one at -5.0.
Noise in room and caustic is heavy-tailed: a mean of few runs that missed a rare bright path comes with too small a variance, so that more
z lie far out, on the negative side, than Student's t says. Their limits (HEAVY) are wider: in quick runs 5.5 % were seen beyond 2, 1.3 %
beyond 3, and one at -5.0.
Seeds are fixed: a run that passes once passes always, until the sampler takes other paths.

Can it fail?  --break scale and --break albedo spoil the images by 2 % and the media's albedos by 2 %. The former turns everything of the
path sampler red, also with --quick; the latter smoke, cloud and caustic with --quick (room, darker by 1.2 %, is within its noise:
z = 2.8). Of bdpt and mmlt the former turns smoke and cloud red with --quick; of room and caustic too little is rendered there for 2 %. The
column `sees` is the smallest error of the whole image's brightness that is sure to be seen. The check of the spread turns red if the
printed errors are halved.
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

from images import attribute, blocks, exposure_of, read, signed, tonemap, upscale, write_side_by_side

RUNS = 16
OTHER_QUICK_RUNS = 8  # of bdpt and mmlt
TEN_SEEDS = 10
BLOCK = 8
CHAIN_BLOCK = 16  # of mmlt, whose noise comes in spots
UNBIASED = ["none", "exact", "two_level", "exchangeable"]
BIASED = ["first_order", "half_order", "log_linear", "linear_depth"]  # rendered in the long run and shown, not judged
CHAINS = {"mmlt": "none", "mmlt-exact": "exact", "mmlt-two": "two_level", "mmlt-exch": "exchangeable"}
PLAIN = ["none", "bdpt", "mmlt"]

MEAN_LIMIT = 3.0
PAIRED_LIMIT = 3.5
ROUNDING = 1e-6  # of float32 pixels: relative standard error of what has no noise, like a sky seen directly
CHI_SQUARE_LIMIT = 27.88  # of TEN_SEEDS - 1 degrees of freedom: 99.9 %
LUMINANCE = [0.2126, 0.7152, 0.0722]
REFERENCE_RUNS = 32  # a lower limit of what the reference's own errors come from


@dataclass
class Scene:
    name: str
    allowance: float  # relative
    quick: int  # samples per pixel and run: 16 runs by three modes take about 40 s on two cores
    long: int
    heavy: bool
    quick_bootstrap: int  # mmlt's
    quiet: str  # --crop without light seen directly or in glass, but for what has no noise

    @property
    def reference(self):
        return read(SCENE_FILES / "reference" / f"{self.name}.exr")

    @property
    def reference_error(self):
        return read(SCENE_FILES / "reference" / f"{self.name}_stderr.exr")


SCENES = [
    Scene("smoke", 0.004, 12, 64, False, 16384, "0,0,128,128"),
    Scene("room", 0.003, 5, 32, True, 65536, "0,0,128,128"),
    Scene("cloud", 0.003, 10, 64, False, 16384, "0,0,128,128"),
    Scene("caustic", 0.003, 14, 96, True, 16384, "0,0,44,128"),
]
SCENE_FILES = Path(__file__).resolve().parents[2] / "scenes"

# Chains long enough for their beginning not to matter, burn-ins short, passes of the path sampler for what is seen directly.
QUICK_CHAINS = ["--mutations", "1", "--spp", "1", "--chains", "32", "--burn-in", "128"]
LONG_CHAINS = ["--mutations", "8", "--spp", "4", "--chains", "64", "--bootstrap", "524288"]
SPREAD_CHAINS = ["--mutations", "2", "--spp", "1", "--bootstrap", "16384", "--chains", "32", "--burn-in", "128"]
QUICK_BIDIRECTIONAL, LONG_BIDIRECTIONAL = 1, 8  # samples per pixel
DIRECT = ["--max-depth", "1", "--spp", "64"]


@dataclass
class Limits:
    beyond2: float
    beyond3: float
    largest: float


NORMAL = Limits(0.10, 0.02, 5.0)
HEAVY = Limits(0.12, 0.03, 6.0)
SPOTS = Limits(0.16, 0.05, 7.0)  # of mmlt, whose chains stay at bright paths for a while

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


def arguments_of(mode, scene, quick):
    """What tells the renderer about a mode and how much of it."""
    if mode == "bdpt":
        return ["--integrator", "bdpt", "--spp", str(QUICK_BIDIRECTIONAL if quick else LONG_BIDIRECTIONAL)]
    if mode in CHAINS:
        chains = [*QUICK_CHAINS, "--bootstrap", str(scene.quick_bootstrap)] if quick else LONG_CHAINS
        return ["--integrator", "mmlt", "--shift", CHAINS[mode], *chains]
    return ["--shift", mode, "--spp", str(scene.quick if quick else scene.long)]


def render_all(jobs, render, workers):
    """jobs: (scene file, output, seed, arguments). One thread each, as many at once as there are processors."""

    def one(job):
        scene_file, output, seed, arguments = job
        command = [render, scene_file, "-o", output, "--seed", str(seed), "--threads", "1", "--quiet"]
        subprocess.run(command + arguments, check=True)

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


def same_brightness(images, direct, reference):
    """Images of chains, all but what is seen directly divided by the factor that makes most blocks those of the reference."""
    size = CHAIN_BLOCK
    direct_blocks, whole = blocks(direct, size), blocks(reference, size)
    made = whole - direct_blocks
    weight = made / np.maximum(whole, 1e-3 * whole.mean()) ** 2  # noise in proportion to what is seen
    factors = [((blocks(i, size) - direct_blocks) * weight).sum() / (made * weight).sum() for i in images]
    return np.array([direct + (image - direct) / factor for image, factor in zip(images, factors)])


def spread(runs):
    """Standard deviation of the image means of `runs`, files, that of b as they tell it, and chi-square."""
    means = np.array([(read(r) @ LUMINANCE).mean() for r in runs])
    printed = np.array([attribute(r, "brightness") * attribute(r, "brightnessRelativeError") for r in runs])
    deviation, told = means.std(ddof=1), np.sqrt((printed**2).mean())
    return deviation / means.mean(), told / means.mean(), (len(runs) - 1) * (deviation / told) ** 2


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
        limits = SPOTS if self.mode in CHAINS else HEAVY if self.scene.heavy else NORMAL
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
        return " ".join(cells) + "  " + (verdict if self.mode not in BIASED else f"biased, not judged ({verdict})")


HEADER = (
    "                     mean over the reference's                less plain's        blocks: raw z          z less the allowance\n"
    "scene   mode               R       G       B  error  |z|  sees    paired     z     n median   rms    > 2    > 3   min   max"
)


def judge(scene, mode, images, plain, direct):
    reference, reference_error = scene.reference, scene.reference_error
    pixels = reference.shape[0] * reference.shape[1]
    mean = scores(images.mean((1, 2)), reference.mean((0, 1)), np.sqrt((reference_error**2).sum((0, 1))) / pixels, scene.allowance)
    size = CHAIN_BLOCK if mode in CHAINS else BLOCK
    shapes = same_brightness(images, direct, reference) if mode in CHAINS else images
    runs = np.array([blocks(i, size) for i in shapes])
    block = runs, blocks(reference, size), np.sqrt(blocks(reference_error**2, size)) / size
    z, _, error = scores(*block, scene.allowance)
    raw, _, _ = scores(*block, 0)
    paired = (np.zeros(3), np.zeros(3)) if mode in PLAIN else paired_scores(images, plain)
    return Result(scene, mode, *mean, z, raw, error > 10 * ROUNDING, *paired)


# ---- pictures ----

DIFFERENCE_SHOWN = 0.2
Z_SHOWN = 4.0


def draw(path, result, image, reference):
    exposure, scale = exposure_of(reference), 2
    relative = ((image - reference) / (reference + 0.02 * reference.mean())).mean(2)
    z = upscale(signed(result.block_z.mean(2), Z_SHOWN), image.shape[0] // len(result.block_z) * scale)
    write_side_by_side(
        path,
        [
            (f"{result.scene.name}, {result.mode}", upscale(tonemap(image, exposure), scale)),
            ("reference", upscale(tonemap(reference, exposure), scale)),
            (f"difference, red: brighter, +-{DIFFERENCE_SHOWN:.0%}", upscale(signed(relative, DIFFERENCE_SHOWN), scale)),
            (f"z of blocks, +-{Z_SHOWN:.0f}", z),
        ],
    )


# ---- all of it ----


@dataclass
class Plan:
    """The runs of one scene and mode, and what they make."""

    scene: Scene
    file: Path
    mode: str
    arguments: list
    outputs: list

    def jobs(self):
        return [(self.file, output, seed, self.arguments) for seed, output in enumerate(self.outputs, 1)]


def make_plans(arguments, output):
    runs = output / ("runs-of-broken-scenes" if arguments.broken == "albedo" else "runs")
    runs.mkdir(parents=True, exist_ok=True)
    for scene in SCENES:
        modes = UNBIASED + ([] if arguments.quick else BIASED) + ["bdpt", *CHAINS]
        if arguments.quick and scene.name == "room":  # where chains need the long form: rare paths carry much of their light
            modes = [*UNBIASED, "bdpt"]
        file = SCENE_FILES / f"{scene.name}.xml"
        if arguments.broken == "albedo":
            file = broken_scene(file, runs)
        several = lambda name, count: [runs / f"{scene.name}-{name}-{seed}.exr" for seed in range(1, count + 1)]
        yield Plan(scene, file, "direct", DIRECT, several("direct", 1))
        for mode in modes:
            count = OTHER_QUICK_RUNS if arguments.quick and mode not in UNBIASED else RUNS
            yield Plan(scene, file, mode, arguments_of(mode, scene, arguments.quick), several(mode, count))
        if scene.name == "caustic" or not arguments.quick:
            crop = ["--integrator", "mmlt", "--crop", scene.quiet] + SPREAD_CHAINS
            yield Plan(scene, file, "spread", crop, several("spread", TEN_SEEDS))


def check(plan, of_scene, factor, picture):
    """Prints a line about one plan; returns whether it is fine. of_scene: the images that others are compared with, by mode."""
    if plan.mode == "direct":
        of_scene["direct"] = factor * read(plan.outputs[0])
        return True
    if plan.mode == "spread":
        deviation, told, chi_square = spread(plan.outputs)
        good = chi_square < CHI_SQUARE_LIMIT
        ten = f"{len(plan.outputs)} seeds: means spread by {deviation:.2%}, printed error of b {told:.2%}, chi-square {chi_square:.1f}"
        print(f"{plan.scene.name:8}{ten}  {'ok' if good else 'spread'}", flush=True)
        return good
    images = factor * np.array([read(r) for r in plan.outputs])
    if plan.mode in PLAIN:
        of_scene["plain"] = images
    result = judge(plan.scene, plan.mode, images, of_scene["plain"], of_scene["direct"])
    print(result.row(), flush=True)
    draw(picture, result, images.mean(0), plan.scene.reference)
    return plan.mode in BIASED or not any(result.problems())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", default="build/volgrad-render", help="the renderer")
    parser.add_argument("--output", default="build/validate", help="folder of the images and pictures")
    parser.add_argument("--quick", action="store_true", help="few samples: about four minutes on two cores")
    parser.add_argument("--only", nargs="+", help="these modes only, and `direct`, and the plain ones that they are compared with")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="runs rendered at the same time")
    parser.add_argument("--reuse", action="store_true", help="keep what an earlier call has rendered")
    parser.add_argument("--break", dest="broken", choices=["scale", "albedo"], help="spoil the images: the checks must fail")
    arguments = parser.parse_args()
    output = Path(arguments.output)
    plans = [p for p in make_plans(arguments, output) if arguments.only is None or p.mode in ["direct", *arguments.only]]
    render_all([job for p in plans for job in p.jobs() if not (arguments.reuse and job[1].exists())], arguments.render, arguments.jobs)

    print(HEADER)
    factor, prefix = (1.02 if arguments.broken == "scale" else 1), "broken-" if arguments.broken else ""
    verdicts, of_scene = [], {}
    for p in plans:
        good = check(p, of_scene, factor, output / f"{prefix}{p.scene.name}-{p.mode}.png")
        verdicts += [good] if p.mode not in ["direct", *BIASED] else []
    print(f"\npictures: {output}/SCENE-MODE.png\n{sum(verdicts)} passed, {len(verdicts) - sum(verdicts)} failed")
    sys.exit(not all(verdicts))


if __name__ == "__main__":
    main()
