"""Doubtful numbers are not exceptions: they are counted here and shown."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from types import MappingProxyType

from engine.core.errors import VERBS
from engine.core.figure_text import figure_pattern, read_figure

#: Sources of which each has a finding of its own; alike findings about more become one.
MAX_APART = 3

_ITS = re.compile(r"\bits\b")
_MORE = re.compile(r"and \d{1,9} more\b")
_PLURALS = {"is": "are", "was": "were", "has": "have", "does": "do", "changed": "changed"}


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
        """Letters that join the source and the text: a space before a verb, or others like it, else a colon."""
        return " " if self.text.split(" ", 1)[0] in VERBS or _MORE.match(self.text) else ": "


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
        """The findings that need attention, as sentences; one of those about many sources that are alike."""
        return [finding.sentence for finding in self.summary if finding.verdict >= Verdict.WARNING]

    @property
    def summary(self) -> tuple[Finding, ...]:
        """The findings, where those about many sources that differ by numbers alone are one, at the place of the first.

        Examples
        --------
        >>> text = "is noisy: its mean is {} times the noise"
        >>> dark = [Finding(Verdict.NOTE, text.format(n), f"{n}.tif") for n in range(2, 7)]
        >>> [finding.sentence for finding in Health(findings=tuple(dark)).summary]
        ['2.tif and 4 more are noisy: their mean is 2 to 6 times the noise']
        """
        alike: dict[tuple[Verdict, tuple[str, ...]], list[Finding]] = {}
        for finding in self.findings:
            if finding.source is not None:
                alike.setdefault(_kind(finding), []).append(finding)
        said = []
        for finding in self.findings:
            group = alike.get(_kind(finding), []) if finding.source is not None else []
            if len(group) <= MAX_APART:
                said.append(finding)
            elif finding is group[0]:
                said.append(_merge(group))
        return tuple(said)

    def without(self, sources: Collection[str]) -> Health:
        """The same, less what is found in `sources`: photographs that a user left out worry nobody any more."""
        kept = tuple(finding for finding in self.findings if finding.source not in sources)
        return Health(self.figures, kept)

    def merge(self, other: Health) -> Health:
        """Both together; a figure of `other` replaces one of the same name."""
        return Health(MappingProxyType({**self.figures, **other.figures}), self.findings + other.findings)


def pluralise(verb: str) -> str:
    """Return a verb of `errors.VERBS` as it stands behind several subjects: 'are' for 'is'."""
    return _PLURALS.get(verb, verb.removesuffix("s"))


def _kind(finding: Finding) -> tuple[Verdict, tuple[str, ...]]:
    """Equal for findings that differ by their source and by numbers alone."""
    return finding.verdict, tuple(figure_pattern().split(finding.text))


def _merge(findings: Sequence[Finding]) -> Finding:
    """One finding about the sources of several of a kind, with the range of each number."""
    pattern = figure_pattern()
    first, *between = pattern.split(findings[0].text)
    numbers = zip(*(pattern.findall(finding.text) for finding in findings), strict=True)
    text = first + "".join(map("".join, zip(map(_range, numbers), between, strict=True)))
    verb, _, rest = text.partition(" ")
    if verb in VERBS:
        text = f" {pluralise(verb)} {_ITS.sub('their', rest)}"
    else:
        text = f": {text}"
    return Finding(findings[0].verdict, f"and {len(findings) - 1} more{text}", findings[0].source)


def _range(numbers: Sequence[str]) -> str:
    least, most = min(numbers, key=read_figure), max(numbers, key=read_figure)
    return least if read_figure(least) == read_figure(most) else f"{least} to {most}"
