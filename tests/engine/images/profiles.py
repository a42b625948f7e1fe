"""ICC profiles as other programs write them, for tests: curves with primaries, grey curves, and tables."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

#: White of the connection space and D65 in XYZ (ICC.1:2022, 6.3.4.3; CIE 015).
D50, D65 = np.array([0.96422, 1.0, 0.82521]), np.array([0.95047, 1.0, 1.08883])

#: Bradford's adaptation of D65 to D50 as Lindbloom publishes it.
D50_FROM_D65 = np.array(
    [[1.0478112, 0.0228866, -0.0501270], [0.0295424, 0.9904844, -0.0170491], [-0.0092345, 0.0150436, 0.7521316]]
)

#: Linear colours to XYZ as Lindbloom publishes them, for the white of the space, and whether that is D50.
MATRICES: dict[str, tuple[Any, bool]] = {
    "sRGB": (
        [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]],
        False,
    ),
    "Adobe RGB": (
        [[0.5767309, 0.1855540, 0.1881852], [0.2973769, 0.6273491, 0.0752741], [0.0270343, 0.0706872, 0.9911085]],
        False,
    ),
    "ProPhoto RGB": (
        [[0.7976749, 0.1351917, 0.0313534], [0.2880402, 0.7118741, 0.0000857], [0.0, 0.0, 0.8252100]],
        True,
    ),
    "eciRGB v2": (
        [[0.6502043, 0.1780774, 0.1359384], [0.3202499, 0.6020711, 0.0776791], [0.0, 0.0678390, 0.7573710]],
        True,
    ),
    # Apple's "Display P3" and ITU-R BT.2020, from their chromaticities.
    "Display P3": (
        [[0.4865709, 0.2656677, 0.1982173], [0.2289746, 0.6917385, 0.0792869], [0.0, 0.0451134, 1.0439444]],
        False,
    ),
    "Rec.2020": (
        [[0.6369580, 0.1446169, 0.1688810], [0.2627002, 0.6779981, 0.0593017], [0.0, 0.0280727, 1.0609851]],
        False,
    ),
}

#: sRGB, linear, from XYZ (D65), as Lindbloom publishes it.
SRGB_FROM_XYZ = np.array(
    [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560], [0.0556434, -0.2040259, 1.0572252]]
)


def _srgb(x: Any) -> Any:
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def _bt709(x: Any) -> Any:
    return np.where(x < 0.081, x / 4.5, ((x + 0.099) / 1.099) ** (1 / 0.45))


def _lightness(x: Any) -> Any:
    return np.where(x > 0.08, ((x + 0.16) / 1.16) ** 3, x * 100 / 903.2963)


#: Curves of spaces: the formula, and how a profile states it.
CURVES: dict[str, tuple[Callable[[Any], Any], bytes]] = {}


def curve_tag(samples: Any) -> bytes:
    values = np.rint(np.asarray(samples) * 65535).astype(">u2")
    return b"curv\0\0\0\0" + struct.pack(">I", len(values)) + values.tobytes()


def gamma_tag(exponent: float) -> bytes:
    return b"curv\0\0\0\0" + struct.pack(">IH", 1, round(exponent * 256))


def para_tag(kind: int, *numbers: float) -> bytes:
    fixed = [round(number * 65536) for number in numbers]
    return b"para\0\0\0\0" + struct.pack(f">HH{len(fixed)}i", kind, 0, *fixed)


_SRGB_TAG = para_tag(3, 2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045)
CURVES.update(
    {
        "sRGB": (_srgb, _SRGB_TAG),
        "Adobe RGB": (lambda x: x ** (563 / 256), gamma_tag(563 / 256)),
        "Display P3": (_srgb, _SRGB_TAG),
        "ProPhoto RGB": (lambda x: x**1.80078125, gamma_tag(1.80078125)),
        "Rec.2020": (_bt709, para_tag(3, 1 / 0.45, 1 / 1.099, 0.099 / 1.099, 1 / 4.5, 0.081)),
        "eciRGB v2": (_lightness, curve_tag(_lightness(np.linspace(0, 1, 4096)))),
        "linear": (lambda x: x, b"curv\0\0\0\0\0\0\0\0"),
    }
)


def xyz_tag(xyz: Any) -> bytes:
    return b"XYZ \0\0\0\0" + struct.pack(">3i", *(round(float(value) * 65536) for value in xyz))


def name_tag(name: str) -> bytes:
    text = name.encode("latin-1") + b"\0"
    return b"desc\0\0\0\0" + struct.pack(">I", len(text)) + text + bytes(78)


def profile(
    tags: Mapping[str, bytes], model: bytes = b"RGB ", kind: bytes = b"mntr", connection: bytes = b"XYZ "
) -> bytes:
    start = 128 + 4 + 12 * len(tags)
    entries, bodies = b"", b""
    for name, body in tags.items():
        entries += struct.pack(">4sII", name.encode(), start + len(bodies), len(body))
        bodies += body + bytes(-len(body) % 4)
    header = struct.pack(">I4sI4s4s4s", start + len(bodies), b"none", 0x02400000, kind, model, connection)
    header += struct.pack(">6H4s", 2020, 1, 1, 0, 0, 0, b"acsp") + bytes(28) + struct.pack(">3i", 63190, 65536, 54061)
    return header.ljust(128, b"\0") + struct.pack(">I", len(tags)) + entries + bodies


def to_d50(name: str) -> Any:
    """Linear colours of a space to XYZ under D50."""
    matrix, is_d50 = MATRICES[name]
    return np.array(matrix) if is_d50 else D50_FROM_D65 @ np.array(matrix)


def matrix_profile(name: str, curve: str) -> bytes:
    columns = to_d50(name).T
    tags = {"desc": name_tag(f"{name} with {curve} curve"), "wtpt": xyz_tag(D50)}
    tags.update({f"{letter}XYZ": xyz_tag(column) for letter, column in zip("rgb", columns, strict=True)})
    return profile({**tags, **{f"{letter}TRC": CURVES[curve][1] for letter in "rgb"}})


def rec709(xyz_d50: Any) -> Any:
    """Linear Rec. 709 of XYZ under D50."""
    return xyz_d50 @ (SRGB_FROM_XYZ @ np.linalg.inv(D50_FROM_D65)).T


def matrix_truth(name: str, curve: str, samples: Any) -> Any:
    return rec709(CURVES[curve][0](samples) @ to_d50(name).T)


def grey_profile(curve: str) -> bytes:
    tags = {"desc": name_tag(f"grey with {curve} curve"), "wtpt": xyz_tag(D50), "kTRC": CURVES[curve][1]}
    return profile(tags, b"GRAY")


_CROSSTALK = np.array([[0.90, 0.08, 0.02], [0.05, 0.90, 0.05], [0.02, 0.10, 0.88]])
_GRID = 33


def scanner_truth(samples: Any) -> Any:
    return rec709(_scanner(samples))


def _scanner(samples: Any) -> Any:
    """XYZ of a scanner with crosstalk that grows with the signal, which no matrix describes."""
    linear = np.asarray(samples) ** 2.0
    mixed = linear @ _CROSSTALK.T
    bent = mixed + 0.08 * mixed[..., [1, 2, 0]] * (1.0 - mixed)
    return bent @ to_d50("sRGB").T


def scanner_profile(tag: str = "A2B0") -> bytes:
    """A table of 16 bits (mft2) with curves before it, to XYZ."""
    grid = np.linspace(0, 1, _GRID)
    values = _scanner(np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1) ** 0.5)
    table = np.rint(np.clip(values, 0, 1.99) * 32768).astype(">u2").tobytes()
    before = np.rint(np.linspace(0, 1, 4096) ** 2.0 * 65535).astype(">u2").tobytes() * 3
    after = np.array([0, 65535], ">u2").tobytes() * 3
    unit = struct.pack(">9i", *(65536 * value for value in (1, 0, 0, 0, 1, 0, 0, 0, 1)))
    body = b"mft2\0\0\0\0" + struct.pack(">4B", 3, 3, _GRID, 0) + unit + struct.pack(">HH", 4096, 2)
    tags = {"desc": name_tag("a scanner"), "wtpt": xyz_tag(D50), tag: body + before + table + after}
    return profile(tags, kind=b"scnr")
