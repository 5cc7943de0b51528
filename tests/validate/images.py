"""Images as numpy arrays: reading EXR, errors against a reference, pictures to look at."""
import numpy as np
import OpenEXR
from PIL import Image, ImageDraw

GAP = 6  # pixels between the parts of a picture
CAPTION = 16


def read(path):
    """Linear RGB, float64, of shape (height, width, 3)."""
    with OpenEXR.File(str(path)) as file:
        channels = file.channels()
        rgb = channels["RGB"].pixels if "RGB" in channels else np.dstack([channels[c].pixels for c in "RGB"])
        return rgb.astype(np.float64)


def attribute(path, name):
    """A number in an EXR's header."""
    with OpenEXR.File(str(path)) as file:
        return float(np.ravel(file.header()[name])[0])


def blocks(image, size):
    """Means of size x size blocks; what is left over at the right and the bottom is dropped."""
    h, w = (n // size for n in image.shape[:2])
    return image[: h * size, : w * size].reshape(h, size, w, size, 3).mean((1, 3))


def squared_error(image, reference, stderr=None, size=1):
    """Relative squared error per block of size x size pixels and channel, and the reference's share of it."""
    if stderr is None:
        stderr = np.zeros_like(reference)
    floor = 1e-3 * reference.mean()  # so that a black pixel does not count without end
    r = blocks(reference, size)
    weight = 1 / (r**2 + floor**2)
    return (blocks(image, size) - r) ** 2 * weight, blocks(stderr**2, size) / size**2 * weight


def relative_mse(image, reference, stderr=None, size=1):
    """Mean relative squared error without the reference's noise; may come out negative where that noise is most of it."""
    error, noise = squared_error(image, reference, stderr, size)
    return error.mean() - noise.mean()


# ---- pictures: arrays of shape (h, w, 3) in 0...1 ----


def tonemap(image, exposure):
    """Linear to sRGB."""
    x = np.clip(image * exposure, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def exposure_of(reference):
    """What maps all but the brightest hundredth to below white."""
    return 1 / np.quantile(reference.max(2), 0.99)


def signed(values, limit):
    """Blue below 0, white at 0, red above; saturated at the limit."""
    x = np.clip(values / limit, -1, 1)[..., None]
    red, blue = np.array([0.75, 0.05, 0.1]), np.array([0.05, 0.2, 0.75])
    return 1 - np.abs(x) * (1 - np.where(x > 0, red, blue))


def upscale(picture, factor):
    return picture.repeat(factor, 0).repeat(factor, 1)


def write_png(path, picture):
    Image.fromarray(np.round(255 * np.clip(picture, 0, 1)).astype(np.uint8)).save(path)


def write_side_by_side(path, parts):
    """parts: (caption, picture), all of the same height."""
    height = max(p.shape[0] for _, p in parts)
    width = sum(p.shape[1] + GAP for _, p in parts) - GAP
    sheet = Image.new("RGB", (width, height + CAPTION), "white")
    draw, x = ImageDraw.Draw(sheet), 0
    for caption, picture in parts:
        draw.text((x + 2, 2), caption, fill="black")
        sheet.paste(Image.fromarray(np.round(255 * np.clip(picture, 0, 1)).astype(np.uint8)), (x, CAPTION))
        x += picture.shape[1] + GAP
    sheet.save(path)
