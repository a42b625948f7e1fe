"""Values of a project compared with what their classes declare, before they are made.

One checker reads the annotations of the dataclasses and named tuples of `CLASSES`: numbers are
finite and of 64 bits, texts and paths can be shown and opened, tuples, mappings and literals hold what they declare,
and a field of a class holds that class. `ARRAYS` adds what annotations cannot say: the axes of arrays, and which of
them hold finite numbers; `RULES` what holds between fields, `RANGES` what bounds the work of the program, and
`_declared` stands for annotations that are open (`Any`). Ranges of parameters are checked by the classes themselves.

pydantic was weighed: it takes instances of dataclasses as they are, or makes them anew, and a value that two states
share has to stay the same object.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Callable, Collection, Mapping, Sequence, Set
from enum import Enum
from functools import cache, reduce
from importlib import import_module
from operator import or_
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np

from app.document.bake_request import choices_for
from app.document.factoring import MATERIAL, RUN_NUMBERS, names_of
from engine.brdf.brdf import MODELS, brdf_from_text
from engine.capture.lights.list_forms import LISTED, is_form
from engine.capture.object_outline import ObjectOutline
from engine.capture.scale import KnownLength
from engine.core.errors import UsageError
from engine.storage.text import whole_number
from engine.transport import method

#: Classes of the document by their module. Their names and fields are part of the format: renaming one needs a
#: migration (`app.project.project_file`). BRDF models are classes of the document as well, those that are registered.
CLASSES = {
    "app.document.document": ("ImportChoices", "Look"),
    "app.document.comparison": ("Comparison", "Entry", "Fitted"),
    "app.document.exporting": ("Exporting",),
    "app.document.factoring": ("Factoring", "Run"),
    "app.document.measured": ("Accuracy",),
    "app.document.variation": ("Blend", "Colours", "VariedParameter"),
    "engine.brdf.radial_basis": ("Patches",),
    "engine.brdf.readers.rgl": ("RglBrdf", "Warp"),
    "engine.brdf.samples": ("BrdfSamples",),
    "engine.brdf.scattered": ("ScatteredBrdf", "Shape", "Symmetry"),
    "engine.brdf.table": ("DirectionTable", "HalfDifferenceTable"),
    "engine.brdf.written": ("WrittenBrdf",),
    "engine.capture.lights.mirror_sphere": ("Circle",),
    "engine.capture.lights.sources": ("Sources", "Unpacked"),
    "engine.capture.photograph.exposures": ("Exposure",),
    "engine.capture.registration.framing": ("Framing",),
    "engine.capture.report": ("Quality",),
    "engine.capture.stack": ("ImageStack",),
    "engine.core.health": ("Finding", "Health"),
    "engine.factor.hemisphere_map": ("HemisphereMap",),
    "engine.brdf.ceiling": ("Ceiling",),
    "engine.factor.homomorphic": ("HomomorphicFactors", "LogSpace"),
    "engine.factor.projections": ("FixedProjection", "LinearProjection"),
    "engine.factor.separable_factors": ("SeparableFactors",),
    "engine.factor.settings": ("FactorSettings",),
    "engine.geometry.brushing": ("Brushing",),
    "engine.geometry.camera": ("Camera",),
    "engine.geometry.ground": ("Ground",),
    "engine.geometry.mesh": ("Mesh",),
    "engine.light.environment": ("EnvironmentMap",),
    "engine.light.lamps": ("Lamp", "LampSettings"),
    "engine.light.near_lamps": ("NearLampSettings",),
    "engine.planning.costs.setting": ("Setting",),
    "engine.scene.credits": ("Credits",),
    "engine.scene.material": ("Material",),
    "engine.shading.directional.interpolation": ("Kernel",),
    "engine.shading.directional.planes": ("DirectionalMap",),
    "engine.shading.kept_tiles": ("KeptTiles",),
    "engine.shading.power_law": ("PowerLawMap", "Storage"),
    "engine.shading.shading_map": ("ShadingMap",),
    "engine.surface.lamps": ("Lamps",),
    "engine.surface.pbr_maps": ("MapErrors", "ObservedSlopes", "PbrMaps", "SurfaceMaps", "Uncertainty", "WideColours"),
    "engine.surface.recover": ("Surface",),
    "engine.tradeoff.point": ("Point",),
}

#: Largest whole number, and longest text and path, in letters and bytes.
MAX_NUMBER, MAX_TEXT, MAX_NAME_BYTES, MAX_PATH_BYTES = 2**63 - 1, 1_000_000, 255, 4096

#: Longest name of a project, in letters.
MAX_SHOWN = 4096

#: Floating-point arrays with more bytes are searched for numbers that are not finite by `lightarc project verify`
#: alone: they are mapped, and reading them would hold up the opening of a project.
MAX_SEARCHED_BYTES = 1 << 24

#: Classes that are BRDFs beside the models.
BRDFS = (
    *("RglBrdf", "ScatteredBrdf", "DirectionTable", "HalfDifferenceTable", "WrittenBrdf"),
    *("HomomorphicFactors", "SeparableFactors"),
)

#: Axes of arrays: a number, or a letter that has one length in all arrays of an object; "!" where numbers are finite.
ARRAYS: Mapping[str, Mapping[str, str]] = {
    "BrdfSamples": {"wi": "N 3", "wo": "N 3", "value": "N 3", "wavelengths_nm": "L", "spectra": "N L"},
    "DirectionTable": {"theta_i": "A!", "phi_i": "B!", "theta_o": "C!", "phi_o": "E!", "values": "A B C E 3"},
    "HalfDifferenceTable": {"values": "H D P 3", "missing": "H D P", "planes": "3 X Y Z"},
    "RglBrdf": {"phi_i": "P!", "theta_i": "T!", "ndf": "A B!", "sigma": "C D!", "colours": "P T Y X 3!"},
    "Warp": {"density": "P T Y X!", "columns": "P T Y X!", "rows": "P T Y!"},
    "ScatteredBrdf": {"_mean": "3!"},
    "Patches": {
        "low": "B 5",
        "high": "B 5",
        "margin": "B 5!",
        "starts": "S",
        "centres": "5 M!",
        "weights": "3 M!",
    },
    "Ceiling": {"table": "A A A 3!"},
    "HomomorphicFactors": {},
    "LogSpace": {"mean": "3!", "largest": "3"},
    "LinearProjection": {"rows": "2 4!"},
    "SeparableFactors": {"first": "K R C 3", "second": "K R C 3"},
    "Sources": {"elevation": "N!", "azimuth": "N!"},
    "ImageStack": {
        "radiance": "N H W 3",
        "saturated": "N H W",
        "diffuse": "N H W 3",
        "elevation": "N!",
        "azimuth": "N!",
        "mean_radiance": "N!",
    },
    "Mesh": {"positions": "V 3!", "normals": "V 3!", "uv": "V 2!", "faces": "F 3", "part": "F", "colours": "V 3!"},
    "EnvironmentMap": {"radiance": "H W 3!"},
    "DirectionalMap": {
        "planes": "K H W",
        "low": "K!",
        "step": "K!",
        "mean": "T!",
        "vectors": "T K!",
        "lights": "N 3!",
    },
    "KeptTiles": {"place": "R C", "slices": "M S A A 3!"},
    "PowerLawMap": {"scale": "H W 3!", "exponent": "H W 3!", "rms_per_channel": "3", "error_map": "H W"},
    "ShadingMap": {"slices": "S H W 3!", "mean_radiance": "S!", "clipped": "S H W"},
    "Lamps": {"direction": "N 3!"},
    "PbrMaps": {
        "base_colour": "H W 3!",
        "normal": "H W 3!",
        "roughness": "H W!",
        "metallic": "H W!",
        "f0": "H W!",
        "height": "H W!",
        "occlusion": "H W!",
        "region": "H W!",
        "mask": "H W!",
    },
    "WideColours": {"base_colour": "H W 3!", "sigma": "H W 3"},
    "Uncertainty": {
        "base_colour": "H W 3",
        "normal": "H W",
        "roughness": "H W",
        "metallic": "H W",
        "f0": "H W",
        "height": "H W",
        "occlusion": "H W",
    },
}

#: Classes whose figures only describe a result: infinite where a measure has no bound, NaN where it is not known.
DESCRIBED = ("Health", "Fitted", "Quality", "MapErrors", "ScatteredBrdf")

#: Least and largest values of fields whose annotation only says that they are numbers, by class.
RANGES: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "Project": {"slices": (2, 4096), "error_bound_percent": (0.0, 1000.0), "white": (0.0, 1e12)},
    "Factoring": {"terms": (1, 10**6), "current": (0, RUN_NUMBERS - 1)},
    "Look": {"directions": (1, 1 << 16), "bounces": (0, 64)},
    "Accuracy": {"samples": (0, 1 << 24)},
    "Entry": {"identity": (0, 11)},
    "Run": {"identity": (0, 11), "number": (0, RUN_NUMBERS - 1)},
    "Kernel": {
        "length": (1e-9, 1e9),
        "noise": (0.0, 1e9),
        "power": (1e-3, 1e3),
        "upward": (0.0, 1e9),
        "trend": (0.0, 1e9),
    },
    "Circle": {"column": (-1e7, 1e7), "row": (-1e7, 1e7), "radius": (0.0, 1e7)},
    "ImportChoices": {
        "lamp_distance": (0.0, 1e9),
        "pair_gain": (1e-3, 1e3),
        "scale_mm": (1e-5, 100.0),
        "chart_pitch_mm": (0.1, 1000.0),
        "camera_distance_mm": (10.0, 1e5),
    },
    "Exposure": {"exposure_s": (0.0, 1e9)},
}


class Json:
    """Stands for what JSON can say: no paths, sets or objects."""


def _is_rising(starts: np.ndarray[Any, Any], count: int) -> bool:
    return len(starts) > 0 and starts[0] == 0 and starts[-1] == count and bool((np.diff(starts) >= 0).all())


def _sources_fit(of: Mapping[str, Any]) -> bool:
    count = len(of["photographs"])
    azimuth, highlights = of.get("azimuth"), of.get("highlights_px", ())
    return (
        count > 0
        and len(of["elevation"]) == len(of["exposure_s"]) == len(of["exposures"]) == count
        and (azimuth is None or len(azimuth) == count)
        and len(highlights) in (0, count)
        and all(of["exposures"])
    )


def _length_fits(known: Any) -> bool:
    """Return whether a known length can be one: two points apart, and millimetres between them."""
    try:
        return known is None or KnownLength(known[:2], known[2:4], known[4]) is not None
    except (UsageError, TypeError, IndexError, ValueError):
        return False


def _outline_fits(points: Any) -> bool:
    """Return whether an outline around an object can be one; none is no outline."""
    try:
        return not points or ObjectOutline(points) is not None
    except (UsageError, TypeError, ValueError):
        return False


def _stack_fits(of: Mapping[str, Any]) -> bool:
    count = len(of["radiance"])
    azimuth = of.get("azimuth")
    lists = (of["saturated"], of["elevation"], of["mean_radiance"], of["sources"])
    return count > 0 and all(len(each) == count for each in lists) and (azimuth is None or len(azimuth) == count)


def _source_fits(of: Mapping[str, Any]) -> bool:
    """True for a source of `app.document.factoring.names_of`."""
    kind, rest = names_of(of.get("source", MATERIAL))
    if kind == "model" and rest not in MODELS:
        brdf_from_text(rest)
    return (
        of.get("source", MATERIAL) == MATERIAL
        or kind in ("model", "file")
        or (kind == "entry" and whole_number(rest, MAX_NUMBER) is not None)
    )


def _is_brdf(text: str) -> bool:
    """True for the text of a model; UsageError says what is wrong with another."""
    return brdf_from_text(text) is not None


def _bakes_fit(of: Mapping[str, Any]) -> bool:
    """True where each method that this version knows takes the settings of its bakes; UsageError where one does not."""
    if not of.get("bakes"):
        return True

    return all(
        "method" not in said and choices_for(name, **said)
        for name, said in of["bakes"].items()
        if name in method.names()
    )


#: Conditions between the fields of an object, for those that its constructor does not check.
RULES: Mapping[str, Callable[[Mapping[str, Any]], bool]] = {
    "Patches": lambda of: len(of["starts"]) == len(of["low"]) + 1 and _is_rising(of["starts"], of["centres"].shape[1]),
    "DirectionalMap": lambda of: len(of["mean"]) == 3 * len(of["lights"]) and of["r_max"] > 0.0,
    "RglBrdf": lambda of: all(
        warp.density.shape[:2] == of["colours"].shape[:2] for warp in (of["visible"], of["luminance"])
    ),
    "Sources": _sources_fit,
    "ImportChoices": lambda of: (
        is_form(of.get("lights_form", LISTED))
        and _length_fits(of.get("known_length"))
        and _outline_fits(of.get("outline_px", ()))
    ),
    "ImageStack": _stack_fits,
    "Accuracy": lambda of: all(1 <= side <= 1 << 16 for side in of["size"]),
    "Material": lambda of: _is_brdf(of.get("brdf", "lambert")),
    "Factoring": _source_fits,
    "Run": _source_fits,
    "Project": lambda of: _bakes_fit(of) and len(of.get("name", "")) <= MAX_SHOWN,
}


class _Known(dict[str, Any]):
    """Names that a module imports for type checkers alone: classes of the document, each imported when asked for."""

    def __init__(self, own: Mapping[str, Any]) -> None:
        super().__init__()
        self._own = own

    def __missing__(self, name: str) -> Any:
        if name in self._own:
            raise KeyError(name)
        return class_named(name)


def is_known(kind: type) -> bool:
    """True for a class of the document."""
    return kind.__name__ in CLASSES.get(kind.__module__, ()) or kind in MODELS.values()


def class_named(name: str) -> type:
    """The class of the document that is called so; KeyError where there is none."""
    models = (model for model in MODELS.values() if model.__name__ == name)
    return next(models, None) or _class_of_module(name)


@cache
def _class_of_module(name: str) -> type:
    for module, names in CLASSES.items():
        if name in names:
            found: type = getattr(import_module(module), name)
            return found
    raise KeyError(name)


def _declare(kind: type) -> Mapping[str, Any]:
    """The types of the fields of a class, with those that stand for open ones."""
    return _declare_with(kind, tuple(MODELS.values()))


@cache
def _declare_with(kind: type, models: tuple[type, ...]) -> Mapping[str, Any]:
    instead: dict[tuple[str, str], Any] = {
        ("Project", "provenance"): Mapping[str, Json],
        ("ImageStack", "provenance"): Mapping[str, Json],
        ("Project", "bakes"): Mapping[str, Mapping[str, Json]],
    }
    if kind.__name__ in ("Entry", "Run"):
        brdf: Any = reduce(or_, (*models, *map(class_named, BRDFS)))
        instead |= {("Entry", "brdf"): brdf, ("Run", "given"): brdf | Path | str | None}
    own = vars(import_module(kind.__module__))
    found = typing.get_type_hints(kind, localns=_Known(own))
    return {name: instead.get((kind.__name__, name), hint) for name, hint in found.items()}


def problem_of(kind: type, values: Mapping[str, Any], *, thorough: bool = False) -> str:
    """The problem with the values of the fields of a class, '' where nothing is: 'mesh is not a mesh'.

    `thorough` also searches large arrays.
    """
    declared, ranges, lengths = _declare(kind), RANGES.get(kind.__name__, {}), dict[str, int]()
    for name, value in values.items():
        hint = declared[name]
        found = _problem(value, hint, kind.__name__ not in DESCRIBED)
        if not found and isinstance(value, int | float) and not isinstance(value, bool) and name in ranges:
            low, high = ranges[name]
            found = "" if low <= value <= high else f"is not between {low:g} and {high:g}"
        if not found and isinstance(value, np.ndarray) and kind.__name__ in ARRAYS:
            axes = ARRAYS[kind.__name__].get(name, "")
            found = _array_problem(value, axes, lengths, thorough) if axes else ""
        if found:
            return f"{name.strip('_')} {found}"
    rule = RULES.get(kind.__name__)
    fits = rule is None or not _list_required(kind) <= set(values) or rule(values)
    return "" if fits else f"the parts of a {words_of(kind)} do not fit together"


@cache
def _list_required(kind: type) -> frozenset[str]:
    """Fields that a constructor needs."""
    if not dataclasses.is_dataclass(kind):
        return frozenset()
    missing = dataclasses.MISSING
    fields = (each for each in dataclasses.fields(kind) if each.init)
    return frozenset(each.name for each in fields if each.default is missing and each.default_factory is missing)


def words_of(kind: type) -> str:
    """Name of an object of the class for users: 'shading map'."""
    letters = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in kind.__name__)
    plain = letters.strip()
    return {"image stack": "stack of photographs", "sources": "list of photographs"}.get(plain, plain)


def _problem(value: object, hint: Any, finite: bool) -> str:
    """What is wrong with a value of a declared type, as the end of a sentence; '' where nothing is."""
    if hint is Any:
        return _plain_problem(value, finite)
    if hint is Json:
        return _json_problem(value)
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if origin in (Union, types.UnionType):
        problems = [_problem(value, part, finite) for part in parts]
        return "" if "" in problems else next((each for each in problems if not each.startswith("is no ")), problems[0])
    if origin is Literal:
        fits = any(type(value) is type(each) and value == each for each in parts)
        return "" if fits else f"is none of {', '.join(map(str, parts))}"
    if origin is np.ndarray:
        return _kind_problem(value, parts)
    if origin is tuple:
        return _tuple_problem(value, parts, finite)
    if origin is not None and issubclass(origin, Mapping):
        if not isinstance(value, Mapping):
            return "is not a mapping"
        pairs = (pair for item in value.items() for pair in zip(item, parts, strict=True))
        return next((found for each, part in pairs if (found := _problem(each, part, finite))), "")
    if origin is not None and issubclass(origin, Set):
        if not isinstance(value, frozenset):
            return "is not a set"
        return next((p for each in value if (p := _problem(each, parts[0], finite))), "")
    if origin is not None and issubclass(origin, Sequence):
        if not isinstance(value, list | tuple):
            return "is not a list"
        return next((p for each in value if (p := _problem(each, parts[0], finite))), "")
    return _simple_problem(value, hint, finite)


def _simple_problem(value: object, kind: type, finite: bool) -> str:
    if kind is type(None) or kind is None:
        return "" if value is None else "is not a value"
    if kind is bool:
        return "" if isinstance(value, bool) else "is neither true nor false"
    if kind is int:
        return "" if _is_whole(value) else "is not a whole number"
    if kind is float:
        fits = _is_whole(value) or (isinstance(value, float) and (math.isfinite(value) or not finite))
        return "" if fits else "is not a finite number" if isinstance(value, float) else "is not a number"
    if kind is str:
        return "" if isinstance(value, str) and _can_be_shown(value) else "is not text"
    if isinstance(kind, type) and issubclass(kind, Path):
        return "" if isinstance(value, Path) and can_be_opened(value) else "is not a path"
    if isinstance(kind, type) and kind.__name__ == "TemporaryDirectory":
        return "" if value is None else "is not a folder"
    return "" if isinstance(value, kind) else f"is not a valid {words_of(kind)}"


def _is_whole(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and abs(value) <= MAX_NUMBER


def _can_be_shown(text: str) -> bool:
    """True for a text without halves of letters; those that stand for bytes of a file name are not halves."""
    if len(text) > MAX_TEXT:
        return False
    return text.isascii() or not any(
        "\ud800" <= letter <= "\udfff" and not "\udc80" <= letter <= "\udcff" for letter in text
    )


def can_be_opened(path: Path) -> bool:
    """True for a path that a system call takes."""
    text = str(path)
    if "\0" in text or not _can_be_shown(text) or len(text) > MAX_PATH_BYTES:
        return False
    encoded = [part.encode("utf-8", "surrogateescape") for part in path.parts]
    return sum(map(len, encoded)) <= MAX_PATH_BYTES and all(len(part) <= MAX_NAME_BYTES for part in encoded)


def _tuple_problem(value: object, parts: tuple[Any, ...], finite: bool) -> str:
    if not isinstance(value, tuple):
        return "is not a list of values"
    if len(parts) == 2 and parts[1] is Ellipsis:
        return next((found for each in value if (found := _problem(each, parts[0], finite))), "")
    if len(value) != len(parts):
        return f"has {len(value)} values in place of {len(parts)}"
    pairs = zip(value, parts, strict=True)
    return next((found for each, part in pairs if (found := _problem(each, part, finite))), "")


def _plain_problem(value: object, finite: bool) -> str:
    """As `_problem`, for what is not declared: everything but arrays, which cannot be compared as values are."""
    for kind in (bool, int, float, str, Path):
        if isinstance(value, kind):
            return _simple_problem(value, kind, finite)
    if isinstance(value, Mapping):
        return next((p for item in value.items() for each in item if (p := _plain_problem(each, finite))), "")
    if isinstance(value, tuple | list | frozenset):
        return next((found for each in value if (found := _plain_problem(each, finite))), "")
    is_known = value is None or isinstance(value, Enum) or dataclasses.is_dataclass(value)
    return "" if is_known else "is not a value"


def _json_problem(value: object) -> str:
    if isinstance(value, Mapping):
        is_named = all(isinstance(name, str) for name in value)
        return next((p for each in value.values() if (p := _json_problem(each))), "") if is_named else "has no names"
    if isinstance(value, tuple | list):
        return next((found for each in value if (found := _json_problem(each))), "")
    if value is None:
        return ""
    kind = next((kind for kind in (bool, int, float, str) if isinstance(value, kind)), None)
    return "is not a value" if kind is None else _simple_problem(value, kind, finite=True)


def _kind_problem(value: object, parts: tuple[Any, ...]) -> str:
    """An array of the kind of numbers of its annotation, in any width that this machine computes with."""
    if not isinstance(value, np.ndarray):
        return "is not an array"
    (wanted,) = typing.get_args(parts[1]) or (Any,)
    kinds: Collection[str] = "biuf"
    if isinstance(wanted, type):
        kinds = next(
            ("b" if k is np.bool_ else "iu" if k is np.integer else "f")
            for k in (np.bool_, np.integer, np.floating)
            if issubclass(wanted, k)
        )
    fits = value.dtype.kind in kinds and value.dtype.isnative and value.dtype.itemsize <= 8
    return "" if fits else f"is an array of {value.dtype}"


def _array_problem(array: np.ndarray[Any, Any], axes: str, lengths: dict[str, int], thorough: bool) -> str:
    wanted = axes.removesuffix("!").split()
    expected = tuple(int(axis) if axis.isdigit() else lengths.get(axis, -1) for axis in wanted)
    fits = array.ndim == len(wanted) and all(
        have == want or want < 0 for have, want in zip(array.shape, expected, strict=True)
    )
    if not fits:
        return f"is an array of {' × '.join(map(str, array.shape)) or 'no axes'}"
    for axis, length in zip(wanted, array.shape, strict=True):
        if lengths.setdefault(axis, length) != length:
            return f"is an array of {' × '.join(map(str, array.shape))}"
    is_searched = axes.endswith("!") and array.dtype.kind == "f" and (thorough or array.nbytes <= MAX_SEARCHED_BYTES)
    flat = array.reshape(-1)
    if is_searched and not all(np.isfinite(flat[at : at + (1 << 22)]).all() for at in range(0, len(flat), 1 << 22)):
        return "holds numbers that are not finite"
    return ""
