"""The ways in which the View workspace can draw a scene: each has a name, a key, and a scene of its own.

What OpenGL draws at once is a scene; a mode that is `progressive` shows that first, and then the reference over it; one
that is `baked` is a transport method (`engine.transport.method`) and shows direct light until there is a bake
(`app.view.baking`). Methods and modes are declared in the engine (`engine.scene.mode`).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from app.document.document import Look, Project
from engine.scene import mode as scene_mode
from engine.scene.mode import DIRECT, MODES, SHADING_MAP
from engine.scene.scene import RelightTransport, Scene
from engine.transport import method as transport


@dataclass(frozen=True)
class Mode:
    """A mode: `value` names it in the project; `key` chooses it while the View workspace is in front.

    `declared` is its declaration where it needs no bake. `abbreviation` stands where the label has no room. `mark` is
    that of its points in plots: pyqtgraph's name of it, and a sign like it. `colour` is the number of their colour in
    the theme, negative for that of text.
    """

    value: str
    label: str
    abbreviation: str
    key: str
    hint: str
    mark: tuple[str, str]
    colour: int
    progressive: bool = False
    baked: bool = False
    declared: scene_mode.Mode | None = None

    @property
    def shows_texels(self) -> bool:
        """True if the material is shown with its spatial variation."""
        return self.declared is None or self.declared.shows_texels

    @property
    def casts_shadows(self) -> bool:
        """True if images have shadows."""
        return self.baked or (self.declared is not None and self.declared.casts_shadows)


#: Colours of the theme for methods and for modes without a bake, in their order; the reference has that of text.
_COLOURS, _COLOURS_UNBAKED, _OF_TEXT = (0, 1, 2, 5), (3, 4, 6, 7), -1


def modes() -> tuple[Mode, ...]:
    """All modes, as they stand beside each other: first those that are baked."""
    baked = (
        Mode(
            method.name,
            method.short,
            method.abbreviation or method.short,
            method.key,
            method.hint,
            method.mark,
            _COLOURS[at % len(_COLOURS)],
            baked=True,
        )
        for at, method in enumerate(transport.METHODS)
    )
    unbaked = (
        Mode(
            mode.name,
            mode.label,
            mode.abbreviation or mode.label,
            mode.key,
            mode.hint,
            mode.mark,
            _OF_TEXT if mode.traced else _COLOURS_UNBAKED[at % len(_COLOURS_UNBAKED)],
            progressive=mode.traced,
            declared=mode,
        )
        for at, mode in enumerate(MODES.values())
    )
    return (*baked, *unbaked)


def mode_named(value: str) -> Mode:
    """The mode that a project or a setting calls so; KeyError where there is none."""
    return {mode.value: mode for mode in modes()}[value]


def mode_of(value: str, project: Project) -> Mode:
    """The mode for `value` of the project; another one if that mode cannot be shown now."""
    mode = next((each for each in modes() if each.value == value), mode_named(SHADING_MAP.name))
    return mode_named(DIRECT.name) if why_not(mode, project) else mode


def why_not(mode: Mode, project: Project) -> str:
    """The reason why a mode cannot be shown now; empty where it can."""
    if mode.declared is not None and mode.declared.needs_map and not project.has_map:
        return "Build or open a material first"
    if mode.baked and project.is_flat:
        return "A flat image casts no shadows that could be baked: Material shows it"
    if mode.progressive and project.has_map and project.look.lookup == "outgoing":
        return "Sampling by outgoing radiance needs all light at once: choose another under Sampling"
    return ""


def shows_near_lamps(mode: Mode) -> bool:
    """True if lamps near the model are part of an image in `mode`."""
    return not mode.baked or transport.method_of(mode.value).near_light


def scene_of(mode: Mode, scene: Scene, relit: RelightTransport | None = None) -> Scene:
    """The scene that OpenGL draws for `mode`, with `relit` as its relit bake, under direct light where that is None."""
    if mode.baked:
        return dataclasses.replace(scene, relit=relit, material=None if relit is None else scene.material)
    return scene if mode.declared is None else mode.declared.adapt(scene)


def exchange_modes(look: Look) -> Look:
    """The same with the two modes exchanged."""
    return dataclasses.replace(look, mode=look.against, against=look.mode)
