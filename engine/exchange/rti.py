"""Reflectance transformation images: polynomial texture maps, hemispherical harmonics, and a tree for web viewers.

| file | form | terms |
|---|---|---|
| `NAME_lrgb.ptm` | PTM 1.2, PTM_FORMAT_LRGB | 6 of the luminance, and one colour (Malzbender2001) |
| `NAME.ptm` | PTM 1.2, PTM_FORMAT_RGB | 6 of each channel |
| `NAME.rti` | HSH 1.2 | 9 of each channel (Gautron2004) |
| `loss.txt` | text | the error, for which a PTM has no place |
| `relight/info.json`, `plane_N.png` | the JSON form of relight and OpenLIME, type ptm | 6 of each channel |

All hold codes of 8-bit sRGB, which viewers show as they are, as linear functions of the direction of light l: of the
photographs where a stack is at hand, and else of images that the directional map gives for as many directions. Terms
are fitted to them by least squares and rounded to 8 bits between their extremes: value = scale (code − bias) in PTM,
code scale / 255 + bias in HSH. PTM rows run from the bottom up, all others from the top down; x of l is to the right
and y up. Time goes to the products of the images with the pseudo-inverse, some 60 MB of photographs a second.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from engine.capture.report import grid_step
from engine.core.colour import srgb_decode, srgb_encode
from engine.core.directions import Vectors, surface_direction
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, drain
from engine.exchange.loss import Shown, View, find_lit_points
from engine.exchange.subject import Contents, Settings, Subject
from engine.images.encode import encode_png
from engine.light.environment import DistantLights
from engine.shading.directional.functions import hemispherical, polynomial
from engine.shading.directional.interpolation import best_ridge, ridge_inverse
from engine.surface.lamps import shows_slopes

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack
    from engine.scene.material import Material

Floats = NDArray[np.float64]

#: Rows and columns of texels.
Grid = tuple[slice, slice]

#: Directions of the images of a directional map: angles from the normal in degrees, and turns of each.
TILTS_DEG, TURNS = (5.0, 20.0, 35.0, 50.0, 65.0, 78.0), 12

#: The largest code.
TOP = 255.0

#: Terms of `polynomial`, xx, yy, xy, x, y, 1, in the order of relight.
_RELIGHT_ORDER = [5, 3, 4, 0, 2, 1]


@dataclass(frozen=True, eq=False)
class Terms:
    """Codes of 8-bit sRGB as Σ c_k b_k(l): coefficients (H, W, C, K) float32 of K functions of light."""

    coefficients: NDArray[np.float32]
    basis: Callable[[Vectors], Floats]

    def round_values(self) -> tuple[NDArray[np.uint8], Floats, Floats]:
        """Codes (H, W, C, K), and (K,) the lowest value and the range of each term over all texels and channels."""
        low = self.coefficients.min(axis=(0, 1, 2)).astype(np.float64)
        span = np.maximum(self.coefficients.max(axis=(0, 1, 2)) - low, 1e-6)
        return np.rint((self.coefficients - low) / span * TOP).astype(np.uint8), low, span

    def restored(self, place: Grid) -> Floats:
        """(h, w, C, K) the coefficients of the texels of a grid as a reader gets them back."""
        codes, low, span = self.round_values()
        return np.asarray(codes[place] / TOP * span + low)


@dataclass(frozen=True, eq=False)
class PtmCodes:
    """Codes (H, W, C, 6) of coefficients scale (code - bias), bias a whole number in 0 … 255."""

    codes: NDArray[np.uint8]
    scale: Floats
    bias: Floats

    def restored(self, place: Grid) -> Floats:
        """(h, w, C, 6) the coefficients of the texels of a grid as a reader gets them back."""
        return np.asarray(self.scale * (self.codes[place] - self.bias))

    def head(self, form: str) -> bytes:
        """The header of a PTM of a format."""
        height, width = self.codes.shape[:2]
        scales, biases = (
            " ".join(f"{value:.6g}" for value in self.scale),
            " ".join(str(int(value)) for value in self.bias),
        )
        return f"PTM_1.2\n{form}\n{width}\n{height}\n{scales}\n{biases}\n".encode()


def show(subject: Subject, _settings: Settings) -> Shown | None:
    """The harmonics, the most exact of the forms, as a viewer shows them; the viewer's direction does not count."""
    return subject.remember("rti", lambda: _hsh_shown(subject)) if has_sides(subject.material, subject.stack) else None


def _hsh_shown(subject: Subject) -> Shown:
    terms = drain(fit(subject, hsh_functions))
    codes, low, span = terms.round_values()

    def radiance(view: View, lights: DistantLights) -> Floats:
        at = codes[view.row, view.column] / TOP * span + low
        value = np.zeros((len(view.row), 3))
        for lit, wi, irradiance in find_lit_points(view, lights):
            code = np.einsum("nck,nk->nc", at[lit], hsh_functions(wi))
            value[lit] += srgb_decode(np.clip(code, 0.0, TOP) / TOP) * irradiance
        return value

    return radiance


def contents(subject: Subject, _settings: Settings, loss: str) -> Steps[Contents]:
    """The four forms, and the loss in words, of a material that `has_sides`."""
    name = subject.name
    yield Step(0.0, "fitting polynomials")
    quadratic = yield from fit(subject, polynomial)
    files = {f"{name}.ptm": ptm_rgb(quadratic), f"{name}_lrgb.ptm": ptm_lrgb(quadratic)}
    files |= relight(quadratic, loss)
    yield Step(0.5, "fitting harmonics")
    spherical = yield from fit(subject, hsh_functions)
    files[f"{name}.rti"] = hsh(spherical, loss)
    yield Step(0.9, "relighting each file")
    errors = _errors_by_file(subject, quadratic, spherical)
    said = ", ".join(f"{file} {percent(error, 3)}" for file, error in errors.items())
    away = f"relative RMSE of the files against the images that they were fitted to: {said}"
    loss_of_it = f"{loss} (These errors are those of {name}.rti.)"
    files["loss.txt"] = (
        f"{loss_of_it}\n{away[:1].upper()}{away[1:]}.\nThe header of a PTM has no place for this.\n".encode()
    )
    warnings = ("RTI files show one viewer, straight above", f"the errors above are those of {name}.rti; {away}")
    return Contents(files, 27.0, warnings, {"rmse_rel_by_file": errors})


def _errors_by_file(subject: Subject, quadratic: Terms, spherical: Terms) -> dict[str, float]:
    """Relative RMSE in linear light of each file, relit as its images were, on at most 65,536 texels of a grid."""
    lights, image = _images(subject)
    step = grid_step(*quadratic.coefficients.shape[:2])
    grid = (slice(step // 2, None, step), slice(step // 2, None, step))
    colour, brightness = _colour_and_brightness(quadratic)
    forms = {
        f"{subject.name}.rti": spherical.restored(grid),
        f"{subject.name}.ptm": _ptm_codes(quadratic.coefficients).restored(grid),
        f"{subject.name}_lrgb.ptm": _ptm_codes(brightness).restored(grid) * (colour[grid] / TOP)[..., None],
        "relight/info.json": quadratic.restored(grid),
    }
    apart, whole = dict.fromkeys(forms, 0.0), 0.0
    for number, light in enumerate(lights):
        wanted = np.clip(image(number)[grid], 0.0, 1.0).astype(np.float64)
        whole += float(np.sum(wanted**2))
        for name, terms in forms.items():
            basis = hsh_functions if name.endswith(".rti") else polynomial
            found = srgb_decode(np.clip(terms @ basis(light[None])[0], 0.0, TOP) / TOP)
            apart[name] += float(np.sum((found - wanted) ** 2))
    return {name: float(np.sqrt(error / whole)) if whole > 0.0 else 0.0 for name, error in apart.items()}


def hsh_functions(light: Vectors) -> Floats:
    """(N, 9) hemispherical harmonics of orders 0 to 2 (Gautron2004)."""
    return hemispherical(light)[:, :9]


def fit(subject: Subject, basis: Callable[[Vectors], Floats]) -> Steps[Terms]:
    """The terms of `basis` nearest to all images, by the ridge fit that predicts images best which are left out."""
    lights, image = _images(subject)
    some = []
    for number in range(len(lights)):
        step = grid_step(*subject.material.size)
        some.append(TOP * srgb_encode(np.clip(image(number)[::step, ::step], 0.0, 1.0)).ravel())
        yield Step(0.3 * number / len(lights), "fitting terms")
    seen = np.stack(some)
    functions = basis(lights)
    inverse = ridge_inverse(functions, best_ridge(functions, (seen @ seen.T).astype(np.float64) / seen.shape[1]))
    total: NDArray[np.float32] | None = None
    for number in range(len(lights)):
        codes = TOP * srgb_encode(np.clip(image(number), 0.0, 1.0))
        part = codes[..., None] * inverse[:, number].astype(np.float32)
        total = part.astype(np.float32) if total is None else total + part.astype(np.float32)
        yield Step(0.3 + 0.7 * number / len(lights), "fitting terms")
    assert total is not None
    return Terms(total, basis)


def ptm_rgb(terms: Terms) -> bytes:
    """PTM 1.2 with the terms of each channel, one channel after the other."""
    rounded = _ptm_codes(terms.coefficients)
    planes = (np.ascontiguousarray(rounded.codes[::-1, :, channel]).tobytes() for channel in range(3))
    return rounded.head("PTM_FORMAT_RGB") + b"".join(planes)


def ptm_lrgb(terms: Terms) -> bytes:
    """PTM 1.2 with the terms of the luminance, and the colour whose product with luminance / 255 is nearest to light.

    The colour is that under light from straight above, brightened so that its luminance there is 255.
    """
    colour, brightness = _colour_and_brightness(terms)
    rounded = _ptm_codes(brightness)
    return rounded.head("PTM_FORMAT_LRGB") + rounded.codes[::-1, :, 0].tobytes() + colour[::-1].tobytes()


def _colour_and_brightness(terms: Terms) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
    """(H, W, 3) codes of the one colour of each texel, and (H, W, 1, 6) the terms of its luminance."""
    above = np.clip(terms.coefficients @ terms.basis(np.array([[0.0, 0.0, 1.0]]))[0], 0.0, None)
    bright = np.maximum(above.max(axis=2, keepdims=True), 1.0)
    colour = np.rint(above / bright * TOP)
    weight = np.maximum(np.sum(colour**2, axis=2), 1.0)
    along = np.einsum("hwc,hwck->hwk", colour, terms.coefficients) * (TOP / weight[..., None])
    return colour.astype(np.uint8), along[:, :, None, :].astype(np.float32)


def _ptm_codes(coefficients: NDArray[np.float32]) -> PtmCodes:
    """The codes of coefficients (H, W, C, 6)."""
    low = np.minimum(coefficients.min(axis=(0, 1, 2)), 0.0).astype(np.float64)
    high = np.maximum(coefficients.max(axis=(0, 1, 2)), 0.0).astype(np.float64)
    scale = np.maximum((high - low) / (TOP - 1.0), 1e-6)
    scale = np.array([float(f"{value:.6g}") for value in scale * (1.0 + 1e-5)])
    bias = np.ceil(-low / scale)
    return PtmCodes(np.clip(np.rint(coefficients / scale + bias), 0.0, TOP).astype(np.uint8), scale, bias)


def hsh(terms: Terms, loss: str = "") -> bytes:
    """HSH 1.2: a header of text, scale and bias of each term as float32, then the terms of R, G, B of each texel.

    Its values go to 1, not to 255. Lines of the header that begin with # are comments; one states the `loss`.
    """
    codes, low, span = terms.round_values()
    height, width, _, count = codes.shape
    comment = f"# {' '.join(loss.split())}\r\n" if loss else ""
    head = f"#HSH1.2\r\n{comment}3\r\n{width} {height} 3\r\n{count} 2 1\r\n".encode()
    numbers = (span / TOP).astype("<f4").tobytes() + (low / TOP).astype("<f4").tobytes()
    return head + numbers + codes.tobytes()


def relight(terms: Terms, loss: str = "") -> dict[str, bytes]:
    """The JSON form: a plane of R, G, B for each term in the order of its viewers, 1, x, y, xx, xy, yy.

    value = scale (code / 255 − bias), which goes to 1. `lightarc_loss` states the `loss`; viewers pass over it.
    """
    ordered = np.ascontiguousarray(terms.coefficients[..., _RELIGHT_ORDER])
    codes, low, span = Terms(ordered, terms.basis).round_values()
    height, width, _, count = codes.shape
    info = {
        "width": width,
        "height": height,
        "format": "png",
        "type": "ptm",
        "colorspace": "rgb",
        "nplanes": 3 * count,
        "quality": 100,
        "lightarc_loss": loss,
        "materials": [
            {
                "scale": np.repeat(span / TOP, 3).tolist(),
                "bias": np.repeat(-low / span, 3).tolist(),
            }
        ],
    }
    files = {"relight/info.json": (json.dumps(info, indent=2) + "\n").encode()}
    for number in range(count):
        plane = np.ascontiguousarray(codes[..., number])
        files[f"relight/plane_{number}.png"] = encode_png(plane, transfer="linear", comment=loss)
    return files


def has_sides(material: Material, stack: ImageStack | None) -> bool:
    """True where images under light from several sides are at hand; those of one arc leave the rest to chance."""
    return material.directional is not None or _has_own_dome(material, stack)


def _has_own_dome(material: Material, stack: ImageStack | None) -> bool:
    """True for photographs of these texels under light from several sides."""
    return stack is not None and stack.radiance.shape[1:3] == material.size and shows_slopes(stack)


def _images(subject: Subject) -> tuple[Vectors, Callable[[int], NDArray[np.float32]]]:
    """Directions of light (N, 3), and a function that gives the image (H, W, 3) under each."""
    stack, directional = subject.stack, subject.material.directional
    if stack is not None and _has_own_dome(subject.material, stack):
        assert stack.azimuth is not None
        photographs = stack.radiance
        lights = surface_direction(0.5 * np.pi - stack.elevation, stack.azimuth)
        return lights, lambda number: np.asarray(photographs[number], np.float32)
    assert directional is not None
    tilt = np.radians(np.repeat(TILTS_DEG, TURNS))
    lights = surface_direction(tilt, np.tile(np.arange(TURNS) * (2.0 * np.pi / TURNS), len(TILTS_DEG)))
    return lights, lambda number: directional.image(lights[number])
