"""Measurements of EPFL's Realistic Graphics Lab (`.bsdf`), in the adaptive parametrisation of their instrument.

The format of Dupuy2018 Sec. 5. For
an incident direction, two uniform numbers are warped to a half vector by the visible normals of a microfacet model that
was made from a retro-reflection measurement; the outgoing direction is the incident one mirrored about it. On a regular
grid of those two numbers the file holds

    s = f cos(theta_o) 4 sigma(wi) / D(h)        or f cos(theta_o) itself where its `jacobian` is 0,

for a few incident directions, between which s, the densities of the warp and their integrals are linear. Elevations
lie at u = √(2 theta / π), azimuths at u = (phi + π) / 2π; isotropic files (one or two azimuths) count the azimuth of
the half vector from that of the incident direction, anisotropic ones cover the whole circle, the half of it with y ≤ 0
(a half turn changes nothing) or the quarter with x, y ≤ 0 (nor do two mirrors).

What we state, as the format does not:

* `f(wi, wo)` takes wi, towards the light, as the file's incident direction, as the instrument had it. It is not made
  reciprocal: the two sides of a measurement differ by its noise, and `reciprocal` is False.
* Incident directions beyond the measured ones take the outermost, so does theta_i above the last, 89.99999°.
* Real files hold negative values (noise under a dark sample). They are counted, stay what they are for interpolation,
  and negative results of RGB files are cut to 0, as pbrt does; Mitsuba returns them. Values that are not finite count
  as 0.
* Where azimuths have no limit: at h = n that of h is wi's in isotropic files and +x in others, at wi = n that of wi is
  +x, as in Mitsuba. There the published files depend on it by 1 to 2 % and by 3 to 120 %.
* The field `valid` is not looked at, nor by Mitsuba: of the published files some set its bits for nearly all
  directions, others for the few at the rim alone.
* Mitsuba's `measured` computes in float32. It agrees to 1e-4 except for a few in 1000 pairs with a direction lower than
  10°, where it errs by up to 4 % (satin_rosaline, wi (0.786617, −0.613661, 0.068210), wo (−0.390643, 0.911023,
  0.132043): 1.103e-5 for 1.055e-5 in red); tests/engine/brdf/readers/test_rgl.py shows why.
* RGB files are taken as linear sRGB, spectral ones are turned into it by `engine.brdf.spectrum` (D65), where colours
  outside the gamut have negative channels and keep them.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from engine.brdf.models.sampling import Reflectance
from engine.brdf.readers import rgl_kernel
from engine.brdf.readers.tensor_file import looks_like_tensor_file, read_tensor_file
from engine.brdf.samples import DOUBTFUL_SHARE
from engine.brdf.spectrum import srgb_from_spectra
from engine.core.directions import Vectors
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Health, Verdict
from engine.core.summary import Summary
from engine.storage.untrusted import AGAIN

Floats = NDArray[np.float64]

#: Spectral files of anisotropic materials have some hundred megabytes.
LIMIT_BYTES = 1 << 30

_MEASURE = "Download it again from the RGL database"


@dataclass(frozen=True, eq=False)
class Warp:
    """A density over the unit square for each incident direction, bilinear between its nodes, and its integrals.

    Attributes
    ----------
    density : (P, T, Y, X) float64 ≥ 0, each slice with the integral 1.
    columns : (P, T, Y, X), the integral over x along each row of nodes from 0 to each node.
    rows : (P, T, Y), the integral over both up to each row.
    """

    density: Floats
    columns: Floats
    rows: Floats

    @staticmethod
    def of(values: ArrayLike) -> Warp:
        """Normalise `values` (P, T, Y, X) ≥ 0, of which each slice has a positive integral."""
        density = np.array(values, np.float64)
        columns = np.zeros_like(density)
        np.cumsum(density[..., 1:] + density[..., :-1], axis=-1, out=columns[..., 1:])
        columns *= 0.5 / (density.shape[3] - 1)
        rows = np.zeros(density.shape[:3])
        np.cumsum(columns[..., 1:, -1] + columns[..., :-1, -1], axis=-1, out=rows[..., 1:])
        rows *= 0.5 / (density.shape[2] - 1)
        whole = rows[..., -1].copy()
        density /= whole[..., None, None]
        columns /= whole[..., None, None]
        rows /= whole[..., None]
        for array in (density, columns, rows):
            array.setflags(write=False)
        return Warp(density, columns, rows)


@dataclass(frozen=True, eq=False, repr=False)
class RglBrdf(Reflectance, Summary):
    """A measurement in the adaptive parametrisation; `read_rgl` makes it.

    Attributes
    ----------
    name, kind : what was measured, and how.
    phi_i, theta_i : (P,), (T,) float64, rising; the incident directions, radians.
    scaled : whether `colours` are to be multiplied by ndf / (4 sigma).
    ndf, sigma : (·, ·) float64, the normals' density and projected area over the unit square of directions.
    visible : the warp to half vectors; luminance : that of the first two numbers, for sampling.
    colours : (P, T, Y, X, 3) float64, linear sRGB.
    samples, invalid_samples : directions in the file; those with a negative or not finite value.
    """

    name: str
    kind: str
    phi_i: Floats
    theta_i: Floats
    scaled: bool
    ndf: Floats
    sigma: Floats
    visible: Warp
    luminance: Warp
    colours: Floats
    spectral: bool
    samples: int
    invalid_samples: int
    health: Health

    reciprocal: ClassVar[bool] = False
    energy_conserving: ClassVar[bool] = False

    @property
    def isotropic(self) -> bool:
        """True if values depend on the difference of the azimuths alone."""
        return self.phi_i.size == 1

    @property
    def reduction(self) -> int:
        """Number of times the measured range of azimuths fills the circle: 1, 2 or 4; 1 in isotropic files."""
        return _reduction(self.phi_i)

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        """Value in 1/sr without the cosine, (..., 3), for unit directions (..., 3) in the surface frame."""
        shape, incident, outgoing = _pairs(wi, wo)
        values = np.empty((len(incident), 3))
        rgl_kernel.values(
            *self._frame(),
            *self._visible(),
            -np.inf if self.spectral else 0.0,
            self.colours,
            self.scaled,
            self.ndf,
            self.sigma,
            incident,
            outgoing,
            values,
        )
        return values.reshape(shape)

    def sample(self, wo: ArrayLike, u: ArrayLike) -> Vectors:
        """Unit directions (..., 3) towards the light for unit wo (..., 3) and u (..., 2 or more) in [0, 1).

        The warp of the file as Mitsuba's `measured` uses it: its first two numbers are drawn by the luminance that was
        measured there. It starts from one direction, and here that is wo: that the material is nearly reciprocal makes
        it a good choice, and `pdf` makes every estimate right whether or not it is. The last two columns of u are used.
        """
        fixed = np.asarray(wo, np.float64)
        uniform = np.ascontiguousarray(np.asarray(u, np.float64)[..., -2:].reshape(-1, 2))
        drawn = np.empty((len(uniform), 3))
        lines = np.ascontiguousarray(np.broadcast_to(fixed, (*np.shape(u)[:-1], 3)).reshape(-1, 3))
        luminance = (self.luminance.density, self.luminance.columns, self.luminance.rows)
        rgl_kernel.samples(*self._frame(), *self._visible(), *luminance, lines, uniform, drawn)
        return drawn.reshape(*np.shape(u)[:-1], 3)

    def pdf(self, wi: ArrayLike, wo: ArrayLike) -> Floats:
        """Density (...) in 1/sr at which `sample` draws wi for wo, over the whole sphere of wi."""
        shape, drawn, fixed = _pairs(wi, wo)
        density = np.empty(len(drawn))
        rgl_kernel.densities(*self._frame(), *self._visible(), self.luminance.density, fixed, drawn, density)
        return density.reshape(shape[:-1])

    def _frame(self) -> tuple[Floats, Floats, int, bool]:
        return self.phi_i, self.theta_i, self.reduction, self.phi_i.size <= 2

    def _visible(self) -> tuple[Floats, Floats, Floats]:
        return self.visible.density, self.visible.columns, self.visible.rows

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        return {"name": self.name, "kind": self.kind, "samples": self.samples}


def _pairs(wi: ArrayLike, wo: ArrayLike) -> tuple[tuple[int, ...], Vectors, Vectors]:
    """The common shape (..., 3) of two arrays of directions and both as contiguous (N, 3)."""
    first, second = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
    return first.shape, np.ascontiguousarray(first.reshape(-1, 3)), np.ascontiguousarray(second.reshape(-1, 3))


def _reduction(phi_i: Floats) -> int:
    return 1 if phi_i.size <= 2 else round(2.0 * np.pi / float(phi_i[-1] - phi_i[0]))


def looks_like_rgl(head: bytes, size_bytes: int, name: str) -> bool:
    """True if a file is a tensor_file; `read_rgl` says in a sentence if it is not an RGL measurement."""
    return looks_like_tensor_file(head)


def read_rgl(path: str | os.PathLike[str]) -> RglBrdf:
    """The measurement in the `.bsdf` file `path`, RGB or spectral, isotropic or anisotropic.

    Raises InputError for a file that is not a tensor_file, or holds something else (polarised measurements too), lacks
    a field, or has fields that contradict each other.
    """
    return rgl_of(read_tensor_file(path, LIMIT_BYTES), path)


def rgl_of(arrays: Mapping[str, NDArray[Any]], path: str | os.PathLike[str]) -> RglBrdf:
    """The measurement in the arrays of a tensor_file; `path` is what errors name."""
    fields = _Fields(path, arrays)
    phi_i, theta_i = fields.axis("phi_i", 2.0 * np.pi), fields.axis("theta_i", 0.5 * np.pi)
    if _reduction(phi_i) not in (1, 2, 4):
        degrees = np.degrees(phi_i[-1] - phi_i[0])
        raise InputError(path, f"covers {degrees:.0f}° of azimuth, and 360, 180 or 90 are known", _MEASURE)
    grid = (phi_i.size, theta_i.size)
    visible = fields.densities("vndf", grid)
    luminance = fields.densities("luminance", grid)
    measured, colours, spectral = _colours(fields, grid)
    negative = (measured < 0.0).any(axis=2)
    broken = ~np.isfinite(measured).all(axis=2)
    return RglBrdf(
        name=_description(fields) or Path(path).stem,
        kind=f"{'spectral ' if spectral else ''}RGL measurement",
        phi_i=phi_i,
        theta_i=theta_i,
        scaled=bool(fields.number("jacobian")),
        ndf=fields.directions("ndf"),
        sigma=fields.directions("sigma"),
        visible=Warp.of(visible),
        luminance=Warp.of(luminance),
        colours=colours,
        spectral=spectral,
        samples=negative.size,
        invalid_samples=int((negative | broken).sum()),
        health=_health(phi_i, theta_i, int(negative.sum()), int(broken.sum()), negative.size),
    )


class _Fields:
    """The arrays of a file, each checked for what it must be before it is handed out."""

    def __init__(self, path: str | os.PathLike[str], arrays: Mapping[str, NDArray[Any]]) -> None:
        self.path, self.arrays = path, arrays
        if "M" in arrays and "theta_d" in arrays:
            problem = "is a polarised measurement (Mueller matrices over half and difference angles), not an RGL BRDF"
            raise InputError(path, problem, "Give an unpolarised .bsdf file of the RGL database")
        if "spectra" not in arrays and "rgb" not in arrays:
            problem = f"is a tensor_file without measured reflectance; its fields are {', '.join(sorted(arrays)[:12])}"
            raise InputError(path, problem, "Give a .bsdf file of the RGL database")

    def array(self, name: str, dimensions: int, dtype: DTypeLike = np.float32) -> NDArray[Any]:
        if name not in self.arrays:
            raise InputError(self.path, f"lacks the field {name!r} of an RGL measurement", _MEASURE)
        array = self.arrays[name]
        if array.ndim != dimensions or array.dtype != dtype or not array.size:
            text = " × ".join(map(str, array.shape))
            raise InputError(self.path, f"has a field {name!r} of {text} {array.dtype.name}: it is damaged", AGAIN)
        return array

    def number(self, name: str) -> float:
        array = self.array(name, 1, np.uint8)
        if array.size != 1:
            raise InputError(self.path, f"has {array.size} numbers as {name!r}, not one: it is damaged", AGAIN)
        return float(array[0])

    def axis(self, name: str, largest: float) -> Floats:
        """A rising list of finite numbers of magnitude at most `largest`."""
        axis = _double(self.array(name, 1))
        rising = np.isfinite(axis).all() and (np.diff(axis) > 0.0).all()
        if not rising or abs(axis).max() > largest + 1e-3:
            raise InputError(self.path, f"has {name!r} that are not angles in rising order: it is damaged", AGAIN)
        return _freeze(axis)

    def positive(self, name: str, dimensions: int) -> Floats:
        array = _double(self.array(name, dimensions))
        if min(array.shape[-2:]) < 2 or not np.isfinite(array).all() or (array < 0.0).any():
            raise InputError(self.path, f"has {name!r} that is not a table of positive numbers: it is damaged", AGAIN)
        return array

    def directions(self, name: str) -> Floats:
        return _freeze(self.positive(name, 2))

    def densities(self, name: str, grid: tuple[int, int]) -> Floats:
        """One table (Y, X) per incident direction of `grid`, none of them without any weight."""
        values = self.positive(name, 4)
        self.check_grid(name, values.shape, grid)
        if (values.max(axis=(2, 3)) <= 0.0).any():
            raise InputError(self.path, f"has {name!r} that is 0 for some incident direction: it is damaged", AGAIN)
        return values

    def check_grid(self, name: str, shape: tuple[int, ...], grid: tuple[int, int]) -> None:
        if shape[:2] != grid:
            sizes = f"{shape[0]} × {shape[1]} incident directions, not {grid[0]} × {grid[1]}"
            raise InputError(self.path, f"has {name!r} for {sizes}: it is damaged", AGAIN)


def _colours(fields: _Fields, grid: tuple[int, int]) -> tuple[NDArray[Any], Floats, bool]:
    """Measured data (P, T, bands, Y, X) as linear sRGB (P, T, Y, X, 3), and True if they are spectral."""
    spectral = "spectra" in fields.arrays
    name = "spectra" if spectral else "rgb"
    measured = fields.array(name, 5)
    fields.check_grid(name, measured.shape, grid)
    wavelengths = _double(fields.array("wavelengths", 1)) if spectral else np.arange(3.0)
    if measured.shape[2] != wavelengths.size or min(measured.shape[3:]) < 2:
        problem = f"has {name!r} in {measured.shape[2]} bands, and {wavelengths.size} wavelengths: it is damaged"
        raise InputError(fields.path, problem, AGAIN)
    colours = np.empty((*grid, *measured.shape[3:], 3))
    for phi in range(grid[0]):
        # A slice at a time: spectra in float64 would take twice the file.
        bands = _double(np.moveaxis(measured[phi], 1, -1))
        bands[~np.isfinite(bands)] = 0.0
        try:
            colours[phi] = srgb_from_spectra(wavelengths, bands) if spectral else bands
        except UsageError as error:
            raise InputError(fields.path, f"has wavelengths that cannot be used: {error}", AGAIN) from None
    return measured, _freeze(colours), spectral


def _description(fields: _Fields) -> str:
    """The file's own line about the material, without what is not printable; empty where there is none."""
    raw = fields.arrays.get("description", np.empty(0, np.uint8))
    text = raw.tobytes()[:200].decode("utf-8", "replace") if raw.dtype == np.uint8 else ""
    return "".join(letter for letter in text if letter.isprintable()).strip()


def _health(phi_i: Floats, theta_i: Floats, negative: int, broken: int, samples: int) -> Health:
    findings = []
    if negative:
        text = f"{negative} of {samples} measured directions have a negative value; negative reflectance is taken as 0"
        many = negative > DOUBTFUL_SHARE * samples
        findings.append(Finding(Verdict.WARNING if many else Verdict.NOTE, text))
    if broken:
        text = f"{broken} of {samples} measured directions have a value that is not a finite number; it is taken as 0"
        findings.append(Finding(Verdict.WARNING, text))
    first, last = np.degrees(theta_i[[0, -1]])
    if first > 1.0 or last < 89.0:
        text = f"light was measured from {first:.0f}° to {last:.0f}°; beyond, the nearest measurement is taken"
        findings.append(Finding(Verdict.WARNING, text))
    span = 2.0 * np.pi / _reduction(phi_i)
    if phi_i.size > 2 and max(abs(phi_i[0] + np.pi), abs(phi_i[-1] - phi_i[0] - span)) > 0.02:
        first, last = np.degrees(phi_i[[0, -1]])
        text = f"azimuths were measured from {first:.0f}° to {last:.0f}°; beyond, the nearest measurement is taken"
        findings.append(Finding(Verdict.WARNING, text))
    figures = {"negative": float(negative), "not finite": float(broken)}
    return Health(MappingProxyType(figures), tuple(findings))


def _double(array: NDArray[Any]) -> Floats:
    """A copy in float64; a NaN of the signalling kind is one more NaN, without a warning."""
    with np.errstate(invalid="ignore"):
        return array.astype(np.float64)


def _freeze(array: Floats) -> Floats:
    array.setflags(write=False)
    return array
