"""Pictures of `make figures`: renders beside the references, details, and where they differ."""
import numpy as np
from figures_files import load
from figures_plan import SCENES
from figures_plots import plt, save
from measures import BLUR, blur

from images import exposure_of, signed, tonemap

DIFFERENCE_SHOWN = 0.5  # relative, of one render
BIAS_SHOWN = 0.2  # relative, of the mean over the seeds
# Corners, relative to the image, by colour. Smoke: a ragged edge, the horizon behind its foot, the ground beside it.
DETAILS = {"#009E73": (0.48, 0.30), "#D55E00": (0.36, 0.58), "#0072B2": (0.56, 0.74)}
DETAIL = 0.17  # of the image, along a side


class Renders:
    """The images of a plan's jobs."""

    def __init__(self, jobs, files):
        self.jobs, self.files = jobs, files

    def of(self, experiment, scene, program, count=None):
        """By seed; without a count, of the highest."""
        found = [j for j in self.jobs if (j.experiment, j.scene, j.program.name) == (experiment, scene, program)]
        count = count or max(j.count for j in found)
        reference = self.files.reference(scene)
        return np.array([reference.matched(load(self.files.image(j))) for j in found if j.count == count])

    def counts(self, experiment, scene, program):
        return sorted({j.count for j in self.jobs if (j.experiment, j.scene, j.program.name) == (experiment, scene, program)})


def grid(rows, columns, size=2.2):
    figure, axes = plt.subplots(rows, columns, figsize=(size * columns, size * rows + 0.3), layout="constrained", squeeze=False)
    for a in axes.flat:
        a.set(xticks=[], yticks=[])
        a.spines[:].set_visible(False)
    return figure, axes


def biased(jobs, integrator="mmlt"):
    """The thesis' own estimator, or where the renderer has none the mode nearest to it."""
    names = {j.program.name for j in jobs}
    return next(f"{integrator} {m}" for m in ("thesis", "first_order") if f"{integrator} {m}" in names)


def relative(difference, reference):
    return (difference / (reference + 0.02 * reference.mean())).mean(2)


def bias(images, plain, reference):
    """Of images against others made from the same paths, whose noise they share."""
    return signed(relative(blur((images - plain).mean(0)), blur(reference)), BIAS_SHOWN)


def label(axes, what, limit):
    axes.text(0.5, 0.5, f"{what}\nfull colour: {limit:.0%}", ha="center", va="center")


def details(renders, scene="smoke"):
    """[Lu20, figure 21]"""
    reference = renders.files.reference(scene).image
    exposure, size = exposure_of(reference), reference.shape[0]
    programs = ["mmlt", biased(renders.jobs), "mmlt exchangeable"]
    plain = renders.of("convergence", scene, programs[0])
    figure, axes = grid(3 + len(DETAILS), 1 + len(programs))
    for column, name in zip(axes.T, ["reference", *programs]):
        images = None if name == "reference" else renders.of("convergence", scene, name)
        one = reference if images is None else images[0]
        column[0].imshow(tonemap(one, exposure))
        column[0].set_title(name, fontsize=9)
        for axes_of_detail, (colour, corner) in zip(column[3:], DETAILS.items()):
            x, y = (round(c * size) for c in corner)
            width = round(DETAIL * size)
            column[0].add_patch(plt.Rectangle((x, y), width, width, fill=False, color=colour, linewidth=1))
            axes_of_detail.imshow(tonemap(one[y : y + width, x : x + width], exposure))
            axes_of_detail.spines[:].set(visible=True, color=colour, linewidth=2)
        if images is None:
            label(column[1], "difference of one render\nblue darker, red brighter", DIFFERENCE_SHOWN)
            label(column[2], f"bias: mean of {len(plain)} seeds\nless {programs[0]} of the same chains,\nblurred by {BLUR:g} pixels", BIAS_SHOWN)
        else:
            column[1].imshow(signed(relative(one - reference, reference), DIFFERENCE_SHOWN))
            column[2].imshow(bias(images, plain, reference))
    return figure


def counts(renders, scene="caustic"):
    """[Lu20, figure 22]"""
    reference = renders.files.reference(scene).image
    exposure = exposure_of(reference)
    programs = ["mmlt", biased(renders.jobs), "mmlt exchangeable", "bdpt"]
    steps = renders.counts("convergence", scene, "mmlt")
    figure, axes = grid(len(programs), len(steps) + 1)
    for line, name in zip(axes, programs):
        for a, count in zip(line, steps):
            a.imshow(tonemap(renders.of("convergence", scene, name, count)[0], exposure))
            a.set_title(f"{name}, {count}", fontsize=9)
        line[-1].imshow(tonemap(reference, exposure))
        line[-1].set_title("reference", fontsize=9)
    return figure


def scenes(renders):
    """[Lu20, figure 23], the pictures"""
    programs = ["mmlt", biased(renders.jobs), "mmlt exchangeable", "path", "path exchangeable", "bdpt"]
    figure, axes = grid(len(SCENES), len(programs) + 1)
    for line, scene in zip(axes, SCENES):
        reference = renders.files.reference(scene).image
        for a, name in zip(line, ["reference", *programs]):
            image = reference if name == "reference" else renders.of("convergence", scene, name)[0]
            a.imshow(tonemap(image, exposure_of(reference)))
            a.set_title(name, fontsize=9)
        line[0].set_ylabel(f"{scene}, {renders.counts('convergence', scene, 'mmlt')[-1]} per pixel")
    return figure


def radii(renders, scene="smoke"):
    """[Lu20, figure 24]: one render, and the bias."""
    reference = renders.files.reference(scene).image
    name = biased(renders.jobs)
    settings = [j.program.setting for j in renders.jobs if j.experiment == "radius" and j.program.name.startswith(f"{name} r")]
    settings = list(dict.fromkeys(settings))
    plain = renders.of("radius", scene, "mmlt")
    figure, axes = grid(2, len(settings) + 1)
    axes[0, -1].imshow(tonemap(reference, exposure_of(reference)))
    axes[0, -1].set_title("reference", fontsize=9)
    label(axes[1, -1], f"bias: mean of {len(plain)} seeds\nless mmlt of the same chains,\nblurred by {BLUR:g} pixels", BIAS_SHOWN)
    for column, setting in zip(axes.T, settings):
        images = renders.of("radius", scene, f"{name} {setting}")
        column[0].imshow(tonemap(images[0], exposure_of(reference)))
        column[0].set_title(f"{name}, {setting} px", fontsize=9)
        column[1].imshow(bias(images, plain, reference))
    return figure


PICTURES = {"details": details, "counts": counts, "scenes": scenes, "radii": radii}


def write(jobs, files, folder):
    renders = Renders(jobs, files)
    for name, draw in PICTURES.items():
        save(draw(renders), folder / f"{name}.png")
