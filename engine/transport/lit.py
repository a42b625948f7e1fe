"""Baked transport under one light: what a picture needs of it besides the camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import Mesh
from engine.transport.gaussian import GaussianTransport
from engine.transport.gaussian_lighting import GaussianLight
from engine.transport.sh_transfer import ShTransport
from engine.transport.sh_varied import Table
from engine.transport.wavelet import WaveletTransport


@dataclass(frozen=True, eq=False)
class LitWavelets:
    """Wavelet transport and its light-modulated K-tuples `rows` (R, 3), as `wavelet_lighting.tuples` finds them."""

    transport: WaveletTransport
    rows: NDArray[np.floating[Any]]

    def __post_init__(self) -> None:
        _check("rows", self.rows, (self.transport.rows, 3))

    @property
    def mesh(self) -> Mesh:
        return self.transport.mesh

    @property
    def flat_vertex(self) -> int:
        """The first vertex that is as bright towards every side: the ground's."""
        return self.transport.ground_vertex


@dataclass(frozen=True, eq=False)
class LitHarmonics:
    """Transport in harmonics and what it makes of the light, `rows` (R, 3), as `sh_transfer.transferred` finds them."""

    transport: ShTransport
    rows: NDArray[np.floating[Any]]

    def __post_init__(self) -> None:
        _check("rows", self.rows, (len(self.transport.rows), 3))

    @property
    def mesh(self) -> Mesh:
        return self.transport.mesh

    @property
    def table(self) -> Table:
        return self.transport.table

    @property
    def flat_vertex(self) -> int:
        """The first vertex that is as bright towards every side: the ground's, or of a Lambertian model all."""
        return 0 if self.transport.diffuse else self.transport.ground_vertex

    @property
    def flat(self) -> NDArray[np.floating[Any]]:
        """(V − flat_vertex, 3) the radiance of those vertices."""
        transport = self.transport
        if not transport.diffuse:
            return self.rows[self.flat_vertex * transport.order**2 :] * transport.ground_albedo
        first = transport.ground_vertex
        return np.concatenate([self.rows[:first] * transport.albedo, self.rows[first:] * transport.ground_albedo])


@dataclass(frozen=True, eq=False)
class LitGaussians:
    """Lobes and the light that they are integrated with; `matt` (V, 3) is the radiance of the matt part and the ground.

    `matt` is what `gaussian.matt_radiance` finds, before `gaussian.matt_gain`.
    """

    transport: GaussianTransport
    light: GaussianLight
    matt: NDArray[np.floating[Any]]

    def __post_init__(self) -> None:
        _check("matt", self.matt, (len(self.transport.mesh.positions), 3))

    @property
    def mesh(self) -> Mesh:
        return self.transport.mesh

    @property
    def flat_vertex(self) -> int:
        """The first vertex that is as bright towards every side: the ground's."""
        return self.transport.ground_vertex


#: Whatever transport, under its light.
Lit = LitWavelets | LitHarmonics | LitGaussians


def _check(name: str, values: NDArray[Any], shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise ValueError(f"{name} has the shape {values.shape}, not {shape}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds numbers that are not finite")
