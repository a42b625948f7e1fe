"""Factors chosen by regions left out, beside McCool's and sums of equal bytes: of files, and of models as measured.

A sampling is a random model at the directions of an instrument, made smooth as a file of its values would be. Regions
are left out in the same way of all three (`engine.factor.held_out`); an error of 1 is that of McCool's set of as many
textures, or of all of his where there are more, and the default may have no larger one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import Accuracy
from engine.brdf.brdf import MODELS, Brdf
from engine.brdf.readers.read import read_brdf_steps
from engine.brdf.samples import BrdfSamples
from engine.brdf.scattered import fit_scattered
from engine.core.directions import Vectors, normalize, surface_direction
from engine.core.errors import InputError
from engine.core.params import Parameter, parameters
from engine.core.steps import Step, Steps
from engine.factor.errors import ROUNDED, TermError
from engine.factor.factor import factor
from engine.factor.settings import DEFAULT, MAX_PRODUCTS, FactorSettings

#: Samplings where no number is asked for, and texels a side of the maps of sums.
SAMPLINGS, SIDE = 4, 16

#: Pairs at random directions, and the largest angle from the normal at which instruments measure.
RANDOM_PAIRS, LARGEST_ANGLE = 400, np.radians(80.0)

#: Models that are brighter somewhere, in 1/sr, are drawn again: Lafortune's grow without bound in his parameters.
BRIGHTEST = 1e4


def factors(
    _folder: Path, data: Path | None = None, samplings: int = SAMPLINGS, seed: int = DEFAULT.seed
) -> Steps[list[Accuracy]]:
    """A row for each measured file in or below `data` and for each sampling, and the number of those that are worse.

    Files that are not measurement are left out. Takes about a minute each.
    """
    settings = replace(DEFAULT, seed=seed)
    paths = sorted(path for path in data.rglob("*") if path.is_file()) if data is not None else []
    rows: list[Accuracy] = []
    for path in paths:
        yield Step(len(rows) / (len(paths) + samplings), f"factoring {path.name}")
        try:
            brdf: Any = yield from read_brdf_steps(path)
        except InputError:
            continue
        rows.append((yield from row(path.name, brdf, settings)))
    for number in range(samplings):
        yield Step(len(rows) / (len(paths) + samplings), f"factoring sampling {number + 1}")
        samples = sample(seed, number)
        brdf = yield from fit_scattered(samples)
        rows.append((yield from row(samples.name, brdf, settings)))
    worse = sum(each.bound is not None and each.error > each.bound for each in rows)
    return [*rows, Accuracy("factors-worse", worse, f"cases worse than McCool's of {len(rows)}", 0.0)]


def row(name: str, brdf: Brdf, settings: FactorSettings) -> Steps[Accuracy]:
    """The default, McCool's textures and singular values on one BRDF."""
    searched = yield from factor(brdf, replace(settings, method="auto"))
    fixed = yield from factor(brdf, replace(settings, method="homomorphic"))
    size_bytes = searched.term_errors[-1].size_bytes
    products = min(max(1, size_bytes // (2 * SIDE**2 * 3 * 4)), MAX_PRODUCTS)
    sums = yield from factor(brdf, replace(settings, method="svd", side=SIDE, products=products))
    sets = (*fixed.term_errors, *fixed.left_out)
    last = {"default": searched.term_errors[-1], "mccool": sets[-1], "sums": sums.term_errors[-1]}
    more = {
        f"{key}_{figure}": getattr(term_error, figure)
        for key, term_error in last.items()
        for figure in ("textures", "size_bytes", "held_out_rms_cosine_weighted", "held_out_sq_log")
    }
    worst = largest_ratio(searched.term_errors, sets)
    errors = "; ".join(f"{key} {_words(term_error)}" for key, term_error in last.items())
    return Accuracy(f"factors {name}", worst, f"held-out error over McCool's: {errors}", ROUNDED, more)


def largest_ratio(term_errors: Sequence[TermError], sets: Sequence[TermError]) -> float:
    """The largest of both held-out errors over those of McCool's set of as many textures, or of all; 1 where unknown.

    `sets` are those of 1, 2, … textures. The last of `term_errors` is compared with the whole set too.
    """
    pairs = [(term_error, sets[min(term_error.textures, len(sets)) - 1]) for term_error in term_errors]
    pairs.append((term_errors[-1], sets[-1]))
    return max(_ratio(term_error.error(name), fixed.error(name)) for term_error, fixed in pairs for name in HELD_OUT)


HELD_OUT = ("held_out_rms_cosine_weighted", "held_out_sq_log")


def _ratio(error: float | None, of: float | None) -> float:
    if error is None or of is None or error == of:
        return 1.0
    return error / of if of > 0.0 else float("inf")


def _words(term_error: TermError) -> str:
    errors = [term_error.error(name) for name in HELD_OUT]
    return f"{term_error.textures} × " + " / ".join("–" if error is None else f"{error:.3g}" for error in errors)


def sample(seed: int, number: int) -> BrdfSamples:
    """A random model at the directions of one instrument after the other."""
    rng = np.random.default_rng([seed, number])
    instrument = list(INSTRUMENTS)[number % len(INSTRUMENTS)]
    wi, wo = INSTRUMENTS[instrument](rng)
    value = np.full_like(wi, np.inf)
    while not value.max() <= BRIGHTEST:
        name = list(MODELS)[rng.integers(len(MODELS))]
        brdf = MODELS[name](**{parameter.name: _draw(rng, parameter) for parameter in parameters(MODELS[name])})
        value = brdf.f(wi, wo)
    return BrdfSamples(wi, wo, value, f"{number + 1}: {name} at {instrument} directions", "sampling")


def _draw(rng: np.random.Generator, parameter: Parameter) -> Any:
    """A value, or three of a colour, from the range of the slider."""
    low, high = max(parameter.slider[0], parameter.low), min(parameter.slider[1], parameter.high)
    share = rng.random(3 if parameter.is_colour else 1)
    if parameter.log and low > 0.0:
        found = low * (high / low) ** share
    else:
        found = low + (high - low) * share
    return tuple(map(float, found)) if parameter.is_colour else float(found[0])


def _cornell(_rng: np.random.Generator) -> tuple[Vectors, Vectors]:
    """Light at eight angles from 10° to 80°, viewers on ten rings at half the azimuths."""
    theta = np.radians(np.arange(10.0, 81.0, 10.0))
    return _grid(theta, np.zeros(1), np.radians(np.linspace(4.0, 78.0, 10)), np.radians(np.arange(0.0, 181.0, 10.0)))


def _utia(_rng: np.random.Generator) -> tuple[Vectors, Vectors]:
    """Rings every 15° to 75° for both, azimuths every 30° of the viewer."""
    theta = np.radians(np.arange(0.0, 76.0, 15.0))
    return _grid(theta, np.zeros(1), theta, np.radians(np.arange(0.0, 360.0, 30.0)))


def _grid(theta_i: Any, phi_i: Any, theta_o: Any, phi_o: Any) -> tuple[Vectors, Vectors]:
    angles = np.meshgrid(theta_i, phi_i, theta_o, phi_o, indexing="ij")
    wi_theta, wi_phi, wo_theta, wo_phi = (each.ravel() for each in angles)
    return surface_direction(wi_theta, wi_phi), surface_direction(wo_theta, wo_phi)


def _curet(_rng: np.random.Generator) -> tuple[Vectors, Vectors]:
    """A fixed lamp, cameras every 22.5° round the sample, and the sample turned and tilted before each."""
    tilt, turn = (
        each.ravel() for each in np.meshgrid(np.radians(np.arange(0.0, 80.0, 11.25)), np.arange(8) * np.pi / 8)
    )
    camera = np.radians(22.5 * np.arange(1, 8))
    # The sample's frame: z towards `normal`, x in the plane of the lamp, the cameras in the plane y = 0.
    lamp = np.array([0.0, 0.0, 1.0])
    pairs = []
    for normal in surface_direction(tilt, turn):
        x = normalize(np.cross([0.0, 1.0, 0.0], normal))
        frame = np.stack([x, np.cross(normal, x), normal])
        for angle in camera:
            pairs.append((frame @ lamp, frame @ [np.sin(angle), 0.0, np.cos(angle)]))
    wi, wo = (np.array(side) for side in zip(*pairs, strict=True))
    seen = np.minimum(wi[:, 2], wo[:, 2]) > np.cos(LARGEST_ANGLE)
    return wi[seen], wo[seen]


def _random(rng: np.random.Generator) -> tuple[Vectors, Vectors]:
    """Uniform by projected area."""
    theta = np.arcsin(np.sin(LARGEST_ANGLE) * np.sqrt(rng.random((2, RANDOM_PAIRS))))
    phi = 2.0 * np.pi * rng.random((2, RANDOM_PAIRS))
    return surface_direction(theta[0], phi[0]), surface_direction(theta[1], phi[1])


#: The directions of each instrument.
INSTRUMENTS = {"Cornell's": _cornell, "CUReT's": _curet, "UTIA's": _utia, "random": _random}
