"""What is measured of renders: errors of one image, bias and variance of several, and intervals of what was measured a few times.

All errors of images are relative to the reference, pixel by pixel, and without the reference's own noise (tests/validate/images.py).
"""
import sys
from dataclasses import dataclass
from pathlib import Path

import flip_evaluator
import numpy as np
from scipy import ndimage, stats

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "validate"))

from images import blocks, exposure_of, squared_error, tonemap  # noqa: E402
from scenes import SCENES as VALIDATED  # noqa: E402

BLUR = 2.0  # pixels: the standard deviation of what an eye averages over, and half of the default tile
BLUR_REACH = 8  # pixels
BLOCK = 8  # pixels along a block whose means are compared
REFERENCE_RUNS = 20  # a lower limit of what the reference's standard errors come from
CONFIDENCE = 0.95
TILES = [9, 16]  # pixels


def reference_name(scene):
    """Ours where there is one (references.py), else Mitsuba's."""
    return f"{scene}_volgrad" if (ROOT / "scenes" / "reference" / f"{scene}_volgrad.exr").exists() else scene


# What references are known to be wrong by, relative.
ALLOWANCE = {s.name: s.allowance if reference_name(s.name) == s.name else 0 for s in VALIDATED}


# ---- one image ----


@dataclass
class Reference:
    image: np.ndarray
    stderr: np.ndarray
    outside: np.ndarray  # pixels whose camera rays meet no medium

    def matched(self, image):
        """The image in the reference's resolution."""
        return blocks(image, image.shape[0] // self.image.shape[0])


def reference_at(resolution, image, stderr, outside):
    """In the resolution of renders, if that is lower; a larger one is left to `matched`."""
    size = max(1, image.shape[0] // resolution)
    return Reference(blocks(image, size), np.sqrt(blocks(stderr**2, size)) / size, outside)


def blur(image, power=1):
    """By a Gaussian; power 2: what that makes of the variances of independent pixels."""
    kernel = stats.norm.pdf(np.arange(-BLUR_REACH, BLUR_REACH + 1), scale=BLUR)
    kernel = (kernel / kernel.sum()) ** power
    return ndimage.correlate1d(ndimage.correlate1d(image, kernel, 0), kernel, 1)


def errors(image, reference):
    """By name: relative squared errors per pixel, after blurring and outside of media; FLIP of
    the pictures as they are shown here, from 0 to 1; and the mean."""
    image = reference.matched(image)
    error, noise = squared_error(image, reference.image, reference.stderr)
    blurred, blurred_noise = squared_error(blur(image), blur(reference.image), np.sqrt(blur(reference.stderr**2, 2)))
    seen = [tonemap(i, exposure_of(reference.image)).astype(np.float32) for i in (reference.image, image)]
    _, flip, _ = flip_evaluator.evaluate(*seen, "LDR", applyMagma=False)
    return {
        "relative_mse": (error - noise).mean(),
        "blurred_mse": (blurred - blurred_noise).mean(),
        "outside_mse": (error - noise)[reference.outside].mean() if reference.outside.any() else np.nan,
        "flip": flip,
        "image_mean": image.mean(),
    }


# ---- several images with different seeds ----


def bias_and_variance(images, reference):
    """Means over the pixels of squared bias and variance of one image, relative to the reference; both without bias themselves."""
    n = len(images)
    error, noise = squared_error(images.mean(0), reference.image, reference.stderr)
    weight = 1 / (reference.image**2 + (1e-3 * reference.image.mean()) ** 2)  # as in squared_error
    variance = (images.var(0, ddof=1) * weight).mean()
    return np.array([(error - noise).mean() - variance / n, variance])


def bias_and_variance_errors(images, reference):
    """Standard errors of both, by the jackknife over the images."""
    without_one = np.array([bias_and_variance(np.delete(images, i, 0), reference) for i in range(len(images))])
    return np.sqrt((len(images) - 1) * without_one.var(0))


def share_of_variance(images, whole, reference):
    """What a layer adds to the variance of the images that it is part of, with the same seeds, over that variance; weights as above."""
    weight = 1 / (reference.image**2 + (1e-3 * reference.image.mean()) ** 2)
    around = whole - whole.mean(0)
    return ((images - images.mean(0)) * around * weight).sum() / (around**2 * weight).sum()


def share_of_variance_error(images, whole, reference):
    """Its standard error, by the jackknife over the images."""
    without_one = np.array([share_of_variance(*(np.delete(x, i, 0) for x in (images, whole)), reference) for i in range(len(images))])
    return np.sqrt((len(images) - 1) * without_one.var())


def block_scores(images, reference, allowance):
    """z of the means of blocks against the reference's, less the allowance."""
    ours = np.array([blocks(i, BLOCK) for i in images])
    spread = np.sqrt(blocks(reference.stderr**2, BLOCK)) / BLOCK * np.sqrt(REFERENCE_RUNS)
    target = blocks(reference.image, BLOCK)
    return z_of_means(nearer(ours.mean(0), target, allowance), ours.std(0, ddof=1), len(ours), target, spread)


def nearer(mean, target, allowance):
    """A mean, nearer to the target by what that is known to be wrong by."""
    difference = mean - target
    return target + np.sign(difference) * np.maximum(0, np.abs(difference) - allowance * np.abs(target))


def z_of_means(mean, deviation, count, reference, spread):
    """Welch's test, as the normal z of the same probability."""
    quiet = 1e-6 * np.abs(reference)  # what single precision leaves where there is no noise
    test = stats.ttest_ind_from_stats(mean, np.hypot(deviation, quiet), count, reference, spread, REFERENCE_RUNS, equal_var=False)
    return np.sign(test.statistic) * stats.norm.isf(test.pvalue / 2)


def z_of_reference(means, reference, allowance):
    """Of image means against the reference's, which is known to be wrong by up to the allowance."""
    target = reference.image.mean()
    pixels = reference.stderr.mean(2)  # channels share their paths
    spread = np.sqrt((pixels**2).sum()) / pixels.size * np.sqrt(REFERENCE_RUNS)
    return float(z_of_means(nearer(means.mean(), target, allowance), means.std(ddof=1), len(means), target, spread))


def z_of_pairs(means, others):
    """Of image means against those of runs with the same seeds."""
    difference = means - others
    if np.ptp(difference) == 0:
        return 0.0
    test = stats.ttest_1samp(difference, 0)
    return float(np.sign(test.statistic) * stats.norm.isf(test.pvalue / 2))


# ---- intervals ----


def student(count):
    """Half the width of the interval of a mean of so many, in standard errors."""
    return stats.t.ppf((1 + CONFIDENCE) / 2, count - 1)


def jackknife(statistic, *columns):
    """A statistic of the columns' means, and its standard error. Columns: first axis the rounds."""
    rounds = len(columns[0])
    without_one = np.array([statistic(*(np.delete(c, i, 0).mean(0) for c in columns)) for i in range(rounds)])
    return statistic(*(c.mean(0) for c in columns)), np.sqrt((rounds - 1) * without_one.var(0))


def interval_of_log(statistic, *columns):
    value, error = jackknife(lambda *means: np.log(statistic(*means)), *columns)
    reach = student(len(columns[0])) * error
    return np.exp([value, value - reach, value + reach])


def still(plain, small, large):
    """Share of plain's squared error that no tile takes away. Over tiles of m pixels the error is V(m) = still + moving/m: the part that
    moves becomes the same in all pixels of a tile, with the same mean. From two m follows what remains for m to infinity."""
    return (TILES[1] * large - TILES[0] * small) / (TILES[1] - TILES[0]) / plain


def still_text(plain, small, large):
    share, error = jackknife(still, plain, small, large)
    return f"{share:.0%} ± {student(len(plain)) * error:.0%}"


def mean(column):
    return interval_of_log(lambda x: x, column)


def ratio(above, below):
    return interval_of_log(lambda x, y: x / y, above, below)
