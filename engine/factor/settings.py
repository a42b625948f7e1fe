"""Settings of a factorisation, declared once: window, command line, notebooks and solvers read them here.

This module is light, because the command line makes its options of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import radians
from typing import Literal

from engine.core.params import check, choice, flag, param, whole

#: Most products of a sum, and most textures of a product: as many as a shader reads.
MAX_PRODUCTS, MAX_TEXTURES = 64, 16

#: Smallest and largest texture that is solved for.
SMALLEST_SIZE, LARGEST_SIZE = 4, 64

#: Parameters of sums of products that products of projections do not read, and the other way round.
SEPARABLE_PARAMETERS, HOMOMORPHIC_PARAMETERS = ("side", "products"), ("size", "textures")


@dataclass(frozen=True)
class FactorSettings:
    """Settings of a factorisation; a parameter that a method does not read keeps its value for the other methods.

    UsageError for a value out of its range. Values that do not go together are allowed here, so that a user may
    pass through them; `why_not` gives the reason, and `engine.factor.factor` refuses them.
    """

    method: Literal["auto", "symmetric", "svd", "power", "nonnegative", "normalised", "homomorphic", "search"] = choice(
        "auto",
        ("auto", "symmetric", "svd", "power", "nonnegative", "normalised", "homomorphic", "search"),
        offered=(
            ("auto", "Automatic"),
            ("symmetric", "Symmetric"),
            ("svd", "Singular values"),
            ("power", "Power iteration"),
            ("nonnegative", "Non-negative"),
            ("normalised", "One positive term"),
            ("homomorphic", "Fixed (McCool)"),
            ("search", "Search (Cole)"),
        ),
        doc="auto: of a formula, symmetric if its matrix is symmetric, otherwise svd; of a measurement these or a "
        "search, whichever is better in held-out regions of directions; nonnegative: no pair of directions "
        "is negative, and dark values are nearer, for some more squared error",
    )
    parametrisation: Literal["in-out", "half-diff", "auto"] = choice(
        "in-out",
        ("in-out", "half-diff", "auto"),
        offered=(("in-out", "Light and view"), ("half-diff", "Half and difference"), ("auto", "The better one")),
        doc="light and viewer, or half and difference vector (Kautz and McCool's, for direct light); "
        "auto: the better one (separable methods)",
    )
    map: Literal["orthographic", "polar", "parabolic", "auto"] | None = choice(
        None,
        ("orthographic", "polar", "parabolic", "auto"),
        offered=(
            (None, "By directions"),
            ("orthographic", "Orthographic"),
            ("polar", "Polar"),
            ("parabolic", "Parabolic"),
            ("auto", "The best one"),
        ),
        doc="hemisphere map of separable textures (orthographic; half-diff: polar, highlight at the pole); auto: best",
    )
    weighting: Literal["auto", "plain", "cosine"] = choice(
        "auto",
        ("auto", "plain", "cosine"),
        doc="norm of the separable methods; auto: the one with the lower cosine-weighted error",
    )
    side: int = whole(48, 1, 96, slider=(8, 64), option="size", doc="texels along a side of each map")
    products: int = whole(8, 1, MAX_PRODUCTS, slider=(1, 24), option="terms", doc="most products of two maps")
    size: int = whole(16, SMALLEST_SIZE, LARGEST_SIZE, slider=(4, 32), doc="most texels along a side of a texture")
    textures: int = whole(5, 1, MAX_TEXTURES, slider=(1, 8), option="terms", doc="most textures")
    reciprocal: bool = flag(False, doc="enforce reciprocity exactly (homomorphic and search)")
    restarts: int = whole(6, 0, 1000, slider=(0, 12), doc="random starts of the search for each texture")
    together: int = whole(2, 1, MAX_TEXTURES, slider=(1, 5), doc="textures solved for each projection tried")
    samples: int = whole(
        45_000, 1, 2_000_000, slider=(1000, 100_000), log=True, doc="pairs of directions at which models are sampled"
    )
    max_theta_deg: float = param(
        88.0,
        0.1,
        89.99,
        slider=(30.0, 89.0),
        unit="°",
        doc="largest angle of these pairs from the normal, for models only",
    )
    epsilon: float = param(1e-5, 1e-12, 0.999, log=True, doc="added before the logarithm, relative to the mean")
    metric: Literal["abs_log", "sq_log", "max_log", "abs", "sq", "max"] = choice(
        "sq_log",
        ("abs_log", "sq_log", "max_log", "abs", "sq", "max"),
        doc="error by which the search chooses projections: logarithms count dark and bright alike, and the "
        "cosine-weighted RMS, which bright values dominate, can rise with them; sq weighs bright values most",
    )
    preset: Literal["default", "thesis"] = choice(
        "default",
        ("default", "thesis"),
        offered=(("default", "Ours"), ("thesis", "As in the thesis")),
        doc="default: terms, smoothness and size that are best on held-out regions; thesis: Cole's search",
    )
    seed: int = whole(1, 0, 2**31 - 1, slider=(0, 20), doc="seed of samples and starts: equal seeds give equal factors")

    def __post_init__(self) -> None:
        check(self)

    @property
    def separable(self) -> bool:
        """True if the method gives a sum of products of two maps; `auto` gives one of formulas, and tries one of
        measurements."""
        return self.method not in ("homomorphic", "search")

    @property
    def max_theta(self) -> float:
        return radians(self.max_theta_deg)

    @property
    def texels(self) -> int:
        """Along a side of the map or texture, whichever the method makes."""
        return self.side if self.separable else self.size

    @property
    def max_terms(self) -> int:
        return self.products if self.separable else self.textures

    def with_texels(self, texels: int) -> FactorSettings:
        """The same with other texels a side, of what the method makes; of a search by `auto`, no more than it has."""
        if self.method == "auto":
            return replace(self, side=texels, size=min(max(texels, SMALLEST_SIZE), self.size))
        return replace(self, side=texels) if self.separable else replace(self, size=texels)

    def with_terms(self, terms: int) -> FactorSettings:
        """The same with other terms at most."""
        if self.method == "auto":
            return replace(self, products=terms, textures=min(terms, MAX_TEXTURES))
        return replace(self, products=terms) if self.separable else replace(self, textures=terms)

    @property
    def why_not(self) -> str:
        """The reason why these settings do not go together; empty where they do."""
        if self.method == "symmetric" and self.parametrisation == "half-diff":
            return "Over half and difference vectors no matrix is symmetric: take singular values, or light and view"
        if not self.separable and self.parametrisation == "auto":
            return "Choose one of the two parametrisations: this method does not try both"
        return ""


#: The settings that window, command line and notebooks begin with.
DEFAULT = FactorSettings()
