"""Blender on our `.blend`: Cycles draws the PBR maps, EEVEE the power law behind *Shader to RGB*.

Both draw the square of the proof in a process of their own, one sample for a pixel. Cycles takes seconds. EEVEE needs a
display, and without a graphics card some minutes, most of them for compiling its shaders.
"""

from __future__ import annotations

import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from engine.brdf.brdf import brdf_to_text
from engine.brdf.models.diffuse import Lambert
from engine.core.errors import LightarcError
from engine.exchange.blender import REPEATS
from engine.exchange.loss import material_shown
from engine.images.decode import read_image
from engine.proof.libraries import absent, last_line, run, version_of, with_display
from engine.proof.square import AZIMUTH_DEG, TILT_DEG, Drawn, Floats, draw_ourselves, middle, windows
from engine.scene.material import Material

EEVEE_PATIENCE_S = 1200


def cycles(folder: Path, size: tuple[int, int]) -> Drawn:
    """The Principled BSDF of the `.blend` of `folder` under the lamp, of maps of `size` (H, W)."""
    return _draw(folder, size, "Cycles", np.pi)


def eevee(folder: Path, size: tuple[int, int]) -> Drawn:
    """The power law of the `.blend` of `folder` under a lamp of irradiance 1."""
    return _draw(folder, size, "EEVEE", 1.0)


def our_power_law(material: Material) -> Floats | None:
    """Our image of what EEVEE shows: a white diffuse surface looks the power law up; None without one."""
    if material.power_law is None:
        return None
    law = replace(material.power_law, kept=None)
    white = replace(material, power_law=law, brdf=brdf_to_text(Lambert((1.0, 1.0, 1.0))), sigma=None, measured=None)
    return middle(draw_ourselves(material_shown(white, "power-law"), material.size, 1.0))


def _draw(folder: Path, size: tuple[int, int], engine: str, irradiance: float) -> Drawn:
    version = version_of("bpy")
    name = f"Blender {version}, {engine}"
    is_eevee = engine == "EEVEE"
    display = with_display() if is_eevee else []
    if not version:
        return absent("blender", f"Blender, {engine}", "the package bpy is not installed")
    if display is None:
        return absent("blender", name, "there is no display, and xvfb-run is not installed")
    file = next(folder.glob("*.blend"), None)
    if file is None:
        return Drawn("blender", name, None, "No .blend was made.", False)
    asked = {
        "size": size,
        "window": windows(size)[0],
        "repeats": REPEATS,
        "tilt_deg": TILT_DEG,
        "azimuth_deg": AZIMUTH_DEG,
        "irradiance": irradiance,
    }
    material = f"{file.stem} (power law)" if is_eevee else file.stem
    child = str(Path(__file__).with_name("blender_child.py"))
    with tempfile.TemporaryDirectory() as place:
        image = Path(place) / "picture.exr"
        words = [*display, sys.executable, child, file, material, "BLENDER_EEVEE" if is_eevee else "CYCLES", image]
        done = run([*words, json.dumps(asked)], patience_s=EEVEE_PATIENCE_S)
        try:
            pixels = read_image(image).pixels.astype(np.float64)
        except LightarcError:
            return Drawn("blender", name, None, f"It draws nothing: {last_line(done)}.", False)
    return Drawn("blender", name, pixels, f"It draws the material {material!r} of the .blend.")
