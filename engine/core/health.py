"""Doubtful numbers are not exceptions: they are counted here and shown."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from types import MappingProxyType

from engine.core.errors import VERBS


class Verdict(IntEnum):
    """Severity of a finding, in rising order."""

    GOOD = 0
    NOTE = 1
    WARNING = 2
    BAD = 3


@dataclass(frozen=True)
class Finding:
    """One observation in plain words, and the photograph (or other source) it concerns, if a single one."""

    verdict: Verdict
    text: str
    source: str | None = None

    @property
    def sentence(self) -> str:
        """The observation with its subject: 'a.tif is noisy', 'b.tif: 10 % of the pixels are black'."""
        return f"{self.source}{self.between}{self.text}" if self.source else self.text

    @property
    def between(self) -> str:
        """Letters that join the source and the text: a space before a verb, else a colon."""
        return " " if self.text.split(" ", 1)[0] in VERBS else ": "


@dataclass(frozen=True)
class Health:
    """Counts (clamped, masked, filled, non-finite …) and condition figures of a result, with its findings."""

    figures: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    findings: tuple[Finding, ...] = ()

    @property
    def verdict(self) -> Verdict:
        return max((finding.verdict for finding in self.findings), default=Verdict.GOOD)

    @property
    def warnings(self) -> list[str]:
        """The findings that need attention, as sentences."""
        return [finding.sentence for finding in self.findings if finding.verdict >= Verdict.WARNING]

    def without(self, sources: Collection[str]) -> Health:
        """The same, less what is found in `sources`: photographs that a user left out worry nobody any more."""
        kept = tuple(finding for finding in self.findings if finding.source not in sources)
        return Health(self.figures, kept)

    def merge(self, other: Health) -> Health:
        """Both together; a figure of `other` replaces one of the same name."""
        return Health(MappingProxyType({**self.figures, **other.figures}), self.findings + other.findings)
