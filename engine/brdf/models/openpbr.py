"""OpenPBR Surface 1.1: what its layers reflect. GLSL counterpart: resources/shaders/brdf/openpbr_layers.glsl.

From the outside in (OpenPBR, ASWF 2024), each layer over what its albedo E at the viewer's cosine leaves:

    f       = fuzz + (1 − fuzz_weight E_fuzz) coated
    coated  = coat + (1 − coat_weight E_coat) tint darkening base
    base    = metalness metal + (1 − metalness) (dielectric + (1 − E_dielectric) diffuse)

Fuzz is Zeltner's lobe (Zeltner2022), coat and dielectric are GGX with Smith's height-correlated term and Fresnel's
equations, the metal has Hoffman's Fresnel term with a tint at 82 degrees (Hoffman2023), the diffuse part is Fujii's
form of Oren–Nayar, and what facets of each scatter more than once is added (Kulla2017). A thin film on metal and
dielectric follows Belcour and Barla (Belcour2017). Scaling by the viewer's cosine is the standard's own, and makes the
model not reciprocal.

Light that a surface transmits or scatters below itself is not part of a BRDF (`engine.exchange.readers` says what
stands in its place). Bound by arithmetic, some 0.5 µs a pair of directions.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.models.evaluate import sum_of_directions
from engine.brdf.models.model import Model
from engine.brdf.models.multiple_scattering import (
    CORRELATED,
    SMOOTHEST,
    further_reflectance,
    multiple_scattering,
    schlick_mean,
)
from engine.brdf.models.sampling import Lobes, grey
from engine.brdf.models.sampling_lobes import VisibleGgxLobe
from engine.core.params import Colour, param

Floats = NDArray[np.float64]

#: Coefficients of tⁱ rʲ, t = 1 − μ: t Σ c tⁱ rʲ is the mean of (1 − h·v)⁵ over what GGX with F = 1 reflects.
GRAZING = np.array(
    [
        [0.294, -0.339, -3.209, 11.694, -9.112],
        [-4.467, 14.840, -27.295, -17.211, 41.822],
        [20.696, -61.168, 186.615, -146.569, -29.148],
        [-40.193, 47.916, -175.510, 200.000, 20.017],
        [35.310, 59.230, -185.269, 163.122, -115.445],
        [-10.579, -61.973, 200.000, -200.000, 85.940],
    ]
)

#: How far facets of width α face a viewer near the horizon, by the furnace of films on white.
TOWARDS = 0.28

#: Fujii's constants of the diffuse lobe.
FUJII = 0.5 - 2.0 / (3.0 * np.pi)
FUJII_MEAN = 2.0 / 3.0 - 28.0 / (15.0 * np.pi)

#: Bounces between the faces of a thin film that are summed.
BOUNCES = 2

#: The sensitivity of the eye over wave numbers as four Gaussians (Belcour2017): height, place and variance of X, Y, Z.
SENSITIVITY = np.array(
    [
        [5.4856e-13, 1.6810e06, 4.3278e09],
        [4.4201e-13, 1.7953e06, 9.3046e09],
        [5.2481e-13, 2.2084e06, 6.6121e09],
    ]
)
SECOND_X = (9.7470e-14, 2.2399e06, 4.5282e09)
SENSITIVITY_SUM = 1.0685e-7

#: Linear RGB of CIE 1931 from XYZ, white of equal energy.
RGB_FROM_XYZ = np.array(
    [
        [2.3706743, -0.9000405, -0.4706338],
        [-0.5138850, 1.4253036, 0.0885814],
        [0.0052982, -0.0146949, 1.0093968],
    ]
)


@dataclass(frozen=True)
class OpenPbr(Model):
    """Reflectance of an OpenPBR surface, isotropic; names and defaults are those of the standard.

    Roughness below 0.02 is taken for 0.02.
    """

    name: ClassVar[str] = "openpbr"
    label: ClassVar[str] = "OpenPBR"
    reciprocal: ClassVar[bool] = False
    #: A viewer sees 98 to 102 % of even light on white layers. Scaling by the viewer's cosine alone lets light that
    #: comes from near the horizon leave up to 1.7 times as bright, summed over all viewers.
    energy_conserving: ClassVar[bool] = False

    base_weight: float = param(1.0, 0.0, 1.0, doc="Factor on the diffuse and the metallic base.", fitted=False)
    base_color: Colour = param((0.8, 0.8, 0.8), 0.0, 1.0, doc="Colour of the diffuse part, or of the metal.")
    base_diffuse_roughness: float = param(0.0, 0.0, 1.0, doc="Roughness of the diffuse part.", fitted=False)
    base_metalness: float = param(0.0, 0.0, 1.0, doc="0 for dielectrics, 1 for metals.")
    specular_weight: float = param(1.0, 0.0, 1.0, doc="Factor on the reflectance of the facets.", fitted=False)
    specular_color: Colour = param(
        (1.0, 1.0, 1.0), 0.0, 1.0, doc="Tint of dielectric highlights, and of metals at 82 degrees.", fitted=False
    )
    specular_roughness: float = param(0.3, 0.0, 1.0, doc="Root of the width of the highlight.", slider=(0.05, 1.0))
    specular_ior: float = param(1.5, 1.0, 5.0, doc="Index of refraction of the dielectric base.", slider=(1.0, 3.0))
    coat_weight: float = param(0.0, 0.0, 1.0, doc="Coverage of the clear coat.", fitted=False)
    coat_color: Colour = param((1.0, 1.0, 1.0), 0.0, 1.0, doc="Colour that the coat lets through.", fitted=False)
    coat_roughness: float = param(0.0, 0.0, 1.0, doc="Root of the width of the coat's highlight.", fitted=False)
    coat_ior: float = param(1.6, 1.0, 5.0, doc="Index of refraction of the coat.", slider=(1.0, 3.0), fitted=False)
    coat_darkening: float = param(
        1.0, 0.0, 1.0, doc="Share of the darkening by light that the coat sends back.", fitted=False
    )
    fuzz_weight: float = param(0.0, 0.0, 1.0, doc="Coverage of the fuzz: fibres, or dust.", fitted=False)
    fuzz_color: Colour = param((1.0, 1.0, 1.0), 0.0, 1.0, doc="Colour of the fuzz.", fitted=False)
    fuzz_roughness: float = param(0.5, 0.0, 1.0, doc="Roughness of the fuzz.", fitted=False)
    thin_film_weight: float = param(0.0, 0.0, 1.0, doc="Coverage of a thin film on the base.", fitted=False)
    thin_film_thickness: float = param(
        0.5, 0.0, 10.0, doc="Thickness of the film.", unit="µm", slider=(0.0, 1.0), fitted=False
    )
    thin_film_ior: float = param(1.4, 1.0, 5.0, doc="Index of refraction of the film.", slider=(1.0, 3.0), fitted=False)

    @property
    def shader_definitions(self) -> dict[str, str]:
        """Definitions that leave layers out: renderers without a graphics card take the time of all branches."""
        left_out = {
            "NO_COAT": self.coat_weight == 0.0,
            "NO_FUZZ": self.fuzz_weight == 0.0,
            "NO_FILM": self.thin_film_weight == 0.0,
            "NO_METAL": self.base_metalness == 0.0,
            "NO_DIELECTRIC": self.base_metalness == 1.0,
        }
        return {name: "1" for name, is_left_out in left_out.items() if is_left_out}

    def sampling_lobes(self) -> Lobes:
        """The two highlights, and for all else the cosine."""
        base, metal = grey(self.base_color) * self.base_weight, self.base_metalness
        width = base_width(self.specular_roughness, self)
        mirror = metal * base * self.specular_weight + (1.0 - metal) * float(f0_of(self.specular_ior))
        lobes: Any = [(VisibleGgxLobe(width, width), 0.05 + 0.95 * mirror)]
        if self.coat_weight:
            coat = max(self.coat_roughness, SMOOTHEST) ** 2
            lobes.append((VisibleGgxLobe(coat, coat), 0.1 * self.coat_weight))
        return lobes, (1.0 - metal) * base + 0.3 * self.fuzz_weight + 0.02

    @property
    def anisotropies(self) -> tuple[float, float, float]:
        """Those of the base and of the coat, in [0, 1], and the angle from the tangent to them, degrees."""
        return 0.0, 0.0, 0.0

    def formula(self, wi: Floats, wo: Floats) -> Floats:
        widths = two_widths(base_width(self.specular_roughness, self), self.anisotropies[0])
        base = Base(np.reshape(self.base_color, (3, 1)), self.base_metalness, widths, self.specular_ior)
        return reflect(self, wi, wo, base, coat_widths(self))


@dataclass(frozen=True)
class OpenPbrAnisotropic(OpenPbr):
    """OpenPBR with highlights of two widths: αx = α √(2/(1 + (1 − a)²)), αy = (1 − a) αx, x along the tangent.

    In texts it goes by the name `openpbr`, with one of the two anisotropies.
    """

    name: ClassVar[str] = "openpbr-anisotropic"
    label: ClassVar[str] = "OpenPBR, anisotropic"
    form_of: ClassVar[str] = "openpbr"
    isotropic: ClassVar[bool] = False

    specular_roughness_anisotropy: float = param(0.5, 0.0, 1.0, doc="How far the highlight is drawn out.", fitted=False)
    coat_roughness_anisotropy: float = param(0.0, 0.0, 1.0, doc="The same for that of the coat.", fitted=False)
    rotation_deg: float = param(
        0.0, -360.0, 360.0, doc="From the tangent to x, anticlockwise.", unit="°", slider=(-180.0, 180.0), fitted=False
    )

    @property
    def anisotropies(self) -> tuple[float, float, float]:
        """As those of `OpenPbr`."""
        return self.specular_roughness_anisotropy, self.coat_roughness_anisotropy, self.rotation_deg


@dataclass(frozen=True)
class Base:
    """The base under the layers, which may differ from texel to texel.

    Colour (3, n) or (3, 1); metalness, widths along tangent and bitangent, and index of refraction, (n,) or a number.
    """

    colour: Floats
    metalness: ArrayLike
    widths: tuple[ArrayLike, ArrayLike]
    ior: ArrayLike


def base_width(roughness: ArrayLike, layers: OpenPbr) -> Any:
    """α of the base, which a rough coat widens."""
    own = np.maximum(roughness, SMOOTHEST)
    widened = np.minimum(1.0, own**4 + 2.0 * layers.coat_roughness**4) ** 0.25
    return (own + layers.coat_weight * (widened - own)) ** 2


def coat_widths(layers: OpenPbr) -> tuple[Any, Any]:
    """αx and αy of the coat."""
    return two_widths(max(layers.coat_roughness, SMOOTHEST) ** 2, layers.anisotropies[1])


def two_widths(width: ArrayLike, anisotropy: float) -> tuple[Any, Any]:
    """αx and αy of an anisotropy in [0, 1]; none is below `SMOOTHEST`²."""
    across = 1.0 - anisotropy
    along = np.multiply(width, np.sqrt(2.0 / (1.0 + across * across)))
    return np.minimum(along, 1.0), np.maximum(across * along, SMOOTHEST**2)


def reflect(layers: OpenPbr, wi: Floats, wo: Floats, base: Base, coat: tuple[ArrayLike, ArrayLike]) -> Floats:
    """f (3, n) in 1/sr for components (3, n) of directions above the horizon, wo that of the viewer.

    `coat` has its widths along tangent and bitangent.
    """
    both, length, _ = sum_of_directions(wi, wo)
    facing = np.minimum(0.5 * length, 1.0)  # h·wi
    if layers.anisotropies[2]:
        turn = _turn(layers.anisotropies[2])
        wi, wo, both = turn @ wi, turn @ wo, turn @ both
    half = both / length
    value = _base(layers, base, wi, wo, half, facing)
    if layers.coat_weight > 0.0:
        lobe, mean = ggx(wi, wo, half, coat)
        through = 1.0 - layers.coat_weight * share_of_dielectric(wo[2], mean, layers.coat_ior)
        tint = 1.0 + layers.coat_weight * (np.reshape(layers.coat_color, (3, 1)) - 1.0)
        value = through * tint * darkening(layers, base) * value
        again = multiple_scattering(wi[2], wo[2], mean, fresnel_mean(layers.coat_ior), CORRELATED)
        value = value + layers.coat_weight * (fresnel(facing, layers.coat_ior) * lobe + again)
    if layers.fuzz_weight > 0.0:
        lobe, reflected = fuzz(wi, wo, layers.fuzz_roughness)
        value = (1.0 - layers.fuzz_weight * reflected) * value
        value = value + layers.fuzz_weight * np.reshape(layers.fuzz_color, (3, 1)) * lobe
    return value


def _turn(angle_deg: float) -> Floats:
    """The matrix (3, 3) from the frame of the surface to one that is turned about the normal."""
    cosine, sine = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])


def _base(layers: OpenPbr, base: Base, wi: Floats, wo: Floats, half: Floats, facing: Floats) -> Floats:
    """Metal and dielectric over their diffuse part."""
    lobe, mean = ggx(wi, wo, half, base.widths)
    metalness, tint = np.asarray(base.metalness), np.reshape(layers.specular_color, (3, 1))
    ior = under_coat(layers, base.ior)
    film = (layers.thin_film_thickness, layers.thin_film_ior)
    value = np.zeros((3, wi.shape[1]))
    if np.any(metalness > 0.0):
        colour = layers.base_weight * base.colour
        mirror, average = hoffman(facing, colour, tint), hoffman_mean(colour, tint)
        if layers.thin_film_weight > 0.0:
            inner = cosine_within(facing, layers.thin_film_ior)
            phase = np.where(index_of(colour) < layers.thin_film_ior, np.pi, 0.0)
            below = hoffman(inner, colour, tint)
            coloured = airy(facing, film, below, below, phase, phase)
            mirror = mirror + layers.thin_film_weight * (coloured - mirror)
        again = multiple_scattering(wi[2], wo[2], mean, average, CORRELATED)
        value = value + metalness * layers.specular_weight * (mirror * lobe + again)
    if np.any(metalness < 1.0):
        mirror, average = np.broadcast_to(fresnel(facing, ior), value.shape), fresnel_mean(ior)
        reflected = np.broadcast_to(share_of_dielectric(wo[2], mean, ior), value.shape)
        if layers.thin_film_weight > 0.0:
            mirror = mirror + layers.thin_film_weight * (film_on_dielectric(facing, film, ior) - mirror)
            first = film_on_dielectric(typical_cosine(wo[2], mean), film, ior)
            own = schlick_mean(film_on_dielectric(np.ones(len(facing)), film, ior))
            coloured = share_of_lobe(wo[2], mean, first, own)
            reflected = reflected + layers.thin_film_weight * (coloured - reflected)
            average = average + layers.thin_film_weight * (own - average)
        under = (1.0 - reflected) * diffuse(wi, wo, base.colour, layers.base_diffuse_roughness)
        again = multiple_scattering(wi[2], wo[2], mean, average, CORRELATED)
        value = value + (1.0 - metalness) * (tint * (mirror * lobe + again) + layers.base_weight * under)
    return value


def ggx(wi: Floats, wo: Floats, half: Floats, widths: tuple[ArrayLike, ArrayLike]) -> tuple[Floats, Floats]:
    """D G₂/(4 n·l n·v) (n,) and the geometric mean of the widths, by which albedos are looked up."""
    along, across = (np.asarray(width, np.float64) for width in widths)
    stretched = (half[0] / along) ** 2 + (half[1] / across) ** 2 + half[2] ** 2
    slope_i = np.sqrt(wi[2] ** 2 + (along * wi[0]) ** 2 + (across * wi[1]) ** 2)
    slope_o = np.sqrt(wo[2] ** 2 + (along * wo[0]) ** 2 + (across * wo[1]) ** 2)
    lobe = 0.5 / (np.pi * along * across * stretched**2 * (wi[2] * slope_o + wo[2] * slope_i))
    return lobe, np.sqrt(along * across)


def grazing_share(cosine: Floats, width: ArrayLike) -> Floats:
    """The mean of (1 − h·v)⁵ over what GGX with F = 1 reflects, for cosines (n,) of the viewer and width α."""
    root, aside = np.sqrt(np.asarray(width, np.float64)), 1.0 - cosine
    share: Floats = np.zeros(())
    for row in GRAZING[::-1]:
        share = share * aside + np.polyval(row[::-1], root)
    return np.asarray(np.clip(aside * share, 0.0, 1.0))


def share_of_lobe(cosine: Floats, width: ArrayLike, first: Floats, average: ArrayLike) -> Floats:
    """Albedo of a highlight of which one reflection takes the share `first`, F_m being `average` (Kulla2017)."""
    lost = CORRELATED.loss(cosine, width)
    return np.asarray(first * (1.0 - lost) + further_reflectance(average, CORRELATED.mean_loss(width)) * lost)


def typical_cosine(cosine: Floats, width: ArrayLike) -> Floats:
    """A smooth h·v (n,) that stands for those of the facets that a viewer sees: rough ones face it more than μ says."""
    return np.asarray(np.sqrt(cosine * cosine + TOWARDS * np.asarray(width) * (1.0 - cosine * cosine)))


def share_of_dielectric(cosine: Floats, width: ArrayLike, ior: ArrayLike) -> Floats:
    """Albedo (n,) of the highlight of a dielectric: Fresnel's term where Schlick's would have its mean over facets."""
    return share_of_lobe(cosine, width, fresnel(1.0 - grazing_share(cosine, width) ** 0.2, ior), fresnel_mean(ior))


def f0_of(ior: ArrayLike) -> Any:
    """Reflectance at normal incidence of an index of refraction."""
    ior = np.asarray(ior, np.float64)
    return ((ior - 1.0) / (ior + 1.0)) ** 2


def index_of(f0: Floats) -> Floats:
    """The index of refraction of a reflectance at normal incidence, f0 from 0.01 to 0.99."""
    root = np.sqrt(np.clip(f0, 0.01, 0.99))
    return (1.0 + root) / (1.0 - root)


def under_coat(layers: OpenPbr, ior: ArrayLike) -> Floats:
    """The index of the base over that of what lies above it, with the weight of the highlight in it."""
    ior = np.asarray(ior, np.float64)
    ratio = ior / layers.coat_ior
    relative = ior + layers.coat_weight * (np.maximum(ratio, 1.0 / ratio) - ior)
    root = np.sqrt(np.minimum(layers.specular_weight * f0_of(relative), 0.99999)) * np.sign(relative - 1.0)
    return np.asarray((1.0 + root) / (1.0 - root))


def fresnel(cosine: Floats, ior: ArrayLike) -> Floats:
    """Fresnel's equations for unpolarised light that enters a dielectric of relative index >= 1."""
    across, along = fresnel_pair(cosine, ior)
    return 0.5 * (across + along)


def fresnel_mean(ior: ArrayLike) -> Floats:
    """The mean of Fresnel's term over all directions, for an index from 1 to 5 (Kulla2017)."""
    ior = np.asarray(ior, np.float64)
    return np.asarray((ior - 1.0) / (4.08567 + 1.00071 * ior))


def fresnel_pair(cosine: Floats, ior: ArrayLike) -> tuple[Floats, Floats]:
    """Reflectance of both polarisations, across the plane of incidence and in it."""
    ior = np.asarray(ior, np.float64)
    inner = np.sqrt(np.maximum(ior * ior + cosine * cosine - 1.0, 0.0))
    across = (cosine - inner) / np.maximum(cosine + inner, 1e-300)
    along = (ior * ior * cosine - inner) / np.maximum(ior * ior * cosine + inner, 1e-300)
    return across * across, along * along


def cosine_within(cosine: Floats, ior: float) -> Floats:
    """The cosine within a film of an index >= 1."""
    return np.sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior))


def hoffman(cosine: Floats, f0: Floats, tint: Floats) -> Floats:
    """Schlick's term, times `tint` at 82 degrees (Hoffman2023): F − a μ (1 − μ)⁶, (3, n), not below 0."""
    aside, edge = 1.0 - cosine, 6.0 / 7.0
    there = f0 + (1.0 - f0) * edge**5
    lowered = there * (1.0 - tint) * (7.0 / edge**6) * cosine * aside**6
    return np.maximum(f0 + (1.0 - f0) * aside**5 - lowered, 0.0)


def hoffman_mean(f0: Floats, tint: Floats) -> Floats:
    """The mean of Hoffman's term over all directions: 2 ∫ μ² (1 − μ)⁶ dμ is 1/126."""
    edge = 6.0 / 7.0
    there = f0 + (1.0 - f0) * edge**5
    return np.maximum(schlick_mean(f0) - there * (1.0 - tint) * (7.0 / edge**6 / 126.0), 0.0)


def film_on_dielectric(cosine: Floats, film: tuple[float, float], ior: ArrayLike) -> Floats:
    """Reflectance (3, n) of a dielectric under a thin film of `film` µm and index."""
    inner = cosine_within(cosine, film[1])
    ratio = np.asarray(ior, np.float64) / film[1]
    across, along = fresnel_pair_within(inner, ratio)
    # the wave turns by π where the index rises, in the plane of incidence beyond Brewster's angle
    slow = np.sqrt(np.maximum(ratio * ratio + inner * inner - 1.0, 0.0))
    turned_across = np.where(ratio < 1.0, np.pi, 0.0)
    turned_along = np.where(ratio * ratio * inner < slow, np.pi, 0.0)
    return airy(cosine, film, across, along, turned_across, turned_along)


def fresnel_pair_within(cosine: Floats, ratio: Floats) -> tuple[Floats, Floats]:
    """As `fresnel_pair`, for a ratio of indices that may be below 1; total reflection is 1."""
    square = ratio * ratio + cosine * cosine - 1.0
    across, along = fresnel_pair(cosine, ratio)
    return np.where(square > 0.0, across, 1.0), np.where(square > 0.0, along, 1.0)


def airy(
    cosine: Floats,
    film: tuple[float, float],
    across: Floats,
    along: Floats,
    turned_across: Floats,
    turned_along: Floats,
) -> Floats:
    """Reflectance (3, n) of a film (Belcour2017): light between its faces, summed over wavelengths as the eye does.

    `across` and `along` are the reflectances of the lower face, `turned_…` the phases that it adds.
    """
    thickness, index = film
    upper_across, upper_along = fresnel_pair(cosine, index)
    path = 2e-6 * thickness * index * cosine_within(cosine, index)
    brewster = 1.0 / np.sqrt(1.0 + index * index)
    phases = (np.pi, np.where(cosine < brewster, 0.0, np.pi))
    total: Any = 0.0
    for upper, lower, phase, turned in (
        (upper_across, across, phases[0], turned_across),
        (upper_along, along, phases[1], turned_along),
    ):
        let = 1.0 - upper
        constant = let * let * lower / np.maximum(1.0 - upper * lower, 1e-9)
        product, swing = np.sqrt(upper * lower), constant - let
        xyz = upper + constant + np.zeros((3, 1))
        for bounce in range(1, BOUNCES + 1):
            swing = swing * product
            xyz = xyz + 2.0 * swing * sensitivity(bounce * path, bounce * (turned + phase))
        total = total + 0.5 * xyz
    return np.clip(np.einsum("cx,xn->cn", RGB_FROM_XYZ, np.broadcast_to(total, (3, len(cosine)))), 0.0, 1.0)


def sensitivity(path: Floats, shift: Floats) -> Floats:
    """X, Y and Z (3, n) of cos(2π path/λ + shift) over wavelengths λ; path in metres, shift (n,) or (3, n)."""
    phase, shift = 2.0 * np.pi * path, np.broadcast_to(shift, (3, len(path)))
    height, place, spread = (column[:, None] for column in SENSITIVITY.T)
    value = height * np.sqrt(2.0 * np.pi * spread) * np.cos(place * phase + shift) * np.exp(-spread * phase**2)
    second, at, variance = SECOND_X
    value[0] += second * np.sqrt(2.0 * np.pi * variance) * np.cos(at * phase + shift[0]) * np.exp(-variance * phase**2)
    return value / SENSITIVITY_SUM


def diffuse(wi: Floats, wo: Floats, colour: Floats, roughness: float) -> Floats:
    """Fujii's Oren–Nayar with light that is scattered more than once, (3, n) in 1/sr."""
    level = 1.0 / (1.0 + FUJII * roughness)
    turn = (wi * wo).sum(axis=0) - wi[2] * wo[2]
    leaning = np.where(turn > 0.0, turn / np.maximum(wi[2], wo[2]), turn)
    once = colour * (level * (1.0 + roughness * leaning))
    # 1 − E is level roughness times this loss, and 1 − Ē with its mean in its place
    lost = _diffuse_loss(wi[2]) * _diffuse_loss(wo[2]) * (level * roughness / (FUJII - FUJII_MEAN))
    mean = level * (1.0 + FUJII_MEAN * roughness)
    again = colour * colour * mean / (1.0 - colour * (1.0 - mean))
    return (once + again * lost) / np.pi


def _diffuse_loss(cosine: Floats) -> Floats:
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    steep = sine * cosine * (1.0 + sine + sine * sine) / (1.0 + sine)
    gain = sine * (np.arccos(np.minimum(cosine, 1.0)) - sine * cosine) + 2.0 / 3.0 * (steep - sine)
    return FUJII - gain / np.pi


def fuzz(wi: Floats, wo: Floats, roughness: float) -> tuple[Floats, Floats]:
    """The lobe (n,) in 1/sr of white fuzz, and its albedo (n,) at the viewer's cosine (Zeltner2022).

    A cosine transformed by a matrix (aInv 0 bInv; 0 aInv 0; 0 0 1), in fits of MaterialX 1.39 to Zeltner's table.
    """
    x, y = wo[2], min(max(roughness, 0.01), 1.0)
    deviation = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
    middle = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
    offset = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y))
    reflected = np.exp(-0.5 * ((x - middle) / deviation) ** 2) / (deviation * np.sqrt(2.0 * np.pi)) + offset
    reflected = np.clip(reflected, 0.0, 1.0)
    scale = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y)
    shear = np.sqrt(1.0 - np.minimum(x, 1.0)) * (y - 1.0) * y**3
    shear = shear / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)
    across = np.sqrt(np.maximum(1.0 - x * x, 0.0))
    known = across > 1e-6
    along = np.where(known, ((wi * wo).sum(axis=0) - wi[2] * x) / np.where(known, across, 1.0), wi[0])
    aside2 = np.maximum(1.0 - wi[2] ** 2 - along**2, 0.0)
    size2 = (scale * along + shear * wi[2]) ** 2 + scale * scale * aside2 + wi[2] ** 2
    return reflected * (scale / size2) ** 2 / np.pi, reflected


def darkening(layers: OpenPbr, base: Base) -> Floats:
    """Factor (3, n) or (3, 1) on the base by light that the coat sends back to it."""
    inside = 1.0 - (1.0 - f0_of(layers.coat_ior)) / layers.coat_ior**2
    reflected = base.colour * (1.0 + np.asarray(base.metalness) * (layers.specular_weight - 1.0))
    factor = (1.0 - inside) / (1.0 - inside * reflected)
    return np.asarray(1.0 + layers.coat_weight * layers.coat_darkening * (factor - 1.0))
