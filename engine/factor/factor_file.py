"""Factors as a folder: `factors.json` and one OpenEXR image of 32-bit floats for each texture.

    separable     term-01-view.exr and term-01-light.exr (of wo and wi), or term-01-half.exr and term-01-difference.exr
    homomorphic   terms-2-texture-1.exr: the first of the two textures of the best factors of two terms, which all stand
                  in the folder, because a search finds other textures for each number of terms

Separable textures are in sr^-½ and may be negative, homomorphic ones logarithms; none is gamma-coded. The JSON says how
directions lead to texels, what the errors are, where `ceiling.exr` bounds the factors (`engine.brdf.ceiling`; rows
of |φi − φo| and θo, columns of θi), and, for each image, the fingerprint of its numbers, so that damage
cannot pass for data. float32 is what is stored: `write_factors` returns what stands in the folder, and that comes back
bit for bit. The folder appears complete or not at all.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from engine.brdf.brdf import Brdf
from engine.brdf.ceiling import NODES, Ceiling
from engine.brdf.readers.read import open_brdf
from engine.core.errors import InputError
from engine.factor.errors import Factorisation, Factors, Metrics, TermError
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.homomorphic import HomomorphicFactors, LogSpace
from engine.factor.projections import FixedProjection, Kind, LinearProjection, Projection
from engine.factor.separable_factors import SeparableFactors
from engine.factor.settings import MAX_TEXTURES
from engine.images.encode import rgb_channels, write_exr
from engine.storage.archive import json_of
from engine.storage.atomic import atomic_folder, write_bytes
from engine.storage.untrusted import AGAIN, decode_content, read_bytes

MEMBER, CEILING = "factors.json", "ceiling.exr"
FORMAT: Literal["lightarc-factors"] = "lightarc-factors"

#: Sides of a term's textures, in the order of `SeparableFactors.first` and `.second`.
SIDES = {"in-out": ("view", "light"), "half-diff": ("half", "difference")}

#: What reads the textures; the JSON beside them is read in the same process.
_DECODER = "engine.images.exr:read_exr_channels"

_JSON_LIMIT_BYTES = 1 << 20
_EXR_LIMIT_BYTES = 64 << 20
_MAX_TERMS = 64
_MAX_TEXELS = 128
_REMEDY = "Factor the BRDF again with lightarc factor"

#: Stands for a largest value where there is none: JSON knows no infinity.
_NO_LIMIT = 1e100

_Number = Annotated[float, Field(allow_inf_nan=False)]
_Positive = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
_Text = Annotated[str, Field(max_length=1000)]
_Row = Annotated[list[_Number], Field(min_length=4, max_length=4)]
_Side = Annotated[int, Field(ge=1, le=_MAX_TEXELS)]


class _Strict(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True)


class _Separable(_Strict):
    kind: Literal["separable"]
    map: Literal["orthographic", "polar", "parabolic"]
    size: _Side
    parametrisation: Literal["in-out", "half-diff"]
    terms: Annotated[int, Field(ge=1, le=_MAX_TERMS)]
    isotropic: bool
    reciprocal: bool


class _Projection(_Strict):
    """Rows of a linear projection of (x, y)/(1 + z) of both directions, or the name of a fixed one."""

    kind: Literal["linear"] | Kind
    rows: Annotated[list[_Row], Field(min_length=2, max_length=2)] | None = None
    extent: Literal["disks", "cube"] | None = None


class _Homomorphic(_Strict):
    """f = mean · (exp(sum of look-ups) − epsilon), from 0 to largest."""

    kind: Literal["homomorphic"]
    size: Annotated[int, Field(ge=2, le=_MAX_TEXELS)]
    parametrisation: Literal["in-out", "half-diff"]
    reciprocal: bool
    mean: Annotated[list[_Number], Field(min_length=3, max_length=3)]
    largest: Annotated[list[_Number], Field(min_length=3, max_length=3)]
    epsilon: _Number
    projections: Annotated[
        list[Annotated[list[_Projection], Field(min_length=1, max_length=MAX_TEXTURES)]],
        Field(min_length=1, max_length=MAX_TEXTURES),
    ]


class _TermError(_Strict):
    terms: Annotated[int, Field(ge=1, le=_MAX_TERMS)]
    textures: Annotated[int, Field(ge=1, le=2 * _MAX_TERMS)]
    rms_cosine_weighted: _Positive
    rms_by_elevation_band: Annotated[list[_Positive], Field(max_length=90)]
    metrics: dict[Literal["abs_log", "sq_log", "max_log", "abs", "sq", "max"], _Positive]
    time_s: _Positive
    size_bytes: Annotated[int, Field(ge=0)]
    held_out_rms_cosine_weighted: _Positive | None = None
    held_out_sq_log: _Positive | None = None
    smoothing: _Positive = 0.0


class _Record(_Strict):
    format: Literal["lightarc-factors"] = FORMAT
    version: Literal[1, 2, 3] = 3
    name: _Text
    method: _Text
    unit: Literal["1/sr, without the cosine"] = "1/sr, without the cosine"
    factors: Annotated[_Separable | _Homomorphic, Field(discriminator="kind")]
    asymmetry: _Positive
    condition_number: _Positive
    optimum_ratio: _Positive
    evaluations: Annotated[int, Field(ge=0, le=10**15)]
    searching: bool
    weighting: Literal["", "plain", "cosine"]
    converged: bool
    negative_energy: _Positive
    ladder: Annotated[list[_TermError], Field(max_length=_MAX_TERMS)]
    left_out: Annotated[list[_TermError], Field(max_length=_MAX_TERMS)] = []
    held_out_by: Literal["", "regions", "between texels"] = ""
    best_terms: Annotated[int, Field(ge=1, le=_MAX_TERMS)] | None = None
    unmeasured: _Text = ""
    choice: _Text = ""
    bounded: bool = False
    sha256: dict[_Text, Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]]


def write_factors(folder: str | os.PathLike[str], factorisation: Factorisation) -> Factorisation:
    """Write `factorisation` and return what stands in `folder`; OutputError where it cannot be written.

    A folder of factors is replaced, any other that is not empty is refused.
    """
    images = dict(_images(factorisation.factors))
    record = _Record(
        name=factorisation.factors.name[:1000],
        method=factorisation.method,
        factors=_describe(factorisation.factors),
        asymmetry=factorisation.asymmetry,
        condition_number=_finite(factorisation.condition_number),
        optimum_ratio=factorisation.optimum_ratio,
        evaluations=factorisation.evaluations,
        searching=factorisation.searching,
        weighting=factorisation.weighting,  # type: ignore[arg-type]
        converged=factorisation.converged,
        negative_energy=factorisation.negative_energy,
        ladder=_term_errors(factorisation.term_errors),
        left_out=_term_errors(factorisation.left_out),
        held_out_by=factorisation.held_out_by,  # type: ignore[arg-type]
        best_terms=factorisation.best_terms,
        unmeasured=factorisation.unmeasured[:1000],
        choice=factorisation.choice[:1000],
        bounded=factorisation.factors.ceiling is not None,
        sha256={name: _fingerprint(image) for name, image in images.items()},
    )
    text = json.dumps(record.model_dump(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    with atomic_folder(folder, MEMBER, sum(image.nbytes for image in images.values())) as partial:
        for name, image in images.items():
            write_exr(partial / name, rgb_channels(image), half=False)
        write_bytes(partial / MEMBER, text.encode())
    return _factorisation(record, images)


def _read_record(path: Path) -> Any:
    """The JSON of a folder of factors, read in the process that will decode the textures."""
    return json_of(read_bytes(path / MEMBER, _JSON_LIMIT_BYTES), path, MEMBER, _DECODER.partition(":")[0], _REMEDY)


def fingerprints(folder: str | os.PathLike[str]) -> dict[str, str]:
    """SHA-256 of the numbers of each texture in a folder of factors, by its file; InputError where it is none."""
    path = Path(folder)
    value = _read_record(path)
    found = value.get("sha256") if isinstance(value, dict) else None
    if not isinstance(found, dict):
        raise InputError(path, f"{MEMBER} does not describe factors", _REMEDY)
    return {str(name): str(each) for name, each in found.items()}


def read_factors(folder: str | os.PathLike[str]) -> Factorisation:
    """The factorisation in `folder`; InputError for anything else, and for one that is damaged."""
    path = Path(folder)
    value = _read_record(path)
    if not isinstance(value, dict) or value.get("format") != FORMAT:
        raise InputError(path, f"{MEMBER} does not describe factors", _REMEDY)
    if isinstance(value.get("version"), int) and value["version"] > 3:
        raise InputError(path, f"was written by a newer Lightarc (version {value['version']})", "Update Lightarc")
    try:
        record = _Record.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(map(str, first["loc"]))[:80]
        raise InputError(path, f"{MEMBER} has a faulty {place} ({first['msg'][:100]})", _REMEDY) from None
    try:
        images = {name: _image(path, name, shape, record) for name, shape in _shapes(record)}
        return _factorisation(record, images)
    except (ValueError, TypeError) as error:
        raise InputError(path, f"holds factors that cannot be: {error}", _REMEDY) from None


def holds_factors(path: str | os.PathLike[str]) -> bool:
    """True if `path` is a folder that `read_factors` may read."""
    try:
        return (Path(path) / MEMBER).is_file()
    except (OSError, ValueError):
        return False


def open_reflectance(text: str) -> Brdf:
    """The BRDF that `text` names: a folder of factors, or whatever `engine.brdf.readers.read.open_brdf`
    opens.
    """
    if holds_factors(text.strip()):
        factors: Brdf = read_factors(text.strip()).factors
        return factors
    return open_brdf(text)


def _describe(factors: Factors) -> _Separable | _Homomorphic:
    if isinstance(factors, SeparableFactors):
        return _Separable(
            kind="separable",
            map=factors.hemisphere_map.kind,
            size=factors.hemisphere_map.size,
            parametrisation=factors.parametrisation,
            terms=factors.terms,
            isotropic=factors.isotropic,
            reciprocal=factors.reciprocal,
        )
    return _Homomorphic(
        kind="homomorphic",
        size=len(factors.textures[0]),
        parametrisation=factors.parametrisation,
        reciprocal=factors.reciprocal,
        mean=factors.space.mean.tolist(),
        largest=np.minimum(factors.space.largest, _NO_LIMIT).tolist(),
        epsilon=factors.space.epsilon,
        projections=[
            [_describe_projection(each) for each in term_error.projections]
            for term_error in (*factors.shorter, factors)
        ],
    )


def _describe_projection(projection: Projection) -> _Projection:
    if isinstance(projection, LinearProjection):
        return _Projection(kind="linear", rows=projection.rows.tolist(), extent=projection.extent)
    return _Projection(kind=projection.kind)


def _images(factors: Factors) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """Every texture as float32 by the name of its file."""
    if factors.ceiling is not None:
        yield CEILING, factors.ceiling.table.reshape(-1, NODES, 3)
    if isinstance(factors, SeparableFactors):
        for side, textures in zip(SIDES[factors.parametrisation], (factors.first, factors.second), strict=True):
            for number, texture in enumerate(textures, start=1):
                yield f"term-{number:02d}-{side}.exr", texture
        return
    for term_error in (*factors.shorter, factors):
        for number, texture in enumerate(term_error.textures, start=1):
            yield f"terms-{term_error.terms}-texture-{number}.exr", texture.astype(np.float32)


def _shapes(record: _Record) -> Iterator[tuple[str, tuple[int, int]]]:
    """The files that `record` speaks of and the size of each image."""
    described = record.factors
    if record.bounded:
        yield CEILING, (NODES**2, NODES)
    if isinstance(described, _Separable):
        shape = HemisphereMap(described.map, described.size).shape
        for side in SIDES[described.parametrisation]:
            for number in range(1, described.terms + 1):
                yield f"term-{number:02d}-{side}.exr", shape
        return
    for projections in described.projections:
        for number in range(1, len(projections) + 1):
            yield f"terms-{len(projections)}-texture-{number}.exr", (described.size, described.size)


def _image(path: Path, name: str, shape: tuple[int, int], record: _Record) -> NDArray[np.float32]:
    found = decode_content(_DECODER, path / name, read_bytes(path / name, _EXR_LIMIT_BYTES))
    planes = [found[channel] for channel in ("channel:R", "channel:G", "channel:B") if channel in found]
    if len(planes) != 3 or any(plane.dtype != np.float32 or plane.shape != shape for plane in planes):
        raise InputError(path / name, f"is not an image of {shape[1]} × {shape[0]} texels of 32-bit floats", _REMEDY)
    image: NDArray[np.float32] = np.ascontiguousarray(np.stack(planes, axis=-1))
    if _fingerprint(image) != record.sha256.get(name):
        raise InputError(path / name, "is damaged: its fingerprint does not fit its content", AGAIN)
    return image


def _factorisation(record: _Record, images: dict[str, NDArray[np.float32]]) -> Factorisation:
    factors = _factors(record, images)
    if record.ladder and [term_error.terms for term_error in record.ladder] != _numbers_of_terms(record):
        raise ValueError("the errors are not those of its terms")
    return Factorisation(
        factors,
        record.method,
        tuple(_term_error(term_error) for term_error in record.ladder),
        asymmetry=record.asymmetry,
        condition_number=record.condition_number,
        optimum_ratio=record.optimum_ratio,
        evaluations=record.evaluations,
        projections=getattr(factors, "projections", ()),
        searching=record.searching,
        weighting=record.weighting,
        converged=record.converged,
        negative_energy=record.negative_energy,
        left_out=tuple(_term_error(term_error) for term_error in record.left_out),
        held_out_by=record.held_out_by,
        best_terms=record.best_terms,
        unmeasured=record.unmeasured,
        choice=record.choice,
    )


def is_whole(factorisation: Factorisation) -> bool:
    """True if the error of each number of terms is known; of a sum they follow one after the other. Others are not
    written."""
    factors = factorisation.factors
    return not isinstance(factors, SeparableFactors) or len(factorisation.term_errors) == factors.terms


def _numbers_of_terms(record: _Record) -> list[int]:
    """The numbers of terms that factors are known for."""
    if isinstance(record.factors, _Separable):
        return list(range(1, record.factors.terms + 1))
    return [len(projections) for projections in record.factors.projections]


def _factors(record: _Record, images: dict[str, NDArray[np.float32]]) -> Any:
    described = record.factors
    ceiling = Ceiling(images[CEILING].reshape(NODES, NODES, NODES, 3)) if record.bounded else None
    if isinstance(described, _Separable):
        hemisphere_map = HemisphereMap(described.map, described.size)
        first, second = (
            np.stack([images[f"term-{number:02d}-{side}.exr"] for number in range(1, described.terms + 1)])
            for side in SIDES[described.parametrisation]
        )
        words = (described.isotropic, described.reciprocal, record.name, ceiling)
        return SeparableFactors(hemisphere_map, described.parametrisation, first, second, *words)
    space = LogSpace(np.array(described.mean), described.epsilon, np.array(described.largest))
    term_errors: tuple[HomomorphicFactors, ...] = ()
    for projections in described.projections:
        terms = len(projections)
        if term_errors and terms <= term_errors[-1].terms:
            raise ValueError("the numbers of terms do not rise")
        names = [f"terms-{terms}-texture-{number}.exr" for number in range(1, terms + 1)]
        textures = tuple(images[name].astype(np.float64) for name in names)
        found = tuple(_projection(each) for each in projections)
        term_errors = (
            *term_errors,
            HomomorphicFactors(
                textures,
                found,
                space,
                described.parametrisation,
                described.reciprocal,
                term_errors,
                record.name,
                ceiling=ceiling,
            ),
        )
    return term_errors[-1]


def _projection(described: _Projection) -> Projection:
    if described.kind == "linear":
        if described.rows is None or described.extent is None:
            raise ValueError("a linear projection needs rows and an extent")
        return LinearProjection(np.array(described.rows), described.extent)
    return FixedProjection(described.kind)


def _term_errors(term_errors: Sequence[TermError]) -> list[_TermError]:
    return [
        _TermError(**asdict(term_error) | {"rms_by_elevation_band": [*term_error.rms_by_elevation_band]})
        for term_error in term_errors
    ]


def _term_error(term_error: _TermError) -> TermError:
    values = term_error.model_dump()
    return TermError(
        **{
            **values,
            "rms_by_elevation_band": tuple(term_error.rms_by_elevation_band),
            "metrics": Metrics(**values["metrics"]),
        }
    )


def _finite(number: float) -> float:
    return number if math.isfinite(number) else float(np.finfo(np.float64).max)


def _fingerprint(image: NDArray[np.float32]) -> str:
    return hashlib.sha256(np.ascontiguousarray(image, "<f4").data).hexdigest()
