"""BRDFs: models, measured files and factors; their values, samples, fits and factorisations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from engine.brdf.fit import FitData, fit, fit_data
from engine.brdf.models.sampling import sampler_of
from engine.brdf.readers.merl import SIZE_BYTES, write_merl
from engine.brdf.readers.table_file import write_table
from engine.brdf.resample import SHAPE, resample
from engine.brdf.table import DirectionTable, HalfDifferenceTable
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.factor.factor import factor
from engine.factor.factor_file import write_factors
from engine.factor.settings import DEFAULT, FactorSettings
from engine.storage.atomic import require_space
from lightarc._border import public
from lightarc._inputs import BrdfLike, File, Progress, as_brdf, as_samples, numeric

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from engine.brdf.brdf import Brdf
    from engine.brdf.fit import Fit
    from engine.brdf.models.sampling_lobes import Sampler
    from engine.factor.errors import Factorisation


@public
def open_brdf(text: BrdfLike) -> Brdf:
    """Open a BRDF by its text or its file.

    Parameters
    ----------
    text : str, path or file object
        A model with its parameters, a preset, a measured file, or a folder of factors.

    Returns
    -------
    Brdf
        An object with `f`, `eval`, `sample` and `pdf`.

    Raises
    ------
    UsageError
        For a model or a parameter that does not exist.
    InputError
        For a file that cannot be read.

    Examples
    --------
    >>> lightarc.open_brdf("ggx:alpha=0.3") == lightarc.Ggx(alpha=0.3)
    True
    >>> lightarc.Ggx(alpha=0.3).eval((0, 0, 1), (0, 0, 1)).round(3).tolist()
    [0.195, 0.195, 0.195]
    """
    return as_brdf(text)


@public
def evaluate_brdf(brdf: BrdfLike, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
    """Evaluate a BRDF.

    Parameters
    ----------
    brdf : str, path, Brdf or model class
        The BRDF.
    wi, wo : array_like, shape (..., 3)
        Unit directions to the light and to the viewer in the frame of the surface, whose normal is (0, 0, 1). They
        broadcast against each other.

    Returns
    -------
    ndarray, shape (..., 3)
        Values in 1/sr, without the cosine; 0 where a direction is at or below the horizon.

    Raises
    ------
    UsageError
        For directions that do not fit together, or a BRDF that does not exist.

    Examples
    --------
    >>> lightarc.evaluate_brdf("lambert:albedo=0.5", (0, 0, 1), [(0, 0, 1), (0.6, 0, 0.8)]).round(3).tolist()
    [[0.159, 0.159, 0.159], [0.159, 0.159, 0.159]]
    """
    return np.asarray(as_brdf(brdf).f(wi, wo))


@public
def sample_brdf(brdf: BrdfLike, wo: ArrayLike, *, u: ArrayLike | None = None, seed: int = 0) -> NDArray[np.float64]:
    """Draw directions towards the light, mostly where f cos(theta_i) is large.

    Parameters
    ----------
    brdf : str, path, Brdf or model class
        The BRDF.
    wo : array_like, shape (..., 3)
        Unit directions to the viewer, above the surface; one direction is drawn for each.
    u : array_like, shape (..., 3), optional
        Random numbers, uniform in [0, 1); without them they are drawn from `seed`.
    seed : int
        Seed of the random numbers.

    Returns
    -------
    ndarray, shape (..., 3)
        Unit directions to the light. A few may lie below the horizon, where the BRDF is 0.

    Raises
    ------
    UsageError
        For directions that are not unit vectors above the surface.

    References
    ----------
    .. [1] E. Heitz, "Sampling the GGX Distribution of Visible Normals", JCGT 7(4), 2018.

    Examples
    --------
    The mean of f cos(theta_i) / pdf is the albedo:

    >>> brdf, wo = lightarc.Lambert(albedo=(0.5, 0.5, 0.5)), np.tile((0, 0, 1.0), (64, 1))
    >>> wi = lightarc.sample_brdf(brdf, wo)
    >>> weight = brdf.f(wi, wo)[:, 0] * wi[:, 2] / lightarc.evaluate_pdf(brdf, wi, wo)
    >>> round(float(weight.mean()), 3)
    0.5
    """
    viewer = _unit(wo, "wo")
    shape = viewer.shape
    uniform = np.random.default_rng(seed).random(shape) if u is None else np.asarray(u, np.float64)
    if uniform.shape != shape or not ((uniform >= 0.0) & (uniform < 1.0)).all():
        raise UsageError(f"u must be numbers in [0, 1) of the shape of wo, {shape}, not {uniform.shape}")
    if not (viewer[..., 2] > 0.0).all():
        raise UsageError("wo must be above the surface (z > 0)")
    sampler = _sampler(brdf)
    return np.asarray(sampler.sample(viewer.reshape(-1, 3), uniform.reshape(-1, 3))).reshape(shape)


@public
def evaluate_pdf(brdf: BrdfLike, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
    """Evaluate the density at which `sample_brdf` draws directions.

    Parameters
    ----------
    brdf : str, path, Brdf or model class
        The BRDF.
    wi, wo : array_like, shape (..., 3)
        Unit directions to the light and to the viewer, which broadcast against each other.

    Returns
    -------
    ndarray, shape (...)
        Density in 1/sr over the whole sphere of `wi`.

    Raises
    ------
    UsageError
        For directions that are not unit vectors.

    Examples
    --------
    >>> round(float(lightarc.evaluate_pdf("lambert", (0, 0, 1), (0, 0, 1))), 4)
    0.3183
    """
    light, viewer = np.broadcast_arrays(_unit(wi, "wi"), _unit(wo, "wo"))
    density = _sampler(brdf).pdf(light.reshape(-1, 3), viewer.reshape(-1, 3))
    return np.asarray(density).reshape(light.shape[:-1])


@public
def fit_brdf(
    brdf: BrdfLike | tuple[ArrayLike, ArrayLike, ArrayLike],
    model: BrdfLike = "ggx",
    *,
    weighting: Literal["joint", "log", "cosine"] = "joint",
    fixed: Sequence[str] = (),
    samples: int = 8192,
    seed: int = 0,
    progress: Progress | None = None,
) -> Fit:
    """Fit a model to a BRDF or to measured values.

    Parameters
    ----------
    brdf : str, path, Brdf, or arrays (wi, wo, values)
        The BRDF; or unit directions (N, 3) to light and viewer, and values (N, 3) in 1/sr without the cosine, which
        broadcast against each other.
    model : str, model or model class
        The model, or one with the parameters from which the fit starts.
    weighting : {'joint', 'log', 'cosine'}
        Differences of f cos by their logarithms, so that dark values count as well, or as they are.
    fixed : sequence of str
        Names of parameters that keep their values.
    samples : int
        Pairs of directions, or values of a measurement, at most.
    seed : int
        Seed of directions and starts.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Fit
        The fitted `brdf`, and its errors `before` and `after`.

    Raises
    ------
    UsageError
        For a model or a parameter that does not exist, and where nothing is left to fit.

    References
    ----------
    .. [1] A. Ngan, F. Durand, W. Matusik, "Experimental Analysis of BRDF Models", EGSR 2005,
       https://doi.org/10.2312/EGWR/EGSR05/117-126.

    Examples
    --------
    >>> fitted = lightarc.fit_brdf("phong:exponent=40", lightarc.Phong, samples=256)
    >>> round(fitted.brdf.exponent, 3), fitted.after.rmse_rel < 1e-3
    (40.0, True)

    From arrays:

    >>> wi, wo = np.array((0, 0, 1.0)), np.array([(0, 0, 1), (0.6, 0, 0.8)])
    >>> round(lightarc.fit_brdf((wi, wo, np.full((2, 3), 0.1)), "lambert").brdf.albedo[0], 3)
    0.314
    """
    if samples < 1:
        raise UsageError(f"{samples} samples are too few")
    if isinstance(brdf, tuple | list):
        measured = as_samples(brdf)
        data = FitData(measured.wi, measured.wo, measured.value).first(samples)
    else:
        data = fit_data(as_brdf(brdf), count=samples, seed=seed)
    return drain(fit(data, as_brdf(model), weighting=weighting, fixed=tuple(fixed), seed=seed), progress)


@public
def factor_brdf(
    brdf: BrdfLike,
    *,
    method: Literal[
        "auto", "symmetric", "svd", "power", "nonnegative", "normalised", "homomorphic", "search"
    ] = DEFAULT.method,
    terms: int = 0,
    size: int = 0,
    samples: int = DEFAULT.samples,
    seed: int = DEFAULT.seed,
    progress: Progress | None = None,
) -> Factorisation:
    """Factor a BRDF into products of textures.

    Parameters
    ----------
    brdf : str, path, Brdf or model class
        The BRDF.
    method : {'auto', 'symmetric', 'svd', 'power', 'nonnegative', 'normalised', 'homomorphic', 'search'}
        Sums of products of two textures (the first five), or products of projections.
    terms : int
        Terms at most; 0 for the method's own number.
    size : int
        Texels a side; 0 for the method's own number.
    samples : int
        Pairs of directions from which the errors are known.
    seed : int
        Seed of these pairs.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Factorisation
        The `factors`, a BRDF, and the errors of each number of terms.

    Raises
    ------
    UsageError
        Where the settings do not fit each other or the BRDF.

    References
    ----------
    .. [1] J. Kautz, M. D. McCool, "Interactive Rendering with Arbitrary BRDFs using Separable Approximations", EGWR
       1999, https://doi.org/10.1007/978-3-7091-6809-7_22.
    .. [2] M. D. McCool, J. Ang, A. Ahmad, "Homomorphic Factorization of BRDFs for High-Performance Rendering",
       SIGGRAPH 2001, https://doi.org/10.1145/383259.383276.

    Examples
    --------
    >>> found = lightarc.factor_brdf("phong:exponent=5", terms=2, size=8, samples=500)
    >>> [each.terms for each in found.term_errors]
    [1, 2]
    """
    settings = FactorSettings(method=method, samples=samples, seed=seed)
    if terms:
        settings = settings.with_terms(terms)
    if size:
        settings = settings.with_texels(size)
    return drain(factor(as_brdf(brdf), settings), progress)


@public
def save_factors(folder: File, factorisation: Factorisation) -> None:
    """Write a factorisation as a folder, which then stands wherever a BRDF is named.

    Parameters
    ----------
    folder : path
        A folder of factors is replaced, any other that is not empty is refused.
    factorisation : Factorisation
        The result of `factor_brdf`.

    Raises
    ------
    OutputError
        Where the folder cannot be written.

    Examples
    --------
    >>> lightarc.save_factors("factors", found)
    >>> lightarc.evaluate_brdf("factors", (0, 0, 1), (0, 0, 1)).shape
    (3,)
    """
    write_factors(folder, factorisation)


@public
def save_brdf(path: File, brdf: BrdfLike, *, progress: Progress | None = None) -> None:
    """Write a BRDF as a table.

    Parameters
    ----------
    path : path
        A `.binary` file (MERL) or an `.exr` file (Lightarc).
    brdf : str, path, Brdf or model class
        The BRDF.
    progress : callable, optional
        Called with a step.

    Raises
    ------
    UsageError
        For another ending.
    OutputError
        Where the file cannot be written.

    Examples
    --------
    >>> lightarc.save_brdf("ggx.exr", "ggx:alpha=0.3")
    >>> lightarc.open_brdf("ggx.exr").isotropic
    True
    """

    output = Path(path)
    merl = output.suffix.lower() == ".binary"
    if not merl and output.suffix.lower() != ".exr":
        raise UsageError(f"a table is written as .binary (MERL) or .exr, not as {str(path)!r}")
    require_space(output, SIZE_BYTES)
    table: Any = as_brdf(brdf)
    kept = isinstance(table, HalfDifferenceTable) and (table.missing.shape == SHAPE or not merl)
    if not kept and (merl or not isinstance(table, DirectionTable)):
        table = drain(resample(table), progress)
    if merl:
        write_merl(output, table)
    else:
        write_table(output, table)


def _unit(directions: ArrayLike, name: str) -> NDArray[np.float64]:
    """Unit vectors (..., 3), or UsageError."""
    array = np.asarray(directions, np.float64)
    flat = numeric(array.reshape(-1, 3) if array.size and array.shape[-1] == 3 else array, name, None, 3)
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    if not (np.abs(length - 1.0) < 1e-3).all():
        raise UsageError(f"{name} must be unit vectors in the surface frame, whose normal is (0, 0, 1)")
    return np.asarray((flat / length).reshape(array.shape))


def _sampler(brdf: BrdfLike) -> Sampler:
    return sampler_of(as_brdf(brdf))
