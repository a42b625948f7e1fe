"""State of the Factor workspace in the project: the BRDF, the settings, the runs, and the chosen run.

A run is known by a colour and a marker that no other has. What it has found so far is not here but in
`app.factor.runs`, because a search goes on whatever is undone.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from math import radians
from typing import Any

from app.document.comparison import MARKERS, colour_of
from engine.core.params import check, param

#: The methods and what they are called; the first three give sums of products, the last two one product.
METHODS = {
    "auto": "Automatic",
    "symmetric": "Symmetric",
    "svd": "Singular values",
    "power": "Power iteration",
    "normalised": "One positive term",
    "homomorphic": "Fixed (McCool)",
    "search": "Search (Cole)",
}
METHOD_HINTS = {
    "auto": "Symmetric for a reciprocal BRDF, otherwise singular values",
    "symmetric": "Eigenvectors: light and view maps are the same up to their sign (Wang, Tran and Luebke 2004)",
    "svd": "Singular vectors, for any BRDF",
    "power": "The same by block power iteration, as published",
    "normalised": "A product of two positive textures (Kautz and McCool 1999)",
    "homomorphic": "Textures of light, half vector and view, solved together (McCool, Ang and Ahmad 2001)",
    "search": "Textures of the best projections for this BRDF (Cole 2002)",
}
PARAMETRISATIONS = {"in-out": "Light and view", "half-diff": "Half and difference", "auto": "The better one"}
MAPS = {
    "orthographic": "Orthographic",
    "polar": "Polar",
    "parabolic": "Parabolic",
    "auto": "The best one",
}
PRESETS = {"default": "Ours", "thesis": "As in the thesis"}
#: Labels of the error metrics, and their units; errors of logarithms have none.
METRICS = {
    "rms_cosine_weighted": ("RMS, cosine-weighted", "sr⁻¹"),
    "abs_log": ("Mean relative (log)", ""),
    "sq_log": ("Mean squared relative (log)", ""),
    "max_log": ("Largest relative (log)", ""),
    "abs": ("Mean absolute", "sr⁻¹"),
    "sq": ("Mean squared", "sr⁻²"),
    "max": ("Largest absolute", "sr⁻¹"),
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
}

#: The BRDF of the material itself, if no other was chosen.
MATERIAL = "material"


@dataclass(frozen=True)
class FactorChoices:
    """Settings of a factorisation; those that a method does not read keep their values for the other methods."""

    method: str = "search"
    parametrisation: str = "in-out"
    map: str = "orthographic"
    metric: str = "sq_log"
    preset: str = "default"
    reciprocal: bool = True
    side: float = param(48.0, 4.0, 96.0, slider=(8.0, 64.0), doc="Texels along a side of each map.")
    products: float = param(8.0, 1.0, 64.0, slider=(1.0, 24.0), doc="Most products of two maps.")
    size: float = param(16.0, 4.0, 64.0, slider=(4.0, 32.0), doc="Texels along a side of each texture.")
    textures: float = param(5.0, 1.0, 16.0, slider=(1.0, 8.0), doc="Most textures.")
    restarts: float = param(6.0, 0.0, 100.0, slider=(0.0, 12.0), doc="Random starts of the search for each texture.")
    together: float = param(2.0, 1.0, 16.0, slider=(1.0, 5.0), doc="Textures solved for each projection tried.")
    samples: float = param(
        45_000.0,
        100.0,
        1e6,
        slider=(1000.0, 100_000.0),
        log=True,
        doc="Pairs of directions at which formulas are sampled.",
    )
    max_theta_deg: float = param(
        88.0, 1.0, 89.9, slider=(30.0, 89.0), unit="°", doc="Largest angle from the normal of these pairs."
    )
    seed: float = param(
        1.0, 0.0, 1e6, slider=(0.0, 20.0), doc="Seed of the random numbers: equal seeds give equal factors."
    )

    def __post_init__(self) -> None:
        check(self)
        for name in ("side", "products", "size", "textures", "restarts", "together", "samples", "seed"):
            object.__setattr__(self, name, float(round(getattr(self, name))))

    @property
    def separable(self) -> bool:
        """True if the method gives a sum of products of two maps."""
        return self.method not in ("homomorphic", "search")

    @property
    def most_terms(self) -> int:
        return round(self.products if self.separable else self.textures)

    def with_terms(self, terms: int) -> FactorChoices:
        """The same with other terms at most."""
        return replace(self, products=float(terms)) if self.separable else replace(self, textures=float(terms))

    @property
    def why_not(self) -> str:
        """The reason why these choices do not go together; empty where they do."""
        if self.method == "symmetric" and self.parametrisation == "half-diff":
            return "Over half and difference vectors no matrix is symmetric: take singular values, or light and view"
        if not self.separable and self.parametrisation == "auto":
            return "Choose one of the two parametrisations: this method does not try both"
        return ""

    @property
    def words(self) -> dict[str, Any]:
        """The keyword arguments of `engine.factor.factor.FactorSettings`."""
        words = {name: asdict(self)[name] for name in ("method", "parametrisation", "map", "metric", "preset")}
        return words | {
            "reciprocal": self.reciprocal,
            "size": round(self.side if self.separable else self.size),
            "terms": self.most_terms,
            "restarts": round(self.restarts),
            "together": round(self.together),
            "samples": round(self.samples),
            "max_theta": radians(self.max_theta_deg),
            "seed": round(self.seed),
        }


@dataclass(frozen=True, eq=False)
class Run:
    """One factorisation that was asked for. `source` is as in `Factoring`; `choices` is None for factors of a file."""

    number: int
    identity: int
    name: str
    source: str
    choices: FactorChoices | None

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
    choices: FactorChoices = FactorChoices()
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
