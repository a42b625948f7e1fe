"""Baked transport under one light: what a picture needs of it besides the camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.environment import EnvironmentMap
from engine.lamps import Lamp
from engine.mesh import Mesh
from engine.transport.gaussian import GaussianTransport, matt_radiance
from engine.transport.gaussian_lighting import GaussianLight, filtered_for, levels_under
from engine.transport.sh_lighting import lamp_coefficients, project, turned_about_y
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


def lit_gaussians(
    transport: GaussianTransport,
    environment: EnvironmentMap | None,
    *,
    rotation: float = 0.0,
    factor: float = 1.0,
    lamps: Sequence[Lamp] = (),
) -> LitGaussians:
    """Lobes under `environment`, turned about +Y by `rotation` rad and times `factor`, with `lamps` beside it.

    Filtering the map takes some tenths of a second, and nothing where it is one of the last two.
    """
    filtered = None
    if environment is not None:
        filtered = filtered_for(environment, levels_under(environment, transport.sigma_range))
    light = GaussianLight(filtered, factor, rotation, tuple(lamps))
    if transport.diffuse is None:
        return LitGaussians(transport, light, np.zeros((len(transport.mesh.positions), 3)))
    order = transport.diffuse.order
    total = np.zeros((order**2, 3))
    if environment is not None:
        total += factor * turned_about_y(project(environment, order), rotation)
    coefficients = total + sum(lamp_coefficients(lamp, order) for lamp in lamps)
    return LitGaussians(transport, light, matt_radiance(transport, coefficients))


#: Whatever transport, under its light.
Lit = LitWavelets | LitHarmonics | LitGaussians


def _check(name: str, values: NDArray[Any], shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise ValueError(f"{name} has the shape {values.shape}, not {shape}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds numbers that are not finite")
