"""Settings of exports, a part of the project: contents of a bundle, targets for other programs, and their options."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from engine.exchange.targets import EXPORTERS
from engine.scene.credits import Credits

if TYPE_CHECKING:
    from engine.exchange.subject import Settings

#: Targets that are proposed, and those for lights all round, as conservators take photographs.
FIRST = ("textures", "materialx", "gltf")
FIRST_OF_DOME = ("web", "rti")

#: Presets, codings and directions of y of normals ('' as the preset has it).
PRESETS = ("blender", "unreal", "unity", "godot", "substance", "gltf")
CODINGS = ("png8", "png16", "exr")
NORMALS = ("", "opengl", "directx")

#: Parts of a bundle that may be left out, but not all of them.
PARTS = ("slices", "power-law", "planes", "pbr")

#: Repeats of the sample along each side of an exported tile.
REPEATS = (1, 2, 4, 8)

#: Width of the widest sample, in millimetres, and the largest error that may be asked for, in percent.
MAX_WIDTH_MM, MAX_ERROR_PERCENT = 100_000.0, 1000.0


@dataclass(frozen=True)
class Exporting:
    """Settings of exports; ValueError for values that none can have.

    Attributes
    ----------
    left_out : parts of a bundle (`PARTS`) that are not written although the material has them.
    targets : those chosen for other programs, in the order of `EXPORTERS`; None proposes those for the material.
    preset, coding, normal : of textures (`engine.exchange.subject.Settings`); '' leaves y of normals to the preset.
    width_mm : width of the sample, for the scale bar of the web page; 0 where it is not known.
    error_percent : relative RMSE within which the smallest target is looked for.
    repeats : of the sample along each side of the tile that is written, which all differ (`engine.exchange.enlarge`).
    credits : title, author, licence and source that go before those that the material and its photographs state.
    """

    left_out: frozenset[str] = field(default_factory=frozenset)
    targets: tuple[str, ...] | None = None
    preset: str = "blender"
    coding: str = "png8"
    normal: str = ""
    width_mm: float = 0.0
    error_percent: float = 5.0
    repeats: int = 1
    credits: Credits = field(default_factory=Credits)

    def __post_init__(self) -> None:
        known = (
            self.left_out <= {*PARTS},
            {*(self.targets or ())} <= EXPORTERS.keys(),
            self.preset in PRESETS and self.coding in CODINGS and self.normal in NORMALS,
            0.0 <= self.width_mm <= MAX_WIDTH_MM,
            0.0 <= self.error_percent <= MAX_ERROR_PERCENT,
            self.repeats in REPEATS,
        )
        if not all(known):
            raise ValueError("settings of exports that cannot be")

    def targets_for(self, *, is_directional: bool) -> tuple[str, ...]:
        """The targets that the user has chosen; before that those that suit a material of lights all round, or not."""
        proposed = FIRST_OF_DOME if is_directional else FIRST
        return proposed if self.targets is None else self.targets

    @property
    def settings(self) -> Settings:
        """The settings of all targets; a width below that of a dust grain counts as not known."""
        from engine.exchange.subject import WIDTHS_MM, Settings

        width_mm = self.width_mm if self.width_mm >= WIDTHS_MM[0] else None
        normal: Any = self.normal or None
        return Settings(self.preset, self.coding, normal, width_mm, credits=self.credits)  # type: ignore[arg-type]

    @property
    def of_textures(self) -> tuple[str, str, str]:
        """The settings that change what textures show."""
        return self.preset, self.coding, self.normal
