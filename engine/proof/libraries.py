"""Libraries of others that read our files: MaterialX and Mitsuba draw, USD checks.

MaterialX and Mitsuba run in processes of their own, for a driver that ends a process must not end ours; MaterialX opens
a window, so that a machine without a display needs `xvfb-run`. USD's library for Python draws no images.
"""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from engine.core.directions import normalize
from engine.proof.square import SPHERE, Drawn, Floats, lamp, windows
from engine.storage.atomic import write_bytes

PATIENCE_S = 300

MARK = b"--- image ---\n"

#: Mesa's anisotropic filter, which MaterialX asks for, blurs without a graphics card also where a pixel is a texel.
WITHOUT_ANISOTROPY = "-GL_EXT_texture_filter_anisotropic -GL_ARB_texture_filter_anisotropic"

SQUARE = b"""v -1 -1 0
v 1 -1 0
v 1 1 0
v -1 1 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
vn 0 0 1
f 1/1/1 2/2/1 3/3/1
f 1/1/1 3/3/1 4/4/1
"""


def version_of(package: str) -> str:
    """The version of an installed package, '' where there is none."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return ""


def materialx(folder: Path, surface: str, size: tuple[int, int]) -> Drawn:
    """The document of `folder` as MaterialXRenderGlsl draws the surface of a category, of maps of `size` (H, W)."""
    version = version_of("materialx")
    name = f"MaterialX {version}, {surface}"
    display = with_display()
    if not version:
        return absent("materialx", "MaterialX", "the package materialx is not installed")
    if display is None:
        return absent("materialx", name, "there is no display, and xvfb-run is not installed")
    (document,) = folder.glob("*.mtlx")
    (height, width), shares = windows(size)
    with tempfile.TemporaryDirectory() as place:
        square = Path(place) / "square.obj"
        write_bytes(square, SQUARE)
        numbers = [width, height, shares[1], shares[0], *lamp()]
        child = str(Path(__file__).with_name("materialx_child.py"))
        done = run([*display, sys.executable, child, document, surface, square, *numbers])
    _, mark, answer = done.stdout.partition(MARK)
    if done.returncode or not mark:
        return Drawn("materialx", name, None, f"It draws nothing: {last_line(done)}.", False)
    verdict, _, body = answer.partition(b"\n")
    image = np.frombuffer(body, np.float32).reshape(height, width, 3).astype(np.float64)
    return Drawn("materialx", name, image, f"The document is {verdict.decode()}.", verdict == b"valid")


def mitsuba(folder: Path) -> Drawn:
    """RGL's table of `folder` on a ball under the lamp, as Mitsuba's plugin `measured` shows it."""
    version = version_of("mitsuba")
    if not version:
        return absent("brdf", "Mitsuba", "the package mitsuba is not installed")
    name = f"Mitsuba {version}"
    table = next(iter(folder.glob("*.bsdf")), None)
    if table is None:
        return absent("brdf", name, "the BRDF is anisotropic, and no .bsdf was written")
    wi, wo, mask = on_a_sphere()
    child = str(Path(__file__).with_name("mitsuba_child.py"))
    done = run([sys.executable, child, table], np.column_stack([wi, wo]).tobytes())
    _, mark, body = done.stdout.partition(MARK)
    if done.returncode or not mark:
        return Drawn("brdf", name, None, f"It draws nothing: {last_line(done)}.", False)
    image = np.zeros((*mask.shape, 3))
    image[mask] = np.pi * np.frombuffer(body, np.float64).reshape(-1, 3)
    return Drawn("brdf", f"{name}, measured", image, "It reads the table of RGL's form.")


def on_a_sphere() -> tuple[Floats, Floats, np.ndarray]:
    """Light and view (N, 3) in the frames of a ball seen from afar, where the lamp reaches it, and (H, W) these."""
    x, y = np.meshgrid(*[(np.arange(SPHERE) + 0.5) / (0.5 * SPHERE) - 1.0] * 2)
    y = -y
    inside = x**2 + y**2 < 0.97
    z = np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))
    mask = inside & (x * lamp()[0] + y * lamp()[1] + z * lamp()[2] > 0.02)
    normal = np.column_stack([x[mask], y[mask], z[mask]])
    tangent = normalize(np.column_stack([normal[:, 2], np.zeros(len(normal)), -normal[:, 0]]))
    frame = np.stack([tangent, np.cross(normal, tangent), normal], axis=1)
    return frame @ lamp(), np.ascontiguousarray(frame[:, :, 2]), mask


def usd(folder: Path) -> Drawn:
    """All validators of USD on the package of `folder`."""
    version = version_of("usd-core")
    if not version:
        return absent("usd", "USD", "the package usd-core is not installed")
    from pxr import Usd, UsdValidation

    (package,) = folder.glob("*.usdz")
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    found = [error.GetMessage() for error in context.Validate(Usd.Stage.Open(str(package)))]
    words = f"{len(registry.GetAllValidatorMetadata())} validators: " + ("no complaint" if not found else found[0])
    return Drawn("usd", f"USD {version}", None, f"{words}. Its library draws no images.", not found)


def absent(target: str, name: str, why: str) -> Drawn:
    """A consumer that this machine lacks, and why."""
    return Drawn(target, name, None, f"Not asked: {why}.", None)


def with_display() -> list[str] | None:
    """Words before a command that needs a display; None where there is none and nothing that stands for one."""
    if os.environ.get("DISPLAY") or sys.platform != "linux":
        return []
    server = shutil.which("xvfb-run")
    return None if server is None else [server, "-a"]


def run(words: list[object], given: bytes = b"", patience_s: float = PATIENCE_S) -> subprocess.CompletedProcess[bytes]:
    """A command with `given` on its standard input, ended after `patience_s`."""
    environment = {**os.environ, "MESA_EXTENSION_OVERRIDE": WITHOUT_ANISOTROPY}
    try:
        line = [str(word) for word in words]
        return subprocess.run(line, input=given, capture_output=True, timeout=patience_s, check=False, env=environment)
    except subprocess.TimeoutExpired:
        return subprocess.CompletedProcess([], 1, b"", f"no answer within {patience_s:g} s".encode())


def last_line(done: subprocess.CompletedProcess[bytes]) -> str:
    """The end of what a command said on standard error."""
    lines = done.stderr.decode(errors="replace").strip().splitlines()
    return lines[-1][:200] if lines else "it says nothing"
