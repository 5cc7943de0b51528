"""Reference images of our own where Mitsuba's are too noisy (room, caustic): `make references`.

Each is the mean of independent renders of one thread and a seed of its own, its standard error what their scatter tells. Renders are kept in
the output folder, and one that is there is not made again: a run that was stopped goes on, and goes on with more of them, whichever version of
the renderer made the first. Each has the command of its recipe; neither lets the clock decide how much is rendered: the same seeds, the same bits.

Checked against Mitsuba's references as tests/validate/scenes.py checks renders, but that nothing is known to be wrong here: image means,
and means of blocks. Writes scenes/reference/NAME_volgrad.exr, NAME_volgrad_stderr.exr, and the table in scenes/README.md.
"""
import argparse
import hashlib
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
from measures import ROOT
from tables import markdown, replace_between_markers

from images import read, squared_error
from scenes import BLOCK, HEAVY, MEAN_LIMIT, SCENES, judge

# The samplers with the lowest relative error per time of each scene (`make figures`), and how many renders take it to 1 %.
RECIPES = {
    "room": ("--integrator bdpt --spp 512 --shift exchangeable --shift-count 35", 32),
    "caustic": ("--integrator bdpt --spp 512", 20),
}
# No seed is used elsewhere.
FIRST_SEED = 3_000_000
README = ROOT / "scenes" / "README.md"
HEADER = ["reference", "made by, mean of seeds", "rms relative standard error of a pixel", "pixels within 1 %", "image mean over Mitsuba's (RGB)",
          "\\|z\\|", f"means of blocks of {BLOCK} x {BLOCK}: beyond 2, beyond 3, largest z"]  # fmt: skip


def render(renderer, name, seed, file):
    if file.exists():
        return
    scene, unfinished = ROOT / "scenes" / f"{name}.xml", file.with_suffix(".part.exr")
    options = ["--seed", str(seed), "--threads", "1", "--quiet", *RECIPES[name][0].split()]
    subprocess.run([renderer, scene, "-o", unfinished, *options], check=True)
    unfinished.rename(file)


def write(file, image):
    with OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": image.astype(np.float32)}) as exr:
        exr.write(str(file))


def file_of(output, name, seed):
    """Another recipe makes other files."""
    recipe = hashlib.sha256(RECIPES[name][0].encode()).hexdigest()[:8]
    return output / f"{name}-{recipe}-{seed}.exr"


def combine(scene, files):
    """Mean and standard error, the table's row, and whether all is well."""
    images = np.array([read(f) for f in files])
    mean, stderr = images.mean(0), images.std(0, ddof=1) / np.sqrt(len(images))
    result = judge(replace(scene, allowance=0), "none", images, None, None)
    _, noise = squared_error(mean, mean, stderr)
    z = np.abs(result.mean_z).max()
    beyond, largest = result.beyond, np.abs(result.block_z).max()
    row = [
        f"`{scene.name}_volgrad.exr`",
        f"`{RECIPES[scene.name][0]} --seed N`, N = {FIRST_SEED} to {FIRST_SEED + len(files) - 1}",
        f"{np.sqrt(noise.mean()):.2%}",
        f"{(noise.mean(2) < 1e-4).mean():.0%}",
        " ".join(f"{1 + d:.4f}" for d in result.mean_difference) + f" ± {result.mean_error.max():.4f}",
        f"{z:.1f}",
        f"{beyond[0]:.1%}, {beyond[1]:.1%}, {largest:.1f}",
    ]
    good = z <= MEAN_LIMIT and beyond[0] <= HEAVY.beyond2 and beyond[1] <= HEAVY.beyond3 and largest <= HEAVY.largest
    return mean, stderr, row, good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--render", default="build/volgrad-render", help="the renderer")
    parser.add_argument("--output", default="build/references", help="folder of the renders")
    parser.add_argument("--jobs", type=int, default=2, help="renders at a time")
    arguments = parser.parse_args()
    output = Path(arguments.output)
    output.mkdir(parents=True, exist_ok=True)
    files = {name: [file_of(output, name, FIRST_SEED + i) for i in range(runs)] for name, (_, runs) in RECIPES.items()}
    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(pool.map(lambda job: render(arguments.render, *job), [(n, FIRST_SEED + i, f) for n in files for i, f in enumerate(files[n])]))
    scenes = [s for s in SCENES if s.name in files]
    found = [combine(s, files[s.name]) for s in scenes]
    for _, _, row, _ in found:
        print(" ".join(row))
    if not all(good for *_, good in found):
        raise SystemExit("a reference disagrees with Mitsuba's: nothing is written")
    for scene, (mean, stderr, _, _) in zip(scenes, found):
        for ending, image in (("", mean), ("_stderr", stderr)):
            write(ROOT / "scenes" / "reference" / f"{scene.name}_volgrad{ending}.exr", image)
    replace_between_markers(README, "references", markdown(HEADER, [row for _, _, row, _ in found]))


if __name__ == "__main__":
    main()
