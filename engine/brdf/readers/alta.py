"""ALTA's text files of measurements (`.dat`; Belcour, Barla and Pacanowski, https://alta.gforge.inria.fr).

Header lines `#DIM nx ny`, `#PARAM_IN name`, `#PARAM_OUT name`, `#VS n` (0, 1 or 2 confidence limits follow the values:
they are not used), other lines from `#` are comments; then rows of nx coordinates and ny values. Angles in radians.
The parametrisations are those of ALTA's `params`, in which L is the light and V the view; for the half-angle ones V is
the difference vector turned into the frame of the half vector, L its mirror image. Those with fewer than three
coordinates do not fix the directions; as in ALTA, what is missing is then taken as 0 (phi_d of RUSIN_TH_TD as 90°),
which `health` says. Values: INV_STERADIAN, RGB_COLOR (linear sRGB), XYZ_COLOR, and INV_STERADIAN_COSINE_FACTOR, which
holds the cosine of the outgoing direction and is divided by it; without a name INV_STERADIAN is meant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.brdf.readers.text import Line, head_lines, numbers, read_lines, refuse, table
from engine.brdf.samples import BrdfSamples, samples_from_rows
from engine.brdf.spectrum import srgb_from_measured_xyz
from engine.core.directions import surface_direction
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.storage.untrusted import AGAIN

Column = NDArray[np.float64]
Pair = tuple[Column, Column]


def looks_like_alta(head: bytes, size_bytes: int, name: str) -> bool:
    """True where a line names dimensions or coordinates as ALTA does."""
    for line in head_lines(head):
        words = line[1:].split(maxsplit=3) if line.startswith("#") else []
        if words[:1] == ["DIM"] and len(words) > 2 and words[1].isdigit() and words[2][0].isdigit():
            return True
        if words[:1] == ["PARAM_IN"] and len(words) > 1 and words[1][0].isupper():
            return True
    return False


def read_alta(path: Path) -> BrdfSamples:
    """The samples of an ALTA text file; InputError names what is not known, or the line that is wrong."""
    lines = read_lines(path)
    header = _header(path, lines)
    if header.get("FORMAT", Line(0, "text")).text.lower() != "text":
        raise InputError(path, "is ALTA's binary form", "Convert it to text with ALTA's data2data")
    coordinates, outputs = _dimensions(path, header)
    stated = header.get("PARAM_IN", Line(lines[0].number, "UNKNOWN_INPUT"))
    if stated.text not in PARAMETRISATIONS:
        refuse(
            path,
            stated.number,
            f"names unknown coordinates {stated.text[:40]!r}; choose from {', '.join(PARAMETRISATIONS)}",
        )
    needed, to_directions = PARAMETRISATIONS[stated.text]
    if needed != coordinates:
        refuse(path, stated.number, f"names {stated.text}, which has {needed} coordinates, but #DIM says {coordinates}")
    data = _rows(path, lines, coordinates, outputs)
    with np.errstate(all="ignore"):
        view, light = to_directions(*data[:, :coordinates].T)
        values = _values(path, header, data[:, coordinates:], view)
    findings = []
    if coordinates < 3 or stated.text == "RUSIN_VH":
        text = f"{stated.text} does not fix both directions; the missing angles are taken as ALTA takes them"
        findings.append(Finding(Verdict.WARNING, text))
    return samples_from_rows(path, "ALTA samples", light, view, values, findings=findings)


def _header(path: Path, lines: list[Line]) -> dict[str, Line]:
    header: dict[str, Line] = {}
    for line in lines:
        words = line.text[1:].split(maxsplit=1) if line.text.startswith("#") else []
        if words:
            header.setdefault(words[0], Line(line.number, "".join(words[1:])))
    return header


def _dimensions(path: Path, header: dict[str, Line]) -> tuple[int, int]:
    if "DIM" not in header:
        raise InputError(path, "has no line #DIM with its dimensions", AGAIN)
    line, text = header["DIM"]
    words = text.split()
    if len(words) != 2 or not all(word.isdecimal() and len(word) <= 3 for word in words):
        refuse(path, line, f"has {text[:40]!r} where two dimensions are needed")
    coordinates, outputs = map(int, words)
    if outputs not in (1, 3):
        refuse(path, line, f"says {outputs} values per sample; 1 (grey) or 3 (colour) are read")
    return coordinates, outputs


def _rows(path: Path, lines: list[Line], coordinates: int, outputs: int) -> NDArray[np.float64]:
    """The coordinates and values (N, nx + ny); columns of confidence limits after them are left out."""
    width = coordinates + outputs
    rows = []
    for line in lines:
        if line.text.startswith("#"):
            continue
        words = line.text.split()
        if not width <= len(words) <= width + 2 * outputs:
            refuse(path, line.number, f"has {len(words)} values where {width} are needed")
        rows.append(numbers(path, line.number, words[:width]))
    return table(path, rows)


def _values(path: Path, header: dict[str, Line], values: NDArray[np.float64], view: Column) -> NDArray[np.float64]:
    stated = header.get("PARAM_OUT", Line(1, "INV_STERADIAN"))
    name = stated.text or "INV_STERADIAN"
    if name in ("INV_STERADIAN", "RGB_COLOR", "UNKNOWN_OUTPUT"):
        return values
    if name in ("INV_STERADIAN_COSINE_FACTOR", "INV_STERADIAN_COS_FACTOR"):
        return values / view[:, 2:]
    if name != "XYZ_COLOR" or values.shape[1] != 3:
        known = "INV_STERADIAN, INV_STERADIAN_COSINE_FACTOR, RGB_COLOR, XYZ_COLOR (3 values)"
        refuse(path, stated.number, f"names unknown values {name[:40]!r}; choose from {known}")
    return srgb_from_measured_xyz(values)


def _project(x: Column, y: Column) -> Column:
    """The direction (N, 3) whose angle from the normal is |(x, y)|, towards (x, y)."""
    theta = np.hypot(x, y)
    scale = np.sinc(theta / math.pi)
    return np.stack([x * scale, y * scale, np.cos(theta)], axis=-1)


def _mirror(vector: Column, axis: Column) -> Column:
    """`vector` mirrored at the unit `axis`: 2 (v·a) a − v."""
    return 2.0 * (vector * axis).sum(axis=-1, keepdims=True) * axis - vector


def _half(theta_h: Column, phi_h: Column, theta_d: Column, phi_d: Column) -> Pair:
    """V is the difference vector turned by theta_h about the binormal and phi_h about the normal; L mirrors it."""
    half = surface_direction(theta_h, phi_h)
    x, y, z = surface_direction(theta_d, phi_d).T
    x, z = x * np.cos(theta_h) + z * np.sin(theta_h), z * np.cos(theta_h) - x * np.sin(theta_h)
    view = np.stack([x * np.cos(phi_h) - y * np.sin(phi_h), x * np.sin(phi_h) + y * np.cos(phi_h), z], axis=-1)
    return view, _mirror(view, half)


def _isotropic_light(theta_l: Column) -> Column:
    return surface_direction(theta_l, np.zeros_like(theta_l))


def _retro(theta_l: Column, x: Column, y: Column) -> Pair:
    """Polar coordinates of V about L: angle |(x, y)|, azimuth from the meridian towards the normal."""
    angle = np.hypot(x, y)
    along = np.divide(x, angle, out=np.zeros_like(x), where=angle > 0.0)
    across = np.divide(y, angle, out=np.zeros_like(y), where=angle > 0.0)
    cos_v = np.cos(theta_l) * np.cos(angle) + along * np.sin(theta_l) * np.sin(angle)
    sin_v = np.sqrt(np.maximum(1.0 - cos_v**2, 0.0))
    sin_phi = np.clip(np.divide(np.sin(angle) * across, sin_v, out=np.zeros_like(x), where=sin_v > 0.0), -1.0, 1.0)
    view = np.stack([sin_v * np.sqrt(1.0 - sin_phi**2), sin_v * sin_phi, cos_v], axis=-1)
    return view, _isotropic_light(theta_l)


def _schlick(theta_l: Column, x: Column, y: Column) -> Pair:
    """K is the back vector; V = 2 (r·K) K − r with r the mirror image of L in the normal."""
    light = _isotropic_light(theta_l)
    return _mirror(light * (-1.0, -1.0, 1.0), _project(x, y)), light


def _neumann(h: Column, b: Column, phi: Column) -> Pair:
    """Projections of (L + V)/2, of length h along x, and (L − V)/2, of length b at phi from it."""

    def raise_error(x: Column, y: Column) -> Column:
        return np.stack([x, y, np.sqrt(1.0 - x * x - y * y)], axis=-1)

    x, y = np.cos(phi) * b, np.sin(phi) * b
    return raise_error(h + x, y), raise_error(h - x, -y)


def _cartesian(*columns: Column) -> Pair:
    """V then L; vectors that are not of unit length to 1 % become invalid."""
    pair = []
    for vector in (np.stack(columns[:3], axis=-1), np.stack(columns[3:], axis=-1)):
        length = np.linalg.norm(vector, axis=-1, keepdims=True)
        pair.append(np.where(np.abs(length - 1.0) <= 0.01, vector / length, np.nan))
    return pair[0], pair[1]


def _zero(column: Column) -> Column:
    return np.zeros_like(column)


#: ALTA's name of the coordinates: how many there are, and (V, L) from them.
PARAMETRISATIONS: dict[str, tuple[int, Callable[..., Pair]]] = {
    "COS_TH": (1, lambda c: _half(np.arccos(c), _zero(c), _zero(c), _zero(c))),
    "RUSIN_TH_TD": (2, lambda h, d: _half(h, _zero(h), d, _zero(h) + math.pi / 2)),
    "COS_TH_TD": (2, lambda h, d: _half(np.arccos(h), _zero(h), np.arccos(d), _zero(h))),
    "ISOTROPIC_TV_PROJ_DPHI": (2, lambda x, y: (_project(x, y), _isotropic_light(_zero(x)))),
    "NEUMANN_2D": (2, lambda h, b: _neumann(h, b, _zero(h) + math.pi / 2)),
    "RUSIN_TH_TD_PD": (3, lambda h, d, p: _half(h, _zero(h), d, p)),
    "RUSIN_TH_PH_TD": (3, lambda h, p, d: _half(h, p, d, _zero(h))),
    "RUSIN_VH": (3, lambda x, y, z: _half(np.arctan2(np.hypot(x, y), z), np.arctan2(y, x), _zero(x), _zero(x))),
    "ISOTROPIC_TV_TL_DPHI": (3, lambda tv, tl, p: (surface_direction(tv), surface_direction(tl, p))),
    "ISOTROPIC_TL_TV_PROJ_DPHI": (3, lambda tl, x, y: (_project(x, y), _isotropic_light(tl))),
    "SCHLICK_TL_TK_PROJ_DPHI": (3, _schlick),
    "RETRO_TL_TVL_PROJ_DPHI": (3, _retro),
    "NEUMANN_3D": (3, _neumann),
    "RUSIN_TH_PH_TD_PD": (4, _half),
    "SPHERICAL_TL_PL_TV_PV": (4, lambda tl, pl, tv, pv: (surface_direction(tv, pv), surface_direction(tl, pl))),
    "CARTESIAN": (6, _cartesian),
}
