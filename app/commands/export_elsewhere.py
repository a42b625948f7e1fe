"""The material of a project for other programs: what each target would lose, and the files.

A material is made ready once (`engine.exchange.export.Departure`), which takes most of the time: with photographs of a
dome the surface is measured. The window keeps it for as long as material and photographs stay the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.document.document import Project
from engine.core.steps import Step, Steps, part, without_partials

if TYPE_CHECKING:
    from engine.exchange.export import Departure, Offer
    from engine.exchange.subject import Settings


@dataclass(frozen=True)
class Choices:
    """A person's choices for textures: the preset, the coding, and y of normals, where '' is as the preset has it; and
    for the web page the width of the sample in millimetres, 0 where it is not known."""

    preset: str = "blender"
    coding: str = "png8"
    normal: str = ""
    width_mm: float = 0.0

    @property
    def settings(self) -> Settings:
        from engine.exchange.subject import WIDTHS_MM, Settings

        width_mm = self.width_mm if self.width_mm >= WIDTHS_MM[0] else None
        return Settings(self.preset, self.coding, self.normal or None, width_mm)  # type: ignore[arg-type]


@dataclass(frozen=True, eq=False)
class Sent:
    """An export that was written: its folder, the bytes of its files by name, and the record."""

    folder: Path
    files: dict[str, int]
    record: dict[str, Any]


def made_ready(project: Project, leaving: Departure | None) -> Steps[Departure]:
    """`leaving` where there is one, or else the material of `project`; each is the `partial` of a step."""
    yield Step(0.0, "reading the material")
    if leaving is None:
        from engine.exchange.export import departure

        leaving = yield from without_partials(departure(project.material, project.stack))
    yield Step(1.0, "comparing", leaving)
    return leaving


def offered(project: Project, leaving: Departure | None, choices: Choices, names: Sequence[str]) -> Steps[list[Offer]]:
    """The targets `names`, each the `partial` of a step once, as is the material that is ready."""
    leaving = yield from part(made_ready(project, leaving), 0.0, 0.4)
    from engine.exchange.export import offers

    return (yield from part(offers(leaving, choices.settings, names), 0.4, 1.0))


def sent(
    project: Project, leaving: Departure | None, choices: Choices, names: Sequence[str], folder: Path
) -> Steps[Sent]:
    """Write the targets `names` into `folder`; OutputError where that is something else, or cannot be written."""
    leaving = yield from part(made_ready(project, leaving), 0.0, 0.4)
    from engine.exchange.export import RECORD, written

    record = yield from part(written(folder, leaving, names, choices.settings), 0.4, 1.0)
    listed = [name for entry in record["targets"] for name in entry["files"]]
    return Sent(folder, {name: (folder / name).stat().st_size for name in (*listed, RECORD)}, record)


def smallest_of(found: Sequence[Offer], error: float) -> dict[str, Any]:
    """The choice that `--to auto` makes among what was measured (`engine.exchange.export.choice`)."""
    from engine.exchange.export import CANDIDATES, choice

    return choice([offer for offer in found if offer.target in CANDIDATES and not offer.why_not], error)
