"""Light for Gaussian transport: a prefiltered environment that may turn, and lamps in closed form.

The radiance of a lobe under an environment is its energy, w ∫ G, times the map under the normalised Gaussian, one
look-up (Green2006 Eq. 11). When the light turns, means turn the other way and nothing is filtered anew.

A lamp from one direction sees the height of the lobe there. Of a disc the lobe is integrated: on the plane whose
distances are those of chords, |w − mu|, a Gaussian on the sphere is a flat one and areas stay areas. A disc about the
mean is a disc there, so that the integral is exact; another one is taken for a disc, which is right to 1 % of the
highest for radii up to 20°, and to 7 % at 60°.

How finely a map is filtered is chosen by the lobes that there are (`levels_for`): a diffuse varnish needs neither the
texels nor the levels of a mirror.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.cached import cached_property
from engine.core.errors import UsageError
from engine.light.cube_map import cube_of
from engine.light.environment import EnvironmentMap
from engine.light.gaussian_prefilter import (
    WIDEST,
    PrefilteredCube,
    gaussian_integral,
    prefilter,
    texel_width,
)
from engine.light.lamps import Lamp
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.gpu_layout import Atlas, atlas_of
from engine.transport.gaussian.kernel import add_lamp

#: Edges of the cube map that an environment is filtered from: the least, and the most.
MIN_EDGE, MAX_EDGE = 32, 512

#: Narrowest sigma in units of a texel's share 1 / N of an edge: from here on levels are right to 2 % of a lone texel.
NARROW = 4.0

#: Below this many texels wide, over N, levels are twice as far apart.
COARSE = 2.1

#: One width over the next: look-ups between two of them are right to 1.5 % of the height of the lobe.
RATIO = 2.0**0.375

#: This over N is one of the widths: from there on a level is summed over half as many texels, and from the width before
#: it on over half as many nodes (`engine.light.gaussian_prefilter`). A little narrower, either would take twice as
#: long.
THRIFTY = 5.5

#: Share of the light of all lobes that may be narrower, or wider, than the levels.
LEFT_OUT = 1e-3

#: Lobes that the widths are judged by, at most.
JUDGED = 200_000


@dataclass(frozen=True, eq=False)
class GaussianLight:
    """Light that lobes are integrated with.

    Attributes
    ----------
    environment : under Gaussians; None where lamps are all the light.
    factor : on the radiance of the environment.
    rotation : radians about +Y by which it is rotated, as `DistantLights.rotated`.
    lamps : beside it, in the world; neither factor nor rotation is theirs.
    """

    environment: PrefilteredCube | None = None
    factor: float = 1.0
    rotation: float = 0.0
    lamps: tuple[Lamp, ...] = ()

    def __post_init__(self) -> None:
        if not (math.isfinite(self.factor) and self.factor >= 0.0 and math.isfinite(self.rotation)):
            raise UsageError(f"a factor of {self.factor} or a rotation of {self.rotation} rad is not possible")
        object.__setattr__(self, "lamps", tuple(self.lamps))

    @cached_property
    def atlas(self) -> Atlas:
        """The environment as shaders look it up."""
        return _atlas(self.environment)

    @property
    def map_from_world(self) -> NDArray[np.float64]:
        """(3, 3) matrix that takes directions in the world to those of the map as it lies on disk."""
        cosine, sine = math.cos(self.rotation), math.sin(self.rotation)
        return np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])


def lobe_radiance(light: GaussianLight, energy: ArrayLike, mean: ArrayLike, sigma: ArrayLike) -> NDArray[np.float64]:
    """(n, 3) radiance of lobes of `energy` (n, K, 3), unit `mean` (n, K, 3) and `sigma` (n, K) rad, summed over K."""
    energy, mean, sigma = (np.ascontiguousarray(array, np.float64) for array in (energy, mean, sigma))
    value = np.zeros((len(sigma), 3))
    if light.environment is not None:
        towards = mean @ light.map_from_world.T if light.rotation else mean
        value += light.factor * np.einsum("nkc,nkc->nc", energy, light.environment.lookup(towards, sigma))
    for lamp in light.lamps:
        add_lamp(energy, mean, sigma, np.array(lamp.direction), chord(lamp), lamp_light(lamp), value)
    return value


def chord(lamp: Lamp) -> float:
    """The radius of a lamp as a chord, 2 sin(radius / 2): a cap has the area of a flat disc of that radius."""
    return 2.0 * math.sin(lamp.radius / 2.0)


def lamp_light(lamp: Lamp) -> NDArray[np.float64]:
    """(3,) its radiance, or the irradiance of one that has no size."""
    return np.array(lamp.radiance if lamp.radius else lamp.irradiance)


@dataclass(frozen=True)
class Levels:
    """Texels along an edge of the cube map that is filtered, and the rising widths `sigma` in rad of its levels."""

    edge: int
    sigma: tuple[float, ...]


def levels_for(components: Sequence[Lobes]) -> Levels:
    """Filter widths that any environment needs for these lobes."""
    return levels_between(*sigma_range(components))


def levels_under(environment: EnvironmentMap, widths: tuple[float, float]) -> Levels:
    """The same of this one for lobes of these widths (`sigma_range`): it is cut no finer than its own texels are."""
    across = math.ceil(environment.radiance.shape[1] / 4)
    return levels_between(*widths, min(max(1 << (across - 1).bit_length(), MIN_EDGE), MAX_EDGE))


def levels_between(narrow: float, wide: float, most: int = MAX_EDGE) -> Levels:
    """Levels for lobes of `narrow` … `wide` rad, and the least map, of `most` texels along an edge, that shows them.

    They are `RATIO` apart; those that are hardly wider than a texel, which are the dearest and off by what texels are
    anyway, twice as far. The first is at most `narrow`, for all have `THRIFTY` / N among them or would if they went on.
    """
    edge = MIN_EDGE
    while edge < most and narrow * edge < NARROW:
        edge *= 2
    least, thrifty = 0.5 * texel_width(edge), THRIFTY / edge
    first = min(max(narrow, least), WIDEST / RATIO)
    last = min(max(wide, RATIO * first), WIDEST)
    step = max(math.floor(math.log(first / thrifty, RATIO) + 1e-9), -2 if first * edge < COARSE else -9)
    sigma = [thrifty * RATIO**step]
    while sigma[-1] < last * (1.0 - 1e-9):
        step += 1
        sigma.append(thrifty * RATIO**step)
    while sigma[0] > first * (1.0 + 1e-9):
        sigma.insert(0, max(0.5 * sigma[0], least))
    if sigma[1] < 1.1 * sigma[0]:  # the narrowest of all, and one that is hardly wider
        del sigma[1]
    return Levels(edge, tuple(sigma))


def sigma_range(components: Sequence[Lobes]) -> tuple[float, float]:
    """Narrowest and widest sigma of lobes that carry light, but for a thousandth of the light at either end."""
    sigma, energy = [np.empty(0)], [np.empty(0)]
    for lobes in components:
        stride = max(1, lobes.sigma.size // JUDGED)
        widths = np.asarray(lobes.sigma.reshape(-1)[::stride], np.float64)
        heights = np.asarray(lobes.weight.reshape(-1, 3)[::stride].sum(axis=1), np.float64)
        kept = heights > 0.0
        sigma.append(widths[kept])
        energy.append(heights[kept] * gaussian_integral(widths[kept]))
    widths, light = np.concatenate(sigma), np.concatenate(energy)
    if not len(widths):
        return 0.5, 0.5
    order = np.argsort(widths)
    reached = np.cumsum(light[order]) / light.sum()
    low = int(np.searchsorted(reached, LEFT_OUT))
    high = int(np.searchsorted(reached, 1.0 - LEFT_OUT))
    return float(widths[order][low]), float(widths[order][min(high, len(widths) - 1)])


def filter_for(environment: EnvironmentMap, levels: Levels) -> PrefilteredCube:
    """`filtered`, and the same again for the last two that were asked for."""
    return _kept(environment, levels)


def filter_levels(environment: EnvironmentMap, levels: Levels) -> PrefilteredCube:
    """`environment` under Gaussians of these widths."""
    return prefilter(cube_of(environment, levels.edge), levels.sigma)


_kept = lru_cache(maxsize=2)(filter_levels)


@lru_cache(maxsize=2)
def _atlas(cube: PrefilteredCube | None) -> Atlas:
    return atlas_of(cube)
