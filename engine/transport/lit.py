"""Baked transport under one light: what a picture needs of it besides the camera."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.mesh import Mesh
from engine.transport.sh_table import BrdfTable
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
    """Light that arrives at vertices, as spherical harmonics, and what they make of it.

    Attributes
    ----------
    mesh : model, and after it the ground where there is one.
    table : of the reflectance of the vertices before `flat_vertex`.
    light : (flat_vertex, order², 3) in the frame of each vertex along the texture (`frames_along`), shadows included.
    flat : (V − flat_vertex, 3) radiance of the other vertices, the same towards every side: a ground, or a model that
        is Lambertian.
    """

    mesh: Mesh
    table: BrdfTable
    light: NDArray[np.floating[Any]]
    flat: NDArray[np.floating[Any]]

    def __post_init__(self) -> None:
        _check("light", self.light, (len(self.light), self.table.order**2, 3))
        _check("flat", self.flat, (len(self.mesh.positions) - len(self.light), 3))

    @property
    def flat_vertex(self) -> int:
        return len(self.light)


#: Whatever transport, under its light.
Lit = LitWavelets | LitHarmonics


def _check(name: str, values: NDArray[Any], shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise ValueError(f"{name} has the shape {values.shape}, not {shape}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds numbers that are not finite")
