"""Settings of a bake, and of the light on it, for each transport method."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from engine.core.params import check, choice, flag, text, texts, whole

if TYPE_CHECKING:
    pass

#: Signs of the terms of a factorisation.
Signs = Literal["auto", "signed", "nonnegative"]

#: Vertices that an error is measured at where a bake reports it.
ERROR_VERTICES = 400

#: Bounces between parts of the model, where interreflection is asked for.
BOUNCES = 3


#: Choices of a form if a plan may decide.
AS_PLANNED = ((None, "As planned"), (False, "Without"), (True, "With"))


_FINE = "N × N rays for each texel of the cube map at the edges of shadows"


_CUBE = "edge of the cube map that visibility is counted over (32, above order 8 64)"


@dataclass(frozen=True)
class ShSettings:
    """Settings of a bake in spherical harmonics."""

    order: int = whole(
        5,
        3,
        15,
        sweep=(3, 5, 8, 15),
        offered=tuple((order, str(order)) for order in (3, 5, 7, 9, 12, 15)),
        doc="bands of the spherical harmonics: more of them keep sharper light and highlights",
    )
    interreflection: bool | None = flag(
        None, sweep=(0, 1), offered=AS_PLANNED, doc="include interreflection between parts of the model"
    )
    cube: int | None = whole(None, 4, 256, doc=_CUBE)
    fine: int = whole(4, 1, 15, doc=_FINE)

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class ShLight:
    """Settings of the light on spherical harmonics, without another bake."""

    window: Literal["none", "hanning", "lanczos"] = choice(
        "none",
        ("none", "hanning", "lanczos"),
        offered=(("none", "None"), ("hanning", "Hanning"), ("lanczos", "Lanczos")),
        doc="damp high bands against ringing, at the price of blurred light",
    )
    near_points: int | None = whole(
        None,
        1,
        33,
        doc="points along the longest side of the grid at which light of near lamps is found; between them it is "
        "interpolated (as many as keep the error below 1 %%)",
    )
    vary: tuple[str, ...] = texts(
        metavar="PARAMETER=FROM:TO:SOURCE",
        doc="vary a parameter of the BRDF over the model, as in lightarc bake; twice at most",
    )

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class WaveletSettings:
    """Settings of a bake in wavelets."""

    terms: int = whole(
        4,
        1,
        64,
        sweep=(1, 2, 4, 8),
        doc="terms, products of a light and a view map, of the BRDF: glossy ones need more",
    )
    coefficients: int = whole(
        96,
        1,
        4096,
        sweep=(24, 48, 96, 192, 384),
        offered=tuple((kept, str(kept)) for kept in (32, 64, 96, 200, 400)),
        doc="wavelet coefficients kept for each vertex and term: more keep more shadow",
    )
    interreflection: bool | None = flag(
        None, sweep=(0, 1), offered=AS_PLANNED, doc="include interreflection between parts of the model"
    )
    cube: int = whole(
        64,
        2,
        64,
        values=(2, 4, 8, 16, 32, 64),
        sweep=(16, 32, 64),
        doc="edge of the cube map of the light: more texels keep sharper shadows",
    )
    fine: int = whole(4, 1, 15, doc=_FINE)
    occluder_cells: int = whole(
        0,
        0,
        1 << 20,
        offered=((0, "The model"), (128, "128 cells"), (64, "64 cells"), (32, "32 cells")),
        words="shaded by",
        doc="let shadows fall from a model simplified in a grid of N cells a side, with quicker rays (0: the model)",
    )
    map: Literal["orthographic", "polar", "parabolic"] = choice(
        "orthographic",
        ("orthographic", "polar", "parabolic"),
        doc="of the BRDF's textures; polar suits single terms of anisotropic ones",
    )
    weighting: Literal["auto", "plain", "cosine"] = choice(
        "auto",
        ("auto", "plain", "cosine"),
        doc="norm in which terms are found; auto: the one with the lower cosine-weighted error",
    )
    signs: Literal["auto", "signed", "nonnegative"] = choice(
        "auto",
        ("auto", "signed", "nonnegative"),
        doc="signed terms have the least squared error and may sum to less than black; nonnegative ones never do, and "
        "are nearer to dark values; auto: nonnegative ones where their errors are smaller",
    )
    blend: tuple[str, ...] = texts(
        metavar="BRDF:SOURCE",
        doc="mix in another BRDF with its own terms; its weight over the model is x, y or z across its bounding box or "
        "the luminance of an image at its texture coordinates: ggx:alpha=0.1:y; --brdf has what is left; can be given "
        "several times",
    )
    albedo: str | None = text(
        metavar="IMAGE", doc="multiply the outgoing radiance by an image at the texture coordinates"
    )

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class WaveletLight:
    """Settings of the light on wavelets, without another bake."""

    weight: tuple[str, ...] = texts(
        metavar="SOURCE",
        doc="of the second BRDF of a bake with --blend (again for the third), in place of what was baked: x, y, z or a "
        "image",
    )
    albedo: str | None = text(
        metavar="IMAGE",
        doc="multiply the outgoing radiance by an image at the texture coordinates, in place of what was baked",
    )


@dataclass(frozen=True)
class GaussianSettings:
    """Settings of a bake in Gaussians."""

    lobes: int = whole(
        1, 1, 3, sweep=(1, 2, 3), doc="Gaussians for each vertex and view: more follow partly shaded highlights"
    )
    interreflection: bool | None = flag(
        None,
        sweep=(0, 1),
        offered=AS_PLANNED,
        option="indirect",
        doc="include indirect glossy transfer",
    )
    views: int = whole(92, 92, 92, doc="directions of view, an icosahedron cut in three")
    samples: int = whole(128, 16, 1 << 14, doc="directions that each highlight is tabulated at")
    order: int = whole(8, 3, 15, doc="bands of the spherical harmonics of the diffuse part")
    cube: int | None = whole(None, 4, 256, doc="edge of the cube map that visibility is counted over (64)")
    fine: int = whole(4, 1, 15, doc=_FINE)
    weights: Literal["auto", "plain", "preserving"] = choice(
        "auto",
        ("auto", "plain", "preserving"),
        doc="heights of the Gaussians: nearest to the highlight, or with all its energy; auto: the lower error of the "
        "radiance under --error-env, or in the studio",
    )
    compress: bool = flag(False, doc="store Gaussians in 8 bytes or fewer instead of 28")

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True)
class NoLightSettings:
    """Nothing can be set of the light."""
