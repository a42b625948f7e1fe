"""The transport methods: what each is called, what can be set of it, and the modules that bake, draw and plan it.

    sh         spherical harmonics (Kautz2002; Sloan2002)
    wavelet    separable BRDFs in wavelets (Wang2004)
    gaussian   lobes for each vertex and view (Green2006)

`METHODS` is the only list of them. Command line, window, plan, sweep and benchmarks ask it for everything that
depends on the method; a further method is one more entry, and the modules that the entry names. This module is light,
because the command line reads it at every start; a method's own modules are imported when they are first asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, cast

from engine.core.errors import UsageError
from engine.core.params import Parameter, parameters
from engine.transport.baking.settings import (
    ERROR_VERTICES,
    GaussianSettings,
    NoLightSettings,
    ShLight,
    ShSettings,
    WaveletLight,
    WaveletSettings,
)

if TYPE_CHECKING:
    import os
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from engine.brdf.brdf import Brdf
    from engine.core.steps import Steps
    from engine.geometry.ground import Ground
    from engine.geometry.mesh import Mesh
    from engine.light.environment import EnvironmentMap
    from engine.transport.baking.file import TransportFile
    from engine.transport.baking.spatially_varying import Variation
    from engine.transport.relight import Illuminated, Light, RelightTransport


#: Of parameters that vary: as many as there are.
ANY_NUMBER = 1 << 20


@dataclass(frozen=True, eq=False)
class Subject:
    """Subject of a bake: `mesh`, on a ground if there is one, of a BRDF with parameters that may vary over the mesh.

    `kept` is the folder of records of visibility (`engine.transport.baking.visibility_record`), which spare a further
    bake of the mesh its rays; None for none. `parts` are the BRDFs of the parts of the mesh, one for each of its part
    names, in place of `brdf`; then each vertex belongs to one part (`engine.geometry.parts.split_parts`).
    """

    mesh: Mesh
    brdf: Brdf
    ground: Ground | None = None
    variations: Sequence[Variation] = ()
    kept: Path | None = None
    parts: tuple[Brdf, ...] = ()


class Work(Protocol):
    """A bake that is ready to begin, of whatever method."""

    @property
    def surface(self) -> Mesh: ...
    @property
    def vertices(self) -> int: ...
    @property
    def size_bytes(self) -> int: ...


class Baked(Protocol):
    """A bake that is done, of whatever method; `visibility_s` is part of `bake_s`."""

    @property
    def transport(self) -> Any: ...
    @property
    def file(self) -> TransportFile: ...
    @property
    def bake_s(self) -> float: ...
    @property
    def visibility_s(self) -> float: ...
    @property
    def chunks(self) -> int: ...
    @property
    def resumed_chunks(self) -> int: ...
    @property
    def unoccluded_vertices(self) -> int: ...


#: Makes `RelightTransport` of one transport under one light after the other, with the settings of the light and a BRDF
#: in place of the one that was baked; for one thread at a time.
Relight = Callable[["Light", Any, "Brdf"], "Steps[RelightTransport]"]


class Baking(Protocol):
    """The module that bakes a method and lights what was baked."""

    def prepare(self, subject: Subject, settings: Any, tested: EnvironmentMap | None = None) -> Steps[Any]:
        """Lay a bake out; nothing is written. ValueError where it cannot be. Errors are measured under `tested`."""

    def again(self, file: TransportFile, brdf: Brdf, kept: Path | None) -> Steps[Any]:
        """Lay the bake in `file` out with another BRDF; UsageError where the file says too little of itself."""

    def estimate_s(self, work: Any) -> float:
        """Seconds that the bake will take, without rays where what they find is kept."""

    def casts_rays(self, work: Any) -> bool:
        """False where all that rays would find is kept (`Subject.kept`)."""

    def bake(self, path: str | os.PathLike[str], work: Any, cluster: str | None = None) -> Steps[Any]:
        """Bake into the file `path`; a `Baked`."""

    def parameters(self, work: Any, settings: Any) -> dict[str, Any]:
        """The settings of a bake as its record states them."""

    def measure(
        self, work: Any, subject: Subject, settings: Any, tested: EnvironmentMap | None, vertices: int = ERROR_VERTICES
    ) -> Steps[Any]:
        """The record of the method's own error under `tested` at so many `vertices`; nothing where none is known."""

    def figures(self, work: Any, baked: Any, prepared_s: float) -> dict[str, Any]:
        """Figures of a record beside those of all methods; `skipped` and `warnings` are sentences."""

    def lines(self, result: dict[str, Any]) -> list[str]:
        """The same in sentences, from a record."""

    def transport_of(self, file: TransportFile) -> Any:
        """The transport in an open file; InputError where it holds another kind, or what cannot be."""

    def relight_transport(self, transport: Any, light: Light, asked: Any) -> RelightTransport:
        """RelightTransport transport under a light, with the settings `asked` of the light."""

    def relighter(self, transport: Any, subject: Subject) -> Relight:
        """The same for one light after the other, of a transport that was baked of `subject`."""

    def why_baked_for_one(self, transport: Any) -> str:
        """Why another BRDF asks for another bake, as a sentence; empty where it does not."""

    def restrict(self, work: Any, chosen: NDArray[np.int64]) -> Any:
        """The bake of the `chosen` vertices alone, as far as vertices do not need each other."""

    def complete(self, transport: Any, work: Any, chosen: NDArray[np.int64]) -> Any:
        """Transport of a restricted bake as that of all vertices of `work`, in memory: others copy one that is near."""

    def hold(self, transport: Any) -> Sequence[NDArray[Any]]:
        """The arrays that are in memory while it is drawn."""

    def illuminate(self, file: TransportFile, light: Light, asked: Any, brdf: str | None) -> Steps[Illuminated]:
        """The transport in a file under a light, with its figures, and with another BRDF where the method takes one."""


@dataclass(frozen=True, eq=False)
class Method:
    """One transport method.

    Attributes
    ----------
    name : in files, options and records.
    title : its name for users. noun : the same within a sentence. short : the same where there is little room.
    abbreviation : the same where there is hardly any; empty for `short`.
    key : chooses it in the View workspace; `hint` says there what it is for.
    settings, light : dataclasses of parameters (`engine.core.params`): of a bake, and of the light on it.
    baking, drawing, planning : modules. `Baking` bakes and lights; `drawing` has `Textures` for OpenGL
        (`engine.gl.transported`); `planning` predicts costs and errors (`engine.planning.costs.planned`).
    shows : effects (`engine.planning.effects.estimates.EFFECTS`) that its images can have; `always` those that they
    have
        whatever is left out.
    variations : parameters of a BRDF, at most, that can vary from vertex to vertex.
    parts : parts of a model can have BRDFs of their own.
    takes_brdf : another BRDF can be put in without a bake.
    near_light : lamps may stand near the model.
    shares_rays : bakes of several settings can share their rays; `baking` is then a `shared_rays.Sharing` too.
    dear : the parameter that costs most, about whose cheapest value a sweep turns all others as well.
    frames : kinds of frames whose rates a machine profile holds, each with the parameters at which it is measured: the
        numbers of coefficients, terms or lobes with which the cost of a frame grows.
    packed_share : bytes of a file over those of its arrays, as measured: what is said of a bake before it is made.
    mark : of its points in plots (pyqtgraph's name of it, and the sign that is nearest to it).
    """

    name: str
    title: str
    noun: str
    short: str
    key: str
    hint: str
    settings: type[Any]
    light: type[Any]
    baking_module: str
    drawing_module: str
    planning_module: str
    shows: frozenset[str]
    always: frozenset[str] = frozenset()
    variations: int = 0
    parts: bool = False
    takes_brdf: bool = False
    near_light: bool = False
    shares_rays: bool = False
    dear: str = ""
    packed_share: float = 1.0
    mark: tuple[str, str] = ("+", "+")
    frames: Mapping[str, tuple[int, ...]] = field(default_factory=lambda: MappingProxyType({}))
    abbreviation: str = ""

    def estimate_file_bytes(self, unpacked: int) -> int:
        """Bytes, roughly, of the file of a bake whose unfinished file has so many."""
        return round(self.packed_share * unpacked)

    @property
    def baking(self) -> Baking:
        return cast(Baking, import_module(self.baking_module))

    @property
    def drawing(self) -> Any:
        return import_module(self.drawing_module)

    @property
    def planning(self) -> Any:
        return import_module(self.planning_module)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters of a bake that a plan chooses and a sweep turns."""
        return tuple(each for each in parameters(self.settings) if each.sweep)

    def check_parts(self, subject: Subject) -> None:
        """UsageError where the parts of `subject` have BRDFs of their own and this method bakes one, or that varies."""
        if subject.parts and subject.variations:
            raise UsageError(
                "parameters vary over a model of one BRDF, and this one has materials for its parts; choose one with "
                "--material FILE#NAME or --brdf, or let nothing vary"
            )
        if subject.parts and not self.parts:
            raise UsageError(
                f"--mode {self.name} bakes one BRDF, and the model has materials for its parts; choose one with "
                "--material FILE#NAME or --brdf"
            )

    def with_values(self, values: Mapping[str, Any], settings: Any = None) -> Any:
        """`settings` (the defaults where None) with other values; numbers stand for flags, as in a plan.

        Values that the method does not have are left out.
        """
        base = self.settings() if settings is None else settings
        known = {each.name: each for each in parameters(base)}
        return replace(base, **{name: _value(known[name], value) for name, value in values.items() if name in known})


def _value(parameter: Parameter, value: Any) -> Any:
    if value is None:
        return None
    return bool(value) if parameter.kind == "flag" else int(value) if parameter.kind == "whole" else value


_GLOSSY = frozenset({"glossy", "anisotropy", "fresnel", "retro-reflection", "mesostructure"})

METHODS: tuple[Method, ...] = (
    Method(
        "sh",
        "Spherical harmonics",
        "spherical harmonics",
        "SH",
        "H",
        "Baked spherical harmonics: shadows under any soft light",
        ShSettings,
        ShLight,
        "engine.transport.sh_method",
        "engine.gl.sh",
        "engine.planning.methods.sh",
        _GLOSSY | {"self-shadowing", "interreflection", "all-frequency-light", "spatially-varying-gloss"},
        variations=2,
        parts=True,
        takes_brdf=True,
        near_light=True,
        shares_rays=True,
        packed_share=0.3,
        mark=("o", "●"),
        frames=MappingProxyType({"sh": (9, 144), "sh-flat": (25,)}),
    ),
    Method(
        "wavelet",
        "Wavelets",
        "wavelets",
        "Wavelets",
        "W",
        "Baked wavelets: sharp shadows under any light",
        WaveletSettings,
        WaveletLight,
        "engine.transport.wavelet_method",
        "engine.gl.wavelet",
        "engine.planning.methods.wavelet",
        _GLOSSY | {"self-shadowing", "interreflection", "all-frequency-light", "sun-split"},
        always=frozenset({"self-shadowing"}),
        parts=True,
        shares_rays=True,
        dear="cube",
        packed_share=0.21,
        mark=("s", "■"),
        frames=MappingProxyType({"wavelet": (1, 8)}),
        abbreviation="Wavel",
    ),
    Method(
        "gaussian",
        "Gaussians",
        "Gaussians",
        "Gaussians",
        "G",
        "Baked Gaussians: sharp highlights under any light",
        GaussianSettings,
        NoLightSettings,
        "engine.transport.gaussian_method",
        "engine.gl.gaussian",
        "engine.planning.methods.gaussian",
        _GLOSSY | {"self-shadowing", "interreflection", "all-frequency-light", "spatially-varying-gloss"},
        always=frozenset({"self-shadowing", "glossy", "anisotropy"}),
        variations=ANY_NUMBER,
        parts=True,
        packed_share=0.56,
        mark=("t1", "▲"),
        frames=MappingProxyType({"gaussian": (1, 6)}),
        abbreviation="Gauss",
    ),
)


#: The method of a bake where nobody chooses one.
DEFAULT = "wavelet"


def method_of(name: str) -> Method:
    """The method of that name; KeyError where there is none."""
    return {method.name: method for method in METHODS}[name]


def names() -> tuple[str, ...]:
    """The names of all methods."""
    return tuple(method.name for method in METHODS)


def methods_with(attribute: str) -> Iterator[Method]:
    """The methods for which a flag or a number of `Method` is not 0."""
    return (method for method in METHODS if getattr(method, attribute))
