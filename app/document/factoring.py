"""State of the Factor workspace in the project: the BRDF, the settings, the runs, and the chosen run.

A run is known by a colour and a marker that no other has. What it has found so far is not here but in
`app.factor.runs`, because a search goes on whatever is undone, and beside the project (`app.project.factors`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from app.document.comparison import MARKERS, colour_of
from engine.core.params import parameters
from engine.factor.settings import DEFAULT, FactorSettings

_DECLARED = {parameter.name: dict(parameter.offered) for parameter in parameters(FactorSettings)}

#: The methods and what they are called; the last two give one product, the others sums of products.
METHODS = _DECLARED["method"]
METHOD_HINTS = {
    "auto": "Models: symmetric or singular values. Measurements: these or a search, by the error in held-out regions",
    "symmetric": "Eigenvectors: light and view maps are the same up to their sign (Wang, Tran and Luebke 2004)",
    "svd": "Singular vectors, for any BRDF",
    "power": "The same by block power iteration, as published",
    "nonnegative": "Sums without a negative term, which are never black and nearer to dark values (Lee and Seung 1999)",
    "normalised": "A product of two positive textures (Kautz and McCool 1999)",
    "homomorphic": "Textures of light, half vector and view, solved together (McCool, Ang and Ahmad 2001)",
    "search": "Textures of the best projections for this BRDF (Cole 2002)",
}
PARAMETRISATIONS, MAPS, PRESETS = (_DECLARED[name] for name in ("parametrisation", "map", "preset"))

#: Labels of the error metrics, and their units; errors of logarithms have none.
METRICS = {
    "rms_cosine_weighted": ("RMS, cosine-weighted", "sr⁻¹"),
    "abs_log": ("Mean relative (log)", ""),
    "sq_log": ("Mean squared relative (log)", ""),
    "max_log": ("Largest relative (log)", ""),
    "abs": ("Mean absolute", "sr⁻¹"),
    "sq": ("Mean squared", "sr⁻²"),
    "max": ("Largest absolute", "sr⁻¹"),
    "held_out_rms_cosine_weighted": ("Held out: RMS, cosine-weighted", "sr⁻¹"),
    "held_out_sq_log": ("Held out: mean squared relative (log)", ""),
}
#: Their short labels, for narrow places.
SHORT_METRICS = {
    "rms_cosine_weighted": "RMS × cos",
    "abs_log": "Mean log",
    "sq_log": "Mean log²",
    "max_log": "Max. log",
    "abs": "Mean",
    "sq": "Mean²",
    "max": "Maximum",
    "held_out_rms_cosine_weighted": "Held out: RMS × cos",
    "held_out_sq_log": "Held out: log²",
}
#: Those that a search can make small.
SEARCHED = next(parameter.values for parameter in parameters(FactorSettings) if parameter.name == "metric")

#: Numbers of runs lie below.
RUN_NUMBERS = 1 << 30

#: The BRDF of the material itself, if no other was chosen.
MATERIAL = "material"


@dataclass(frozen=True, eq=False)
class Run:
    """One factorisation that was asked for.

    Attributes
    ----------
    source : as in `Factoring`. given : the BRDF that it named then, or the path of its file.
    choices : None for factors that were opened, from `folder`.
    """

    number: int
    identity: int
    name: str
    source: str
    choices: FactorSettings | None
    given: Any = None
    folder: Path | None = None

    @property
    def colour(self) -> str:
        """As '#rrggbb'."""
        return colour_of(self.identity)

    @property
    def marker(self) -> str:
        """pyqtgraph's name of it."""
        return MARKERS[self.identity]


@dataclass(frozen=True, eq=False)
class Factoring:
    """The choices, the runs, and the run and terms that are previewed and exported.

    Attributes
    ----------
    source : `MATERIAL`, 'entry:' and the identity of a compared BRDF, 'model:' and a text, or 'file:'
        and a path.
    current : the number of the run that is chosen. terms : of it; None for all that it has.
    """

    source: str = MATERIAL
    choices: FactorSettings = DEFAULT
    runs: tuple[Run, ...] = ()
    current: int | None = None
    terms: int | None = None

    def find(self, number: int | None) -> Run | None:
        """The run with this number."""
        return next((run for run in self.runs if run.number == number), None)

    @property
    def run(self) -> Run | None:
        """The chosen run."""
        return self.find(self.current)

    @property
    def free_identity(self) -> int | None:
        """The first colour and marker that no run has; None where all are taken."""
        taken = {run.identity for run in self.runs}
        return next((number for number in range(len(MARKERS)) if number not in taken), None)

    def with_run(self, run: Run) -> Factoring:
        """With one more run, which is then the chosen one."""
        return replace(self, runs=(*self.runs, run), current=run.number, terms=None)

    def changed(self, run: Run) -> Factoring:
        """With another value of the run of the same number."""
        return replace(self, runs=tuple(run if each.number == run.number else each for each in self.runs))

    def without(self, number: int) -> Factoring:
        """Without a run; the one after it, or else before it, is then the chosen one."""
        place = next(at for at, run in enumerate(self.runs) if run.number == number)
        others = (*self.runs[place + 1 :], *reversed(self.runs[:place]))
        if self.current != number:
            return replace(self, runs=tuple(run for run in self.runs if run.number != number))
        kept = tuple(run for run in self.runs if run.number != number)
        return replace(self, runs=kept, current=others[0].number if others else None, terms=None)


def names_of(source: str) -> tuple[str, str]:
    """The kind of a source and what it names."""
    kind, _, rest = source.partition(":")
    return kind, rest
