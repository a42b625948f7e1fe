"""A material on its way out: what every target is made of, what is asked of it, and what it becomes.

Names of files are those of the material in letters, digits, `-` and `_`, which every importer takes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from engine.exchange.coding import Coding, Handedness, rounded
from engine.exchange.loss import Shown, maps_shown
from engine.scene.material import Material
from engine.surface.pbr_maps import DIELECTRIC_F0, PbrMaps

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

_LONGEST_NAME = 60


@dataclass(frozen=True, eq=False)
class Subject:
    """The material that leaves.

    Attributes
    ----------
    maps : PBR maps nearest to it, or measured ones, relative to a white card.
    white : radiance of that card where it faces a lamp, 1 = white level of the photographs.
    cavity : (H, W) of `engine.exchange.pbr_from_material`, None without a power law.
    stack : its photographs, where they are at hand.
    """

    material: Material
    maps: PbrMaps
    white: float = 1.0
    cavity: NDArray[np.float32] | None = None
    stack: ImageStack | None = None
    _shown: dict[Any, Shown] = field(default_factory=dict, repr=False)

    def shown_as(self, coding: Coding, *, keeps_f0: bool = True) -> Shown:
        """The PBR maps as readers of textures get them back; one object for equal codings, which is measured once."""
        maps, plain = self.maps, np.full(self.maps.size, DIELECTRIC_F0, np.float32)
        keeps_f0 = keeps_f0 and not np.allclose(maps.f0, plain, atol=1e-3)
        key = (coding, keeps_f0)
        if key not in self._shown:
            back = rounded(maps, coding)
            self._shown[key] = maps_shown(back if keeps_f0 else replace(back, f0=plain), np.pi * self.white)
        return self._shown[key]

    @property
    def name(self) -> str:
        """The material's name as a part of file names."""
        return plain_name(self.material.name)


@dataclass(frozen=True)
class Settings:
    """Choices of a person for all targets; see `engine.exchange.textures` for presets, whose program `normal` None
    leaves the direction of y to."""

    preset: str = "blender"
    coding: Coding = "png8"
    normal: Handedness | None = None


@dataclass(frozen=True, eq=False)
class Contents:
    """Files and figures of a target.

    Attributes
    ----------
    files : content by path within the target's folder, in the order of writing.
    bytes_per_texel : that shading one point reads.
    record : further JSON values for the record of the export, such as the range of a height map.
    """

    files: Mapping[str, bytes]
    bytes_per_texel: float | None = None
    warnings: tuple[str, ...] = ()
    record: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))


def plain_name(name: str) -> str:
    """`name` in letters, digits, `-` and `_`, beginning with a letter: a word in every format."""
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_-")[:_LONGEST_NAME] or "material"
    return plain if plain[0].isalpha() else f"m_{plain}"
