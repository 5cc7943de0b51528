"""Scenes in the resolution of `make figures`, their references, and what is rendered of them, in a folder."""
import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from figures_plan import SCENES
from measures import ROOT, reference_at
from peers import Scene, Volgrad

from images import blocks, read

DIRECT = 4  # passes
TRANSPARENT = 1e-6  # what a camera ray through no medium may lose


@dataclass
class Copy:
    """A scene's file elsewhere, as peers.py wants it."""

    name: str
    file: Path


class Files:
    def __init__(self, folder, resolution):
        self.folder, self.resolution = folder, resolution
        (folder / "renders").mkdir(parents=True, exist_ok=True)

    def scene(self, name, integrator="volpath", change=lambda text: text):
        """A copy; of Mitsuba's other integrator, or changed otherwise."""
        text = (ROOT / "scenes" / f"{name}.xml").read_text()
        text = re.sub(r'(name="(?:width|height)"\s+value=)"128"', rf'\1"{self.resolution}"', text)
        text = text.replace('<integrator type="volpath">', f'<integrator type="{integrator}">')
        text = re.sub(r'(name="filename"\s+value=")', rf"\g<1>{ROOT}/scenes/", text)
        copy = self.folder / f"{name}-{integrator}{'' if change(text) == text else '-lamps'}.xml"
        if not copy.exists():
            copy.write_text(change(text))
        return copy

    def reference(self, name):
        image, stderr = Scene(name).reference()
        outside = blocks(np.repeat(read(self.folder / f"{name}-transmittance.exr").min(2)[..., None], 3, 2), max(1, self.resolution // 128))
        return reference_at(self.resolution, image, stderr, outside[..., 0] > 1 - TRANSPARENT)

    def image(self, job):
        return self.folder / "renders" / f"{hashlib.sha256(job.command.encode()).hexdigest()[:16]}.exr"


def all_lamps(text):
    """Every opaque surface and the sky shine with radiance 1: what is seen directly is the transmittance."""
    lamp = '<emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>'

    def lit(shape):
        return shape[0] if re.search('"(interior|exterior)"|<emitter', shape[0]) else shape[0].replace("</shape>", lamp)

    text = re.sub(r'(name="radiance"\s+value=)"[^"]*"', r'\1"1"', text)
    return re.sub(r"<shape.*?</shape>", lit, text, flags=re.DOTALL)


def render_transmittances(files, renderer):
    for name in SCENES:
        file = files.scene(name, change=all_lamps)
        program = Volgrad("", renderer, files.folder, lambda scene, count: f"--max-depth 1 --spp {count}")
        program.render(Copy(name, file), DIRECT, 0)
        program.file.rename(files.folder / f"{name}-transmittance.exr")


def load(file):
    """volgrad's images are kept as EXR, Mitsuba's as arrays."""
    return read(file) if file.exists() else np.load(file.with_suffix(".npy")).astype(np.float64)
