"""Ways in which the reflectance of the model is not the same all over it, as a user sets them: `Project.variations`.

    a parameter of the BRDF      goes from one value to another    spherical harmonics, Gaussians
    another BRDF                 is mixed in                       wavelets
    an image                    multiplies the radiance           wavelets

Each follows the place in the bounding box of the model, or an image at its texture coordinates
(`engine.transport.baking.spatially_varying`, `engine.transport.baking.blend`). A transport method shows what its
settings have a place for; every other mode draws the one BRDF.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.widgets.labels import BRDF_LABELS
from engine.brdf.brdf import MODELS, brdf_from_text, label_of
from engine.core.params import parameters
from engine.transport import method as transport
from engine.transport.method import Method

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.transport.baking.spatially_varying import Variation as EngineVariation

#: "x", "y" or "z" across the bounding box, or an image.
AXES = ("x", "y", "z")
Source = str | Path


@dataclass(frozen=True)
class VariedParameter:
    """A parameter of the BRDF that goes from `start` to `stop` where the number of `source` goes from 0 to 1."""

    parameter: str
    start: float
    stop: float
    source: Source = "y"

    def __post_init__(self) -> None:
        if not (isfinite(self.start) and isfinite(self.stop)):
            raise ValueError(f"{self.parameter} cannot go from {self.start} to {self.stop}")
        _check_source(self.source)

    def __str__(self) -> str:
        return BRDF_LABELS.get(self.parameter, self.parameter.replace("_", " "))


@dataclass(frozen=True)
class Blend:
    """Another BRDF, a model's text or a file, whose weight is the number of `source`; the BRDF has what is left."""

    brdf: str | Path
    source: Source = "y"

    def __post_init__(self) -> None:
        if isinstance(self.brdf, str):
            brdf_from_text(self.brdf)
        _check_source(self.source)

    def __str__(self) -> str:
        if isinstance(self.brdf, Path):
            return f"With {self.brdf.name}"
        name = self.brdf.partition(":")[0]
        return f"With {label_of(name)}"


@dataclass(frozen=True)
class Colours:
    """An image that multiplies the radiance."""

    image: Path

    def __str__(self) -> str:
        return "Colours"


def _check_source(source: Source) -> None:
    if not isinstance(source, Path) and source not in AXES:
        raise ValueError(f"{source!r:.60} is not a source of a variation")


Variation = VariedParameter | Blend | Colours


def images_of(variations: Iterable[Variation]) -> tuple[Path, ...]:
    """The files that variations are read from, each once."""
    named = (getattr(each, name, None) for each in variations for name in ("source", "image", "brdf"))
    return tuple(dict.fromkeys(each for each in named if isinstance(each, Path)))


def find_varied_in(brdf: Brdf, variations: Iterable[Variation]) -> tuple[VariedParameter, ...]:
    """The varied parameters that a BRDF has; only analytic models have any."""
    names = {each.name for each in (parameters(brdf) if type(brdf) in MODELS.values() else ())}
    return tuple(each for each in variations if isinstance(each, VariedParameter) and each.parameter in names)


def select_shown(method: Method, brdf: Brdf, variations: Sequence[Variation]) -> tuple[Variation, ...]:
    """The variations that images of a method have: of parameters the first that it has room for."""
    takes = {each.name for each in parameters(method.settings)}
    kept = {id(each) for each in find_varied_in(brdf, variations)[: method.variations]}
    kept |= {id(each) for each in variations if isinstance(each, Blend) and "blend" in takes}
    colours = [each for each in variations if isinstance(each, Colours) and "albedo" in takes]
    kept |= {id(each) for each in colours[:1]}
    return tuple(each for each in variations if id(each) in kept)


def select_baked(method: Method, brdf: Brdf, variations: Sequence[Variation]) -> tuple[Variation, ...]:
    """Those that are part of a bake: colours that can be put on a finished one are not."""
    of_light = {each.name for each in parameters(method.light)}
    shown = select_shown(method, brdf, variations)
    return tuple(each for each in shown if not (isinstance(each, Colours) and "albedo" in of_light))


def as_baked(variations: Iterable[Variation]) -> tuple[EngineVariation, ...]:
    """The varied parameters as a bake takes them."""
    from engine.transport.baking.spatially_varying import Variation as Baked

    varied = (each for each in variations if isinstance(each, VariedParameter))
    return tuple(Baked(each.parameter, float(each.start), float(each.stop), str(each.source)) for each in varied)


def settings_with(settings: Any, variations: Iterable[Variation]) -> Any:
    """Settings of a bake with the other BRDFs and the colours, where they have a place for them."""
    found = tuple(variations)
    said: dict[str, Any] = {"blend": tuple(f"{each.brdf}:{each.source}" for each in found if isinstance(each, Blend))}
    said["albedo"] = next((str(each.image) for each in found if isinstance(each, Colours)), None)
    return _with_known(settings, said)


def light_with(light: Any, variations: Iterable[Variation]) -> Any:
    """Settings of the light on a bake with what can be put on it, where they have a place for it."""
    from engine.transport.baking.spatially_varying import variation_to_text

    found = tuple(variations)
    said: dict[str, Any] = {"vary": tuple(variation_to_text(each) for each in as_baked(found))}
    said["albedo"] = next((str(each.image) for each in found if isinstance(each, Colours)), None)
    return _with_known(light, said)


def _with_known(settings: Any, said: dict[str, Any]) -> Any:
    """`settings` with those of `said` that they have a place for, and do not say otherwise."""
    free = {each.name for each in parameters(settings) if not getattr(settings, each.name)}
    return dataclasses.replace(settings, **{name: value for name, value in said.items() if name in free and value})


def list_left_out_by(mode: str, brdf: Brdf, variations: Sequence[Variation]) -> tuple[Variation, ...]:
    """The variations that images of a mode leave out."""
    shown = select_shown(transport.method_of(mode), brdf, variations) if mode in transport.names() else ()
    return tuple(each for each in variations if not any(each is kept for kept in shown))


def words_on_left_out(label: str, mode: str, brdf: Brdf, variations: Sequence[Variation]) -> str:
    """A sentence on what images of a mode leave out, and which bakes would show; empty where nothing is left out."""
    left_out = list_left_out_by(mode, brdf, variations)
    if not left_out:
        return ""
    nouns = {
        method.noun: None for each in left_out for method in transport.METHODS if select_shown(method, brdf, (each,))
    }
    what = ", ".join(f"‘{each}’" for each in left_out)
    where = f"bakes in {' or '.join(nouns)} show it" if nouns else "this BRDF has no such parameter"
    return f"{label} leaves out what varies over the model, {what}: {where}."
