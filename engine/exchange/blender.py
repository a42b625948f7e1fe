"""Blender: a script that makes two materials, the textures that they use, and a file that Blender opens as it is.

The first material is a Principled BSDF of the PBR maps, for Cycles and EEVEE. The second looks the power law up behind
*Shader to RGB*: EEVEE's light on a white diffuse surface, times sigma, is r, and the image shows S(r) = scale
(r / r_max)^exponent. That is the look-up outside the integral (`outgoing` in `engine.scene.scene`), with the sigma by
which a Lambertian surface shows the photographs; Cycles gathers no light before it shades, so it shows none of this.

The file is the `.blend` with both materials where Blender's module (`bpy`) is installed beside this program: the script
is run in a process of its own, which takes seconds. Elsewhere it is a `.glb` with the first material, and the script,
which is text, makes the `.blend` in Blender, from its text editor or from the command line.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from math import radians
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.models.diffuse import Lambert
from engine.core.colour import luminance
from engine.core.steps import Step, Steps, part
from engine.exchange import gltf
from engine.exchange.coding import encode
from engine.exchange.layers import none_warnings
from engine.exchange.loss import Shown, View, find_lit_points
from engine.exchange.subject import Contents, Settings, Subject
from engine.exchange.targets import has_blender
from engine.exchange.textures import common_warnings, ior_of, mean_f0_warnings, pack
from engine.images.encode import encode_exr, rgb_channels
from engine.light.environment import DistantLights
from engine.scene.material import Material, auto_sigma
from engine.storage.atomic import make_folder, write_bytes

RESOURCES = Path(__file__).resolve().parents[2] / "resources"

#: Repeats of the material over one unit of texture coordinates.
REPEATS = 2.0

#: Seconds that Blender may take.
PATIENCE_S = 300

_MAPS = (("base_color", "base_colour"), ("roughness", "roughness"), ("metallic", "metallic"), ("normal", "normal"))


def show(subject: Subject, _settings: Settings) -> Shown:
    """The PBR maps in images of 8 bits, with the mean f0."""
    return subject.decode_as("png8", subject.mean_f0, layers=None)


def power_law_shown(subject: Subject, _settings: Settings) -> Shown | None:
    """The power law behind Shader to RGB, which looks up the sum of the light on a white surface; None without one."""
    law, sigma = subject.material.power_law, lambertian_sigma(subject.material)
    if law is None or sigma is None:
        return None

    def show(view: View, lights: DistantLights) -> NDArray[np.float64]:
        gathered = np.zeros((len(view.row), 3))
        for lit, wi, irradiance in find_lit_points(view, lights):
            gathered[lit] += wi[:, 2:] / np.pi * irradiance
        whole = np.asarray(luminance(gathered), np.float64)[:, None]
        share = np.clip(whole * sigma / law.r_max, 0.0, 1.0)
        value = law.scale[view.row, view.column] * share ** law.exponent[view.row, view.column]
        return np.where(share > 0.0, value * gathered / np.maximum(whole, 1e-12), 0.0)

    return subject.remember("behind Shader to RGB", lambda: show)


def contents(subject: Subject, settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.py`, the folder `textures`, and `NAME.blend` where `bpy` is installed, else `NAME.glb`."""
    files: dict[str, bytes] = {}
    law = subject.material.power_law
    for number, (file, source) in enumerate(_MAPS):
        yield Step(0.1 * number, f"writing {file}")
        files[f"textures/{file}.png"] = encode(pack(subject, (source,), "png8"))
    if law is not None:
        yield Step(0.4, "writing the power law")
        files["textures/scale.exr"] = _exr(law.scale)
        files["textures/exponent.exr"] = _exr(law.exponent)
    files[f"{subject.name}.py"] = script(subject, loss).encode()
    warnings = [*common_warnings(subject, ()), *none_warnings(subject.maps.layers)]
    warnings += mean_f0_warnings(subject, "the script")
    if law is None:
        warnings.append("the material has no power law, so there is no material behind Shader to RGB")
    elif law.kept is not None:
        warnings.append("tiles that keep their slices are shown by the power law")
    made = None
    if has_blender():
        yield Step(0.5, "making the .blend")
        made = make_with_blender(subject.name, files)
    if made is not None:
        files[f"{subject.name}.blend"] = made
    else:
        preview = yield from part(gltf.contents(subject, settings, loss), 0.5, 1.0)
        files |= preview.files
        warnings.append(
            f"Blender imports {subject.name}.glb, or opens it where the desktop opens such files with Blender; the "
            f".blend is made by {subject.name}.py, opened and run in Blender's workspace Scripting, or by blender "
            f"--background --python {subject.name}.py"
        )
    return Contents(files, 8.0, tuple(warnings), {"sigma": lambertian_sigma(subject.material), "repeats": REPEATS})


def script(subject: Subject, loss: str) -> str:
    """The script of resources/blender with the numbers of the material."""
    material, law = subject.material, subject.material.power_law
    said = {
        "name": subject.material.name or subject.name,
        "ior": ior_of(subject.mean_f0),
        "repeats": REPEATS,
        "sigma": lambertian_sigma(material),
        "r_max": None if law is None else law.r_max,
        "loss": loss,
    }
    text = (RESOURCES / "blender" / "material.py").read_text(encoding="utf-8")
    words = {"NAME": subject.name, "LOSS": loss, "MATERIAL": json.dumps(said, ensure_ascii=True, allow_nan=False)}
    for name, value in words.items():
        text = text.replace("{{" + name + "}}", value.replace('"""', "'''"))
    return text


def lambertian_sigma(material: Material) -> float | None:
    """The sigma by which a white Lambertian surface shows the photographs; None without a power law."""
    if material.power_law is None:
        return None
    elevation = [radians(each) for each in material.elevation_deg]
    return auto_sigma(Lambert((1.0, 1.0, 1.0)), elevation, material.power_law.r_max)


def make_with_blender(name: str, files: dict[str, bytes], python: str = sys.executable) -> bytes | None:
    """The `.blend` that the script makes, by an interpreter that has `bpy`; None where it makes none."""
    with tempfile.TemporaryDirectory(prefix="lightarc-blender-") as folder:
        for path, content in files.items():
            make_folder(Path(folder, path).parent)
            write_bytes(Path(folder, path), content)
        target = Path(folder, f"{name}.blend")
        try:
            command = [python, str(Path(folder, f"{name}.py")), "--", str(target)]
            subprocess.run(command, check=True, capture_output=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
            return target.read_bytes()
        except (subprocess.SubprocessError, OSError):
            return None


def _exr(values: NDArray[Any]) -> bytes:
    """Colours as half floats."""
    return encode_exr(rgb_channels(np.asarray(values, np.float16)))
