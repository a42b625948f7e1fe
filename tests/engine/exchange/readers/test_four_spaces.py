"""The same light in sRGB, P3, ACEScg and CIE XYZ is the same light as an environment, a photograph and a material."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from numpy.typing import NDArray

from engine.capture.photograph.decode import read_photograph
from engine.exchange.readers.read import open_material
from engine.images.encode import encode_png
from engine.light.environment_file import open_environment

Numbers = NDArray[np.float64]

#: Published matrices from linear sRGB, and chromaticities of red, green, blue and white.
SPACES: dict[str, tuple[Numbers, tuple[float, ...]]] = {
    "sRGB": (np.eye(3), (0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329)),
    "P3": (
        np.array(((0.8224621, 0.1775380, 0.0), (0.0331941, 0.9668058, 0.0), (0.0170827, 0.0723974, 0.9105199))),
        (0.68, 0.32, 0.265, 0.69, 0.15, 0.06, 0.3127, 0.329),
    ),
    "ACEScg": (
        np.array(
            ((0.6130974, 0.3395231, 0.0473795), (0.0701937, 0.9163540, 0.0134523), (0.0206156, 0.1095698, 0.8698146))
        ),
        (0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767),
    ),
    "XYZ": (
        np.array(
            ((0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041))
        ),
        (),
    ),
}

#: Names of the spaces in MaterialX.
NAMES = {"sRGB": "lin_rec709", "P3": "lin_displayp3", "ACEScg": "acescg", "XYZ": "lin_ciexyzd65_scene"}

LIGHT = np.random.default_rng(4).uniform(0.05, 0.9, (8, 16, 3)).astype(np.float64)


def exr(path: Path, space: str, *, states_space: bool = True) -> Path:
    matrix, chromaticities = SPACES[space]
    values = (LIGHT @ matrix.T).astype(np.float32)
    names = "XYZ" if space == "XYZ" and states_space else "RGB"
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if chromaticities and states_space:
        header["chromaticities"] = chromaticities
    channels = {name: np.ascontiguousarray(values[..., place]) for place, name in enumerate(names)}
    with OpenEXR.File(header, channels) as file:
        file.write(str(path))
    return path


def radiance(path: Path, space: str) -> Path:
    """Eight bits of a mantissa for the largest channel of each pixel."""
    matrix, chromaticities = SPACES[space]
    values = LIGHT @ matrix.T
    mantissa, exponent = np.frexp(values.max(axis=2))
    codes = np.rint(values * (mantissa * 256.0 / values.max(axis=2))[..., None]).clip(0, 255)
    form = "xyze" if space == "XYZ" else "rgbe"
    stated = f"PRIMARIES={' '.join(map(str, chromaticities))}\n" if chromaticities else ""
    pixels = np.concatenate([codes, exponent[..., None] + 128], axis=2).astype(np.uint8)
    head = f"#?RADIANCE\nFORMAT=32-bit_rle_{form}\n{stated}\n-Y {len(LIGHT)} +X {LIGHT.shape[1]}\n"
    path.write_bytes(head.encode() + pixels.tobytes())
    return path


def png(path: Path, space: str) -> Path:
    """Linear samples of 16 bits, with the chunks gAMA and cHRM."""
    matrix, chromaticities = SPACES[space]
    codes = np.rint((LIGHT @ matrix.T) * 65535.0).astype(">u2")
    rows = b"".join(b"\0" + row.tobytes() for row in codes)
    order = (*chromaticities[6:], *chromaticities[:6])  # white comes first
    parts = [
        (b"IHDR", struct.pack(">IIBBBBB", LIGHT.shape[1], len(LIGHT), 16, 2, 0, 0, 0)),
        (b"gAMA", struct.pack(">I", 100_000)),
        (b"cHRM", struct.pack(">8I", *(round(100_000 * each) for each in order))),
        (b"IDAT", zlib.compress(rows)),
        (b"IEND", b""),
    ]
    chunks = (
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in parts
    )
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(chunks))
    return path


def show(folder: Path, form: str, space: str) -> Numbers:
    """(8, 16, 3) linear sRGB of the light in a form and a space."""
    if form == "environment, OpenEXR":
        return np.asarray(open_environment(str(exr(folder / "a.exr", space))).radiance, np.float64)
    if form == "environment, Radiance":
        return np.asarray(open_environment(str(radiance(folder / "a.hdr", space))).radiance, np.float64)
    if form == "photograph, OpenEXR":
        return np.asarray(read_photograph(exr(folder / "a.exr", space)).radiance, np.float64)
    if form == "photograph, PNG":
        return np.asarray(read_photograph(png(folder / "a.png", space)).radiance, np.float64)
    if form == "material, folder":
        exr(folder / "rock_base_color.exr", space)
        (folder / "rock_roughness.png").write_bytes(encode_png(np.full((8, 16, 3), 90, np.uint8)))
        found = open_material(folder).pbr
    else:
        exr(folder / "a.exr", space, states_space=False)
        file = f'<input name="file" type="filename" value="a.exr" colorspace="{NAMES[space]}"/>'
        image = f'<image name="i" type="color3">{file}'
        surface = (
            '<gltf_pbr name="s" type="surfaceshader"><input name="base_color" type="color3" nodename="i"/></gltf_pbr>'
        )
        (folder / "a.mtlx").write_text(f'<materialx version="1.39">{image}</image>{surface}</materialx>')
        found = open_material(folder / "a.mtlx").pbr
    assert found is not None
    return np.asarray(found.base_colour, np.float64)


FORMS = (
    *("environment, OpenEXR", "environment, Radiance", "photograph, OpenEXR", "photograph, PNG"),
    *("material, folder", "material, MaterialX"),
)


@pytest.mark.parametrize("form", FORMS)
def test_the_same_light_in_four_spaces_agrees_within_one_percent(tmp_path: Path, form: str) -> None:
    """Root mean square over that of the light; 0.3 % is what the mantissas of Radiance leave."""
    apart = {}
    for space in SPACES:
        if form == "photograph, PNG" and space == "XYZ":
            continue  # no chunk states it
        folder = tmp_path / space
        folder.mkdir()
        difference = show(folder, form, space) - LIGHT
        apart[space] = float(np.sqrt(np.mean(difference**2) / np.mean(LIGHT**2)))
    assert max(apart.values()) < (0.005 if "Radiance" in form else 0.0005), apart
