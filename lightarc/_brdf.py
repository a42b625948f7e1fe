"""BRDFs: models, measured files and factors; their values, fits and factorisations."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Literal

from engine.core.errors import UsageError
from engine.core.steps import Step, drain
from engine.factor.settings import DEFAULT, FactorSettings
from lightarc._border import public

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from engine.brdf.brdf import Brdf
    from engine.brdf.fit import Fit
    from engine.factor.errors import Factorisation

Progress = Callable[[Step], None]


@public
def open_brdf(text: str) -> Brdf:
    """The BRDF that `text` names: a model with its parameters, a preset, a measured file, or a folder of factors.

    InputError for a file that cannot be read, ValueError for a model or a parameter that is not known.

    >>> brdf = lightarc.open_brdf("ggx:alpha=0.3")
    >>> brdf.isotropic, brdf.reciprocal
    (True, True)
    """
    from engine.factor.factor_file import open_reflectance

    return open_reflectance(text)


@public
def evaluate_brdf(brdf: str | Brdf, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
    """Values (..., 3) in 1/sr, without the cosine, for unit directions (..., 3) to the light and to the viewer.

    Directions are in the frame of the surface, whose normal is (0, 0, 1), and broadcast against each other.

    >>> lightarc.evaluate_brdf("lambert:albedo=0.5", (0, 0, 1), [(0, 0, 1), (0.6, 0, 0.8)]).round(3).tolist()
    [[0.159, 0.159, 0.159], [0.159, 0.159, 0.159]]
    """
    return _open(brdf).f(wi, wo)


@public
def fit_brdf(
    brdf: str | Brdf,
    model: str = "ggx",
    *,
    weighting: Literal["log", "cosine"] = "log",
    fixed: Sequence[str] = (),
    samples: int = 8192,
    seed: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Fit a model to a BRDF; the result has the fitted `brdf` and the errors `before` and `after`.

    Parameters
    ----------
    model : its name, or with the parameters from which the fit starts.
    weighting : of differences of f cos: of their logarithms, so that dark values count as well, or as they are.
    fixed : names of parameters that keep their values.
    samples : pairs of directions, or values of a measurement, at most.

    ValueError for a model or a parameter that is not known, and where nothing is left to fit.

    >>> fitted = lightarc.fit_brdf("phong:exponent=40", "phong", samples=256)
    >>> round(fitted.brdf.exponent, 3), fitted.after.rmse_rel < 1e-3
    (40.0, True)
    """
    from engine.brdf.brdf import brdf_from_text
    from engine.brdf.fit import fit, fit_data

    if samples < 1:
        raise UsageError(f"{samples} samples are too few")
    data = fit_data(_open(brdf), count=samples, seed=seed)
    return drain(fit(data, brdf_from_text(model), weighting=weighting, fixed=tuple(fixed), seed=seed), progress)


@public
def factor_brdf(
    brdf: str | Brdf,
    *,
    method: Literal["auto", "symmetric", "svd", "power", "normalised", "homomorphic", "search"] = DEFAULT.method,
    terms: int = 0,
    size: int = 0,
    samples: int = DEFAULT.samples,
    seed: int = DEFAULT.seed,
    progress: Progress | None = None,
) -> Factorisation:
    """A BRDF as products of textures; the result has the `factors`, a BRDF, and the errors of each number of terms.

    Parameters
    ----------
    method : sums of products of two textures (the first five), or products of projections.
    terms, size : how many at most, and texels a side; 0 for the method's own.
    samples : pairs of directions from which the errors are known.

    ValueError where the settings do not fit each other or the BRDF.

    >>> found = lightarc.factor_brdf("phong:exponent=5", terms=2, size=8, samples=500)
    >>> [each.terms for each in found.ladder]
    [1, 2]
    """
    from engine.factor.factor import factor

    settings = FactorSettings(method=method, samples=samples, seed=seed)
    if terms:
        settings = settings.with_terms(terms)
    if size:
        settings = settings.with_texels(size)
    return drain(factor(_open(brdf), settings), progress)


@public
def save_factors(folder: str | os.PathLike[str], factorisation: Factorisation) -> None:
    """Write a factorisation as a folder, which then stands wherever a BRDF is named.

    A folder of factors is replaced, any other that is not empty is refused with an OutputError.

    >>> lightarc.save_factors("factors", found)
    >>> lightarc.evaluate_brdf("factors", (0, 0, 1), (0, 0, 1)).shape
    (3,)
    """
    from engine.factor.factor_file import write_factors

    write_factors(folder, factorisation)


def _open(brdf: str | Brdf) -> Brdf:
    return open_brdf(brdf) if isinstance(brdf, str) else brdf
