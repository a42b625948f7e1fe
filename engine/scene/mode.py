"""Modes without a bake, each declared once: how the scene is drawn, its parameters, and what users read.

The window, the command line, the library, plans and sweeps derive their modes from here and from the transport methods
(`engine.transport.method`). Another package adds a mode by `register` or by an entry point of the group
`lightarc.modes`: a scene that is made of the one that a user sees, and summed over its lights.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import NamedTuple

from engine.core import plugins
from engine.scene.material import at_mean
from engine.scene.scene import Scene

#: Group of the entry points by which installed packages bring further modes.
ENTRY_POINTS = "lightarc.modes"

_NAME = re.compile(r"[a-z][a-z0-9-]{0,63}")

Number = int | float


@dataclass(frozen=True)
class ModeParameter:
    """A parameter of a mode: its range, its default, and the values of a sweep, cheapest first.

    Where there are `values`, no others are possible.
    """

    low: Number
    high: Number
    default: Number
    sweep: tuple[Number, ...]
    text: str
    values: tuple[Number, ...] = ()


class Spread(NamedTuple):
    """Ratios of measured to predicted errors, between which 95 of 100 lie on generated scenes.

    `by_camera` of images of the camera that the prediction is made for, `around` of those of any other.
    """

    by_camera: tuple[float, float]
    around: tuple[float, float]

    def of(self, has_camera: bool) -> tuple[float, float]:
        return self.by_camera if has_camera else self.around


def _directions(*sweep: int) -> Mapping[str, ModeParameter]:
    text = "lights that stand for the environment"
    return MappingProxyType({"directions": ModeParameter(1, 4096, 64, sweep, text)})


def _keep(scene: Scene) -> Scene:
    return scene


@dataclass(frozen=True)
class Mode:
    """A way to draw a scene that needs no bake.

    Attributes
    ----------
    name : in projects, options and records.
    title, label : for users, in plots and tables, and on the button of the window. abbreviation : the label where there
        is little room, or empty.
    key, hint : chooses it in the View workspace, where it is not empty; what it is for.
    adapt : the scene that is drawn of the one that a user sees.
    shows : effects (`engine.planning.effects.estimates.EFFECTS`) that its images can have, of those that not all have.
    shows_of_sharp : those that they have of sharp lights alone: one direction, lamps, and the suns of an environment.
    parameters : by name; the first is the one that the time of an image grows with. Those without `traced` have
        directions.
    spread : how far measured errors are from predicted ones; None for a mode that plans and sweeps leave out, because
        it is meant to show something else than the scene.
    dear : the parameter that costs most, about whose cheapest value a sweep turns all others as well, or empty.
    traced : drawn by random paths of light, on the CPU, refined while nothing moves.
    needs_map : shows a material that is looked up, and nothing without one.
    mark : of its points in plots (pyqtgraph's name of it, and the sign that is nearest to it).
    """

    name: str
    title: str
    label: str
    hint: str
    adapt: Callable[[Scene], Scene] = _keep
    abbreviation: str = ""
    key: str = ""
    shows: frozenset[str] = frozenset({"glossy"})
    shows_of_sharp: frozenset[str] = frozenset()
    parameters: Mapping[str, ModeParameter] = field(default_factory=lambda: _directions(4, 16, 64, 256))
    spread: Spread | None = None
    dear: str = ""
    traced: bool = False
    needs_map: bool = False
    mark: tuple[str, str] = ("h", "⬢")

    @property
    def shows_texels(self) -> bool:
        """True if images show the material with its spatial variation."""
        return "mesostructure" in self.shows

    @property
    def casts_shadows(self) -> bool:
        """True if images have shadows, at least of sharp lights."""
        return "self-shadowing" in self.shows | self.shows_of_sharp


def _cast_shadows(scene: Scene) -> Scene:
    """The BRDF alone, with shadows of sharp lights; where parts of the model or its vertices have their own, those,
    unless another BRDF than that of the material is to be seen."""
    material = scene.material
    has_parts = len(scene.parts) > 1 or scene.colours is not None
    if material is None or not has_parts or scene.brdf != material.reflectance:
        return replace(scene, material=None, shadows=True)
    return replace(scene, material=at_mean(material), shadows=True)


SHADING_MAP = Mode(
    "shading-map",
    "Shading map",
    "Material",
    "The photographs of the material under every light, without shadows",
    abbreviation="Mat.",
    key="M",
    shows=frozenset({"glossy", "mesostructure"}),
    parameters=MappingProxyType(
        {
            **_directions(4, 16, 64, 256),
            "power_law": ModeParameter(
                0, 1, 0, (1, 0), "whether two numbers for each texel take the place of the slices"
            ),
        }
    ),
    spread=Spread(by_camera=(0.5, 2.0), around=(0.5, 2.0)),  # assumed: scenes are generated without photographs
    dear="directions",
    needs_map=True,
    mark=("d", "◆"),
)
DIRECT = Mode(
    "direct",
    "Direct",
    "Direct",
    "The BRDF alone under every light, with the shadows of all lights",
    _cast_shadows,
    key="D",
    shows_of_sharp=frozenset({"self-shadowing"}),
    parameters=_directions(4, 16, 64, 256, 1024),
    spread=Spread(by_camera=(0.15, 2.0), around=(0.03, 5.0)),
    mark=("t", "▼"),
)
REFERENCE = Mode(
    "reference",
    "Reference",
    "Reference",
    "Path tracing with shadows; its noise falls with time",
    abbreviation="Ref.",
    key="R",
    shows=frozenset({"self-shadowing", "interreflection", "glossy", "mesostructure"}),
    parameters=MappingProxyType({"samples": ModeParameter(1, 65536, 64, (1, 4, 16, 64, 256), "paths for each pixel")}),
    spread=Spread(by_camera=(0.43, 1.05), around=(0.37, 1.1)),
    traced=True,
    mark=("star", "★"),
)

#: Modes without a bake by name, in the order in which they are offered.
MODES: dict[str, Mode] = {mode.name: mode for mode in (SHADING_MAP, DIRECT, REFERENCE)}


def register(mode: Mode) -> Mode:
    """Declare a mode of another package; ValueError where it lacks something or its name is taken."""
    if not isinstance(mode, Mode) or not (mode.title and mode.label and mode.hint):
        raise ValueError("a mode is a Mode with a title, a label and a hint")
    if not _NAME.fullmatch(mode.name) or mode.name == "auto":
        raise ValueError(f"{mode.name!r} is not a name of lower-case words joined by hyphens")
    if mode.traced or "directions" not in mode.parameters:
        raise ValueError(f"the mode {mode.name} is not summed over directions: the reference alone is traced")
    if MODES.get(mode.name, mode) is not mode:
        raise ValueError(f"there is another mode {mode.name}")
    if mode.key and any(mode.key == other.key for other in MODES.values() if other is not mode):
        raise ValueError(f"the key {mode.key} of the mode {mode.name} is taken")
    MODES[mode.name] = mode
    return mode


def unregister(mode: Mode) -> None:
    """Take back what `register` did."""
    if MODES.get(mode.name) is mode:
        del MODES[mode.name]


def is_traced(mode: str) -> bool:
    """Return whether images of a mode, of whatever kind, are traced."""
    return mode in MODES and MODES[mode].traced


plugins.load(ENTRY_POINTS, register)
