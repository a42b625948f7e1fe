"""Title, author, licence and source of a material, which travel with it."""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from engine.core.errors import UsageError

#: Most characters of an entry.
LONGEST = 300


@dataclass(frozen=True)
class Credits:
    """Facts that others ask to be told of a material; "" where nothing is known.

    Attributes
    ----------
    title, author : of the work, as people write them.
    licence : an SPDX identifier (`CC-BY-4.0`), or words.
    copyright : the notice that a file stated, as it stated it.
    source : an address or a reference.
    """

    title: str = ""
    author: str = ""
    licence: str = ""
    copyright: str = ""
    source: str = ""

    def __post_init__(self) -> None:
        """UsageError for entries that are too long or that no line of text can hold."""
        for each in fields(self):
            value = getattr(self, each.name)
            if len(value) > LONGEST or not all(letter.isprintable() for letter in value):
                raise UsageError(f"the {each.name} of a material is one line of at most {LONGEST} characters")

    def __bool__(self) -> bool:
        """True where anything is known."""
        return bool(self.entries)

    @property
    def entries(self) -> dict[str, str]:
        """Entries that are known, by name."""
        return {each.name: value for each in fields(self) if (value := getattr(self, each.name))}

    @property
    def line(self) -> str:
        """All of it in one line."""
        found = self.entries
        notice = found.pop("copyright", "")
        said = [notice] if notice else []
        said += [f"{name}: {value}" for name, value in found.items()]
        return "; ".join(said)

    @property
    def ascii_line(self) -> str:
        """The line in letters without accents, for formats that hold no others."""
        return unicodedata.normalize("NFKD", self.line).encode("ascii", "ignore").decode()

    def over(self, others: Credits) -> Credits:
        """These, and those of `others` where nothing is known."""
        return replace(others, **self.entries)


def credits_of(values: object) -> Credits:
    """The credits in JSON of a file; what is none, or is too long, is left out."""
    if not isinstance(values, Mapping):
        return Credits()
    return Credits(**{each.name: clean(values.get(each.name)) for each in fields(Credits)})


def clean(value: Any) -> str:
    """A text of a file as an entry: one line of printable characters, cut to `LONGEST`; '' for anything else."""
    if not isinstance(value, str):
        return ""
    return "".join(letter if letter.isprintable() else " " for letter in value).strip()[:LONGEST]
