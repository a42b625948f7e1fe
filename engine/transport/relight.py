"""Light, and baked transport relit by one light: all that an image needs besides the camera.

Every method has its own kind of `RelightTransport`; all have the same fields and functions, so a renderer need not know
it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.directions import normalize
from engine.geometry.camera import Vector
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.light.lamps import Lamp
from engine.light.near_lamps import NearLamp
from engine.scene.scene import RelightTransport as RelightTransport
from engine.scene.scene import Scene
from engine.scene.scene import Shade as Shade
from engine.transport.gaussian import transfer as gaussian_transfer
from engine.transport.gaussian.lighting import GaussianLight, filter_for, levels_under, lobe_radiance
from engine.transport.gaussian.transfer import GaussianTransport, diffuse_radiance
from engine.transport.sh import transfer as sh_transfer
from engine.transport.sh.brdf_table_varying import Table
from engine.transport.sh.lighting import lamp_coefficients, project, turn_about_y
from engine.transport.sh.transfer import ShTransport
from engine.transport.wavelet import transfer as wavelet_transfer
from engine.transport.wavelet.transfer import GRAZING, WaveletTransport

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Light:
    """All that shines: an environment rotated about +Y by `rotation` rad, times `factor`, and lamps beside it.

    `near_lamps` stand near the model; not every method takes them.
    """

    environment: EnvironmentMap | None = None
    rotation: float = 0.0
    factor: float = 1.0
    lamps: tuple[Lamp, ...] = ()
    near_lamps: tuple[NearLamp, ...] = ()


def light_of(scene: Scene) -> Light:
    """All the light of a scene: its environment, or its one light, and its lamps, near and far."""
    if scene.environment is not None:
        around = scene.environment, scene.environment_rotation, scene.irradiance
        return Light(*around, scene.lamps, scene.near_lamps)
    own = (Lamp(scene.light, (scene.irradiance,) * 3),) if scene.irradiance > 0.0 else ()
    return Light(lamps=(*own, *scene.lamps), near_lamps=scene.near_lamps)


@dataclass(frozen=True, eq=False)
class Illuminated:
    """Result of a method under a light.

    Attributes
    ----------
    relit : the transport that is drawn.
    figures : the method's own part of a record, `light_s` and `relight_s` (seconds) among them.
    negative_rel : how much of the vertices' radiance towards a point was below 0, over what was not.
    remedy : what helps against that, as the end of a sentence.
    warnings : what else there is to say, as sentences.
    """

    relit: RelightTransport
    figures: dict[str, Any]
    negative_rel: Callable[[Vector], float]
    remedy: str
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class RelightWavelets:
    """Wavelet transport and its light-modulated K-tuples `rows` (R, 3), as `wavelet.lighting.tuples` finds them."""

    transport: WaveletTransport
    rows: NDArray[np.floating[Any]]

    def __post_init__(self) -> None:
        _check("rows", self.rows, (self.transport.rows, 3))

    @property
    def method(self) -> str:
        return "wavelet"

    @property
    def mesh(self) -> Mesh:
        return self.transport.mesh

    @property
    def size_bytes(self) -> int:
        return int(self.rows.nbytes)

    def shade(self, eye: Vector) -> Shade:
        """The mean of what the corners of a triangle send towards `eye`."""
        rows = np.asarray(self.rows, np.float64)
        return lambda corners, weights: mean_of_corners(
            self.mesh,
            self.transport.frames,
            eye,
            lambda local, vertices: wavelet_transfer.sum_signed_radiance(self.transport, rows, local, vertices),
            corners,
            weights,
        )

    @property
    def flat_vertex(self) -> int:
        """The first vertex that is as bright towards every side: the ground's."""
        return self.transport.ground_vertex


@dataclass(frozen=True, eq=False)
class RelightSh:
    """Transport in SH and what it makes of the light, `rows` (R, 3), as `sh.transfer.transfer` finds them."""

    transport: ShTransport
    rows: NDArray[np.floating[Any]]

    def __post_init__(self) -> None:
        _check("rows", self.rows, (len(self.transport.rows), 3))

    @property
    def method(self) -> str:
        return "sh"

    @property
    def mesh(self) -> Mesh:
        return self.transport.mesh

    @property
    def size_bytes(self) -> int:
        return int(self.rows.nbytes)

    def shade(self, eye: Vector) -> Shade:
        """The mean of what the corners of a triangle send towards `eye`."""
        return lambda corners, weights: mean_of_corners(
            self.mesh,
            self.transport.frames,
            eye,
            lambda local, vertices: sh_transfer.sum_signed_radiance(self.transport, self.rows, local, vertices),
            corners,
            weights,
        )

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
class RelightGaussians:
    """Lobes and the light that they are integrated with; `diffuse` (V, 3) is the radiance of diffuse part and ground.

    `diffuse` is what `gaussian.diffuse_radiance` finds, before `gaussian.diffuse_gain`.
    """

    transport: GaussianTransport
    light: GaussianLight
    diffuse: NDArray[np.floating[Any]]

    def __post_init__(self) -> None:
        _check("diffuse", self.diffuse, (len(self.transport.mesh.positions), 3))

    @property
    def method(self) -> str:
        return "gaussian"

    @property
    def mesh(self) -> Mesh:
        return self.transport.mesh

    @property
    def size_bytes(self) -> int:
        return int(self.diffuse.nbytes)

    def shade(self, eye: Vector) -> Shade:
        """Lobes mixed across a triangle and looked up once, and the mean of the diffuse part of its corners."""
        seen = gaussian_transfer.lobes_seen_from(self.transport, eye)
        diffuse = self.diffuse * gaussian_transfer.diffuse_gain(self.transport, eye)[:, None]

        def shade(corners: Indices, weights: Floats) -> Floats:
            lobes = gaussian_transfer.mix(seen, corners, weights)
            value = lobe_radiance(self.light, lobes.energy, lobes.mean, lobes.sigma)
            value += np.einsum("nk,nkc->nc", weights, diffuse[corners])
            return value

        return shade

    @property
    def flat_vertex(self) -> int:
        """The first vertex that is as bright towards every side: the ground's."""
        return self.transport.ground_vertex


def relight_gaussians(
    transport: GaussianTransport,
    environment: EnvironmentMap | None,
    *,
    rotation: float = 0.0,
    factor: float = 1.0,
    lamps: Sequence[Lamp] = (),
) -> RelightGaussians:
    """Lobes under `environment`, rotated about +Y by `rotation` rad and times `factor`, with `lamps` beside it.

    Filtering the map takes some tenths of a second, and nothing where it is one of the last two.
    """
    filtered = None
    if environment is not None:
        filtered = filter_for(environment, levels_under(environment, transport.sigma_range))
    light = GaussianLight(filtered, factor, rotation, tuple(lamps))
    if transport.diffuse is None:
        return RelightGaussians(transport, light, np.zeros((len(transport.mesh.positions), 3)))
    order = transport.diffuse.order
    total = np.zeros((order**2, 3))
    if environment is not None:
        total += factor * turn_about_y(project(environment, order), rotation)
    coefficients = total + sum(lamp_coefficients(lamp, order) for lamp in lamps)
    return RelightGaussians(transport, light, diffuse_radiance(transport, coefficients))


def mean_of_corners(
    mesh: Mesh,
    frames: Floats,
    eye: Vector,
    radiance: Callable[[Floats, Indices], NDArray[np.floating[Any]]],
    corners: Indices,
    weights: Floats,
) -> Floats:
    """Sums (n, 3), which may be negative, of the `radiance` of vertices towards directions in their own frames."""
    value = np.zeros((len(corners), 3))
    for corner in range(3):
        vertices = corners[:, corner]
        wo = normalize(np.asarray(eye) - mesh.positions[vertices])
        local = np.einsum("nij,ni->nj", frames[vertices], wo)
        # a vertex of a face that is seen may be turned away itself
        local[:, 2] = np.maximum(local[:, 2], GRAZING)
        value += weights[:, corner, None] * radiance(normalize(local), vertices)
    return value


def _check(name: str, values: NDArray[Any], shape: tuple[int, ...]) -> None:
    if values.shape != shape:
        raise ValueError(f"{name} has the shape {values.shape}, not {shape}")
    if not np.isfinite(values).all():
        raise ValueError(f"{name} holds numbers that are not finite")
