"""The ways in which the View workspace can draw a scene: each has a name, a key, and a scene of its own.

What OpenGL draws at once is a scene; a mode that is `progressive` shows that first, and then the reference over it; one
that is `baked` shows direct light until there is a bake (`app.baking`). A further mode is one more line of `MODES` and,
where it draws something else, of `scene_of`.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from app.document import Look, Project
from engine.scene import Scene


@dataclass(frozen=True)
class Mode:
    """`value` is what the project keeps; `key` chooses it while the View workspace is in front."""

    value: str
    label: str
    key: str
    hint: str
    progressive: bool = False
    baked: bool = False


MODES = (
    Mode("sh", "SH", "H", "Baked spherical harmonics: shadows under any soft light", baked=True),
    Mode("wavelet", "Wavelet", "W", "Baked wavelets: sharp shadows under any light", baked=True),
    Mode("gaussian", "Gaussian", "G", "Baked Gaussians: sharp highlights under any light", baked=True),
    Mode("shading-map", "Shading map", "M", "The material's photographs, looked up under every light"),
    Mode("direct", "Direct", "D", "The reflectance alone under every light, without shadows"),
    Mode("reference", "Reference", "R", "Paths of light with shadows, finer the longer you look", progressive=True),
)

_BY_VALUE = {mode.value: mode for mode in MODES}


def mode_of(value: str, project: Project) -> Mode:
    """The mode that is shown where the project asks for `value`: another one where that cannot be shown now."""
    mode = _BY_VALUE.get(value, _BY_VALUE["shading-map"])
    return _BY_VALUE["direct"] if why_not(mode, project) else mode


def why_not(mode: Mode, project: Project) -> str:
    """Why a mode cannot be shown now; empty where it can."""
    if mode.value == "shading-map" and not project.has_map:
        return "Build or open a material first"
    if mode.progressive and project.has_map and project.look.lookup == "outgoing":
        return "The look-up by outgoing radiance is of all light at once: choose another under Look-up"
    return ""


def scene_of(mode: Mode, scene: Scene, lit: Any = None) -> Scene:
    """What OpenGL draws for `mode`, where `lit` is its baked light."""
    if mode.baked:
        return dataclasses.replace(scene, material=None, lit=lit)
    return dataclasses.replace(scene, material=None) if mode.value == "direct" else scene


def flipped(look: Look) -> Look:
    """The same with the two modes exchanged."""
    return dataclasses.replace(look, mode=look.against, against=look.mode)
