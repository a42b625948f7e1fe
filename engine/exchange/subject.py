"""A material on its way out: what every target is made of, what is asked of it, and what it becomes.

Names of files are those of the material in letters, digits, `-` and `_`, which every importer takes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.exchange.coding import Coding, Handedness, round_values
from engine.exchange.layers import Layers
from engine.exchange.loss import Shown, maps_shown
from engine.scene.credits import Credits
from engine.scene.material import Material, compute_fit_error
from engine.scene.scene import TILING_MODES, TilingMode
from engine.storage.atomic import Pieces
from engine.surface.pbr_maps import PbrMaps

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

_LONGEST_NAME = 60

#: Widths of samples, from a dust grain to a hall.
WIDTHS_MM = (0.01, 100_000.0)


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
    _shown: dict[Any, Shown | None] = field(default_factory=dict, repr=False)

    def remember(self, key: Hashable, make: Callable[[], Shown | None]) -> Shown | None:
        """The first result of `make` for the `key`: one object for equal representations, which is measured once."""
        if key not in self._shown:
            self._shown[key] = make()
        return self._shown[key]

    @property
    def has_normals(self) -> bool:
        """False for PBR maps of flat normals: 8 bits have no 0, and a map of them would tilt a smooth coat by 0.3°."""
        return self.material.pbr is None or bool(np.any(self.maps.normal[..., :2] != 0.0))

    def decode_as(
        self,
        coding: Coding,
        f0: float | None = None,
        *,
        layers: Layers | Literal["own"] | None = "own",
        omits_flat: bool = False,
    ) -> Shown:
        """The PBR maps as readers of textures get them back, one object for equal codings.

        `f0` is the one that readers take in place of the map where they take one. `layers` are those that
        they know, all of the maps by default. With `omits_flat` they are given no map of normals that are all flat.
        """
        if f0 is not None and np.allclose(self.maps.f0, f0, atol=1e-3):
            f0 = None

        known = self.maps.layers if layers == "own" else layers
        exact = omits_flat and not self.has_normals

        def make() -> Shown:
            back = round_values(self.maps, coding)
            read = back if f0 is None else replace(back, f0=np.full(back.size, f0, np.float32))
            read = replace(read, layers=known)
            read = replace(read, normal=self.maps.normal) if exact else read
            return maps_shown(read, np.pi * self.white)

        found = self.remember((coding, f0, known, exact), make)
        assert found is not None
        return found

    @property
    def portable(self) -> Material:
        """The material as shaders and pages hold it: with the nearest model in place of a measured BRDF."""
        return self.material if self.material.measured is None else replace(self.material, measured=None)

    @property
    def mean_f0(self) -> float:
        """The one that stands for all in formats that hold no map of it."""
        return float(self.maps.f0.mean(dtype=np.float64))

    @property
    def name(self) -> str:
        """The material's name as a part of file names."""
        return plain_name(self.material.name)


@dataclass(frozen=True)
class Settings:
    """Choices of a user for all targets; see `engine.exchange.textures` for presets, whose program `normal` None
    leaves the direction of y to. `width_mm` is the width of the sample, for scale bars; None where it is not known.
    `tiling_mode` is 'hex' for MaterialX without a visible period (`engine.render.hex_tiling`). `credits` go before
    those of the material."""

    preset: str = "blender"
    coding: Coding = "png8"
    normal: Handedness | None = None
    width_mm: float | None = None
    tiling_mode: TilingMode = "grid"
    credits: Credits = field(default_factory=Credits)

    def __post_init__(self) -> None:
        """UsageError for a width that no sample has, and another tiling mode."""
        if self.tiling_mode not in TILING_MODES:
            raise UsageError(f"unknown tiling mode {self.tiling_mode!r}; choose from {', '.join(TILING_MODES)}")
        if self.width_mm is not None and not WIDTHS_MM[0] <= self.width_mm <= WIDTHS_MM[1]:
            raise UsageError(f"a width of {self.width_mm:g} mm is not within {WIDTHS_MM[0]:g} to {WIDTHS_MM[1]:g} mm")


class Files(Mapping[str, bytes]):
    """Contents of files by their paths, in the order of writing; those that are functions are made when asked for.

    So of a large material one file is in memory at a time.
    """

    def __init__(self, files: Mapping[str, bytes | Callable[[], bytes | Pieces]]) -> None:
        self._files = dict(files)

    def __getitem__(self, path: str) -> bytes:
        content = self.take(path)
        return content if isinstance(content, bytes) else b"".join(content)

    def take(self, path: str) -> bytes | Pieces:
        """The content of a file, or the pieces in which it is made."""
        content = self._files[path]
        return content if isinstance(content, bytes) else content()

    def __iter__(self) -> Iterator[str]:
        return iter(self._files)

    def __len__(self) -> int:
        return len(self._files)


@dataclass(frozen=True, eq=False)
class Contents:
    """Files and figures of a target.

    Attributes
    ----------
    files : content by path within the target's folder, in the order of writing; `Files` where it is large.
    bytes_per_texel : that shading one point reads.
    record : further JSON values for the record of the export, such as the range of a height map.
    pages : files that are made piece by piece, by path, which come before `files`.
    """

    files: Mapping[str, bytes]
    bytes_per_texel: float | None = None
    warnings: tuple[str, ...] = ()
    record: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    pages: Mapping[str, Pieces] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def paths(self) -> list[str]:
        return [*self.pages, *self.files]

    def content(self, path: str) -> bytes | Pieces:
        """The bytes of the file at a path, or its pieces."""
        if path in self.pages:
            return self.pages[path]
        return self.files.take(path) if isinstance(self.files, Files) else self.files[path]


def fit_warnings(subject: Subject) -> tuple[str, ...]:
    """The error of the model that stands for a measured BRDF, as one sentence; none where nothing was measured."""
    error = compute_fit_error(subject.material)
    if error is None:
        return ()
    return (f"the BRDF is a fit of the measured one, {percent(error, 3)} away (relative RMSE of f cos)",)


def plain_name(name: str) -> str:
    """`name` in letters, digits, `-` and `_`, beginning with a letter: a word in every format."""
    plain = re.sub(r"[^A-Za-z0-9_-]{1,99}", "_", name).strip("_-")[:_LONGEST_NAME] or "material"
    return plain if plain[0].isalpha() else f"m_{plain}"
