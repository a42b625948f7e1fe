"""Fitting Gaussians to the transport of every vertex towards the 92 views.

Green, Kautz, Matusik and Durand 2006, section 4.2: all views of a vertex are fitted at once, so that the distance to
the data (equation 7), the agreement of means (8) and of widths (9) with those of neighbouring views, and of the
arrangement of several lobes with that of neighbouring vertices (10) are small together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.transport.spherical_gaussian import Lobes
from engine.transport.view_directions import VIEWS

#: Lobes that a vertex and view may have.
MOST_LOBES = 3


@dataclass(frozen=True)
class FitSettings:
    """How to fit; ValueError where it cannot be.

    Attributes
    ----------
    lobes : for each vertex and view, 1 to 3.
    data, mean_alignment, sigma_alignment, spatial : the weights alpha, beta, gamma, delta of equation 6. The distance
        to the data is relative to the square of the transport, so the others do not depend on how bright a material is.
    sweeps : over the views of a vertex, at most; fewer where nothing changes any more.
    relaxations : passes over vertices that disagree with neighbours once all are fitted.
    """

    lobes: int = 1
    data: float = 1.0
    mean_alignment: float = 0.01
    sigma_alignment: float = 0.01
    spatial: float = 0.1
    sweeps: int = 8
    relaxations: int = 2

    def __post_init__(self) -> None:
        if not 1 <= self.lobes <= MOST_LOBES:
            raise ValueError(f"{self.lobes} lobes are not possible; 1 to {MOST_LOBES} are")
        weights = self.data, self.mean_alignment, self.sigma_alignment, self.spatial
        if not all(0.0 <= weight <= 1e6 for weight in weights):
            raise ValueError("the weights of the energies must be from 0 to 1,000,000")
        if not (1 <= self.sweeps <= 1000 and 0 <= self.relaxations <= 100):
            raise ValueError(f"{self.sweeps} sweeps and {self.relaxations} relaxations are not possible")


@dataclass(frozen=True, eq=False)
class TransportSamples:
    """The transport of B vertices towards all 92 views at directions that suit each.

    The samples of vertex b and view v are the rows start[92 b + v] … start[92 b + v + 1] − 1; none says that nothing is
    reflected there (below the horizon). They cover the whole sphere, also where the transport is 0, densely where it
    is large: Σ area · value approximates its integral, and Σ area is 4 π.

    Attributes
    ----------
    start : (92 B + 1,) int64, rising from 0.
    direction : (N, 3) float64 unit vectors in the world, towards the light.
    value : (N, 3) float64 ≥ 0: reflectance, cosine and visibility, linear RGB in 1/sr.
    area : (N,) float64 > 0 solid angle in sr that a sample counts for.
    """

    start: NDArray[np.int64]
    direction: NDArray[np.float64]
    value: NDArray[np.float64]
    area: NDArray[np.float64]

    def __post_init__(self) -> None:
        count = len(self.area)
        if (len(self.start) - 1) % VIEWS or self.start[0] != 0 or self.start[-1] != count:
            raise ValueError("the samples are not those of 92 views of each vertex")
        if self.direction.shape != (count, 3) or self.value.shape != (count, 3):
            raise ValueError("directions, values and areas of samples do not fit together")

    def __len__(self) -> int:
        return (len(self.start) - 1) // VIEWS


@dataclass(frozen=True, eq=False)
class Fit:
    """Lobes of V vertices and what they leave over.

    Attributes
    ----------
    lobes : with the weights of least squares.
    energy : (V, 92, 3) float32 integral of the transport over the sphere.
    norm : (V, 92) float32 root of the integral of its square, summed over RGB; 0 where nothing is reflected.
    error_rel : (V, 92) float32 distance between lobes and transport over `norm`; 0 where that is 0.
    preserving_error_rel : the same with the weights of `preserving`.
    """

    lobes: Lobes
    energy: NDArray[np.float32]
    norm: NDArray[np.float32]
    error_rel: NDArray[np.float32]
    preserving_error_rel: NDArray[np.float32]

    def preserving(self) -> Lobes:
        """The same lobes with weights scaled, for each view and colour, to the energy of the transport."""
        obtained = self.lobes.energy()
        factor = np.where(obtained > 0.0, self.energy, 1.0) / np.where(obtained > 0.0, obtained, 1.0)
        weight = (self.lobes.weight * factor[:, :, None]).astype(np.float32)
        return Lobes(weight, self.lobes.mean, self.lobes.sigma)
