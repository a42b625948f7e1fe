"""The BRDFs that the BRDF workspace compares, and the files of its library: a part of the project.

Each one is known by a colour and a marker that no other has, in the list, in space and in every plot, for as long as
it stays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.widgets.resources import LINES
from engine.brdf.brdf import Brdf
from engine.brdf.fit import Weighting
from engine.core.errors import UsageError

#: pyqtgraph's names of the markers; each goes with the colour at its place in the cycle of `LINES`.
MARKERS = ("o", "s", "t1", "d", "p", "star", "x", "+", "t", "h", "t2", "t3")


@dataclass(frozen=True)
class Fitted:
    """The origin of a fitted model: its target, its method, and its relative RMS errors before and after."""

    of: str
    weighting: Weighting
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class Entry:
    """One BRDF under comparison; `identity` numbers its colour and marker, `path` is the file it came from."""

    name: str
    brdf: Brdf
    identity: int
    visible: bool = True
    path: Path | None = None
    fitted: Fitted | None = None

    @property
    def colour(self) -> str:
        """As '#rrggbb'."""
        return colour_of(self.identity)

    @property
    def marker(self) -> str:
        """pyqtgraph's name of it."""
        return MARKERS[self.identity]


def colour_of(identity: int) -> str:
    """The colour that goes with a number."""
    return LINES[identity % len(LINES)]


@dataclass(frozen=True, eq=False)
class Comparison:
    """The entries in the order of the list, and the files of the library, the latest first."""

    entries: tuple[Entry, ...] = ()
    files: tuple[Path, ...] = ()

    @property
    def free_identity(self) -> int | None:
        """The first colour and marker that nobody has; None where all are taken."""
        taken = {entry.identity for entry in self.entries}
        return next((number for number in range(len(MARKERS)) if number not in taken), None)

    def find(self, identity: int | None) -> Entry | None:
        """The entry with this colour and marker."""
        return next((entry for entry in self.entries if entry.identity == identity), None)

    def added(
        self, name: str, brdf: Brdf, path: Path | None = None, fitted: Fitted | None = None, *, visible: bool = True
    ) -> Comparison:
        """With one more; UsageError where no colour and marker are left."""
        identity = self.free_identity
        if identity is None:
            raise UsageError(f"at most {len(MARKERS)} BRDFs are compared")
        taken = {entry.name for entry in self.entries}
        names = (name, *(f"{name} {number}" for number in range(2, len(MARKERS) + 2)))
        unique = next(each for each in names if each not in taken)
        entry = Entry(unique, brdf, identity, visible, path, fitted)
        return replace(self, entries=(*self.entries, entry))

    def changed(self, identity: int, **parts: Any) -> Comparison:
        """With `parts` of one entry replaced."""
        entries = tuple(replace(each, **parts) if each.identity == identity else each for each in self.entries)
        return replace(self, entries=entries)

    def removed(self, identity: int) -> Comparison:
        """Without one entry."""
        return replace(self, entries=tuple(each for each in self.entries if each.identity != identity))

    def with_file(self, path: Path, instead_of: Path | None = None) -> Comparison:
        """With `path` in the library, in front or in the place of another."""
        if instead_of in self.files and path not in self.files:
            return replace(self, files=tuple(path if file == instead_of else file for file in self.files))
        kept = tuple(file for file in self.files if file not in (path, instead_of))
        return replace(self, files=(path, *kept))
