"""A small transport method of the tests: ambient occlusion, one number for each vertex.

It bakes the open share of every vertex's hemisphere, and lights it with the mean radiance of whatever shines. No file
of the product names it: an entry in the list of the methods is all that there is to do.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.params import check, whole
from engine.core.steps import Step, Steps
from engine.geometry.ground import with_ground
from engine.geometry.mesh import Mesh
from engine.light.environment import solid_angles
from engine.planning.effects.simplified import albedos
from engine.transport.baking.file import (
    TransportFile,
    TransportPlan,
    open_transport,
    plan_transport,
    read_as,
    write_transport,
)
from engine.transport.baking.settings import NoLightSettings
from engine.transport.baking.visibility import receivers, visibility_shares
from engine.transport.method import Method, Relight, Subject
from engine.transport.relight import Illuminated, Light, Shade

NAME = "ambient-occlusion"


@dataclass(frozen=True)
class Settings:
    """Settings of a bake."""

    rays: int = whole(8, 4, 32, sweep=(4, 8, 16), words="rays along an edge", doc="rays along an edge of a cube map")

    def __post_init__(self) -> None:
        check(self)


@dataclass(frozen=True, eq=False)
class Occlusion:
    """`open` (V,) in [0, 1] times the albedo."""

    mesh: Mesh
    ground_vertex: int
    open: NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class RelitOcclusion:
    """`rows` (V, 3) are radiance."""

    transport: Occlusion
    rows: NDArray[np.float32]
    method: str = NAME
    flat_vertex: int = 0

    @property
    def mesh(self) -> Mesh:
        return self.transport.mesh

    @property
    def size_bytes(self) -> int:
        return self.rows.nbytes

    def shade(self, _eye: Any) -> Shade:
        return lambda corners, weights: np.einsum("nk,nkc->nc", weights, self.rows[corners].astype(np.float64))


@dataclass(frozen=True, eq=False)
class Work:
    surface: Mesh
    ground_vertex: int
    albedo: float
    settings: Settings
    plan: TransportPlan

    @property
    def vertices(self) -> int:
        return len(self.surface.positions)

    @property
    def size_bytes(self) -> int:
        return self.plan.size_bytes


@dataclass(frozen=True, eq=False)
class Baked:
    transport: Occlusion
    file: TransportFile
    bake_s: float
    visibility_s: float
    chunks: int = 1
    resumed_chunks: int = 0
    unoccluded_vertices: int = 0


def plan_file(surface: Mesh, first: int, values: NDArray[np.float32]) -> TransportPlan:
    return plan_transport(NAME, surface, {"ground_vertex": first}, {"open": values}, {}, np.zeros(1, np.int64))


def prepare(subject: Subject, settings: Settings, _tested: Any = None) -> Steps[Work]:
    yield Step(0.0, "looking at the model")
    mesh, first = subject.mesh, len(subject.mesh.positions)
    surface = mesh if subject.ground is None else with_ground(mesh, subject.ground)[0]
    albedo = float(albedos(cast(Any, subject.brdf)).mean.mean())
    empty = plan_file(surface, first, np.zeros(len(surface.positions), np.float32))
    return Work(surface, first, albedo, settings, empty)


def estimate_s(work: Work) -> float:
    return 1e-5 * work.vertices


def again(file: TransportFile, _brdf: Any, _kept: Any) -> Steps[Work]:
    yield Step(0.0, "looking at the file")
    raise UsageError(f"{file.path.name} does not say with how many rays it was baked; bake again")


def casts_rays(_work: Work) -> bool:
    return True


def bake(path: Any, work: Work, _cluster: str | None = None) -> Steps[Baked]:
    yield Step(0.0, "casting rays")
    started = time.perf_counter()
    counts = visibility_shares(receivers(work.surface), work.settings.rays, 1, np.arange(work.vertices))
    seen = np.concatenate([some.reshape(len(chunk), -1).mean(axis=1) for chunk, some in counts])
    values = (work.albedo * np.minimum(2.0 * seen, 1.0)).astype(np.float32)
    write_transport(path, plan_file(work.surface, work.ground_vertex, values))
    file = open_transport(path)
    took = time.perf_counter() - started
    return Baked(transport_of(file), file, took, took)


def transport_of(file: TransportFile) -> Occlusion:
    return read_as(
        file, NAME, lambda f: Occlusion(f.mesh, int(f.settings["ground_vertex"]), np.asarray(f.arrays["open"]))
    )


def parameters(work: Work, _settings: Settings) -> dict[str, Any]:
    return {"rays": work.settings.rays}


def measure(
    _work: Work, _subject: Subject, _settings: Settings, _tested: Any, _vertices: int = 0
) -> Steps[dict[str, Any]]:
    yield Step(1.0, "nothing is measured")
    return {}


def figures(_work: Work, baked: Baked, _prepared_s: float) -> dict[str, Any]:
    return {"open_mean": float(baked.transport.open.mean()), "skipped": [], "warnings": []}


def lines(result: dict[str, Any]) -> list[str]:
    return [f"open by {100.0 * result['open_mean']:.0f} % on average"]


def relight_transport(transport: Occlusion, light: Light, _asked: Any) -> RelitOcclusion:
    mean = np.zeros(3)
    if light.environment is not None:
        area = solid_angles(*light.environment.radiance.shape[:2])
        shares = np.broadcast_to(area, light.environment.radiance.shape[:2]) / (4.0 * math.pi)
        mean += light.factor * np.einsum("hwc,hw->c", light.environment.radiance.astype(np.float64), shares)
    for lamp in light.lamps:
        mean += np.array(lamp.irradiance) / (4.0 * math.pi)
    return RelitOcclusion(transport, (transport.open[:, None] * mean).astype(np.float32))


def relighter(transport: Occlusion, _subject: Any) -> Relight:
    def relight(light: Light, asked: Any, _wanted: Any) -> Steps[RelitOcclusion]:
        yield Step(0.0, "relighting")
        return relight_transport(transport, light, asked)

    return relight


def why_baked_for_one(_transport: Occlusion) -> str:
    return "The albedo is part of what was baked."


def restrict(work: Work, _chosen: Any) -> Work:
    return work


def complete(transport: Occlusion, _work: Work, _chosen: Any) -> Occlusion:
    return transport


def hold(transport: Occlusion) -> list[NDArray[Any]]:
    return [transport.open]


def illuminate(file: TransportFile, light: Light, asked: Any, _brdf: str | None) -> Steps[Illuminated]:
    yield Step(0.0, "relighting")
    found = relight_transport(transport_of(file), light, asked)
    return Illuminated(found, {"light_s": 0.0, "relight_s": 0.0}, lambda _eye: 0.0, "nothing helps")


class Textures:
    """All there is to draw are the rows of the vertices."""

    SHADER, SOURCE = "transported", str(Path(__file__).with_suffix(".glsl"))

    def __init__(self, _context: Any, relit: RelitOcclusion, _limits: Any) -> None:
        self.definitions: dict[str, str] = {}
        self.messages: list[str] = []

    @staticmethod
    def key(_relit: RelitOcclusion) -> object:
        return NAME

    @staticmethod
    def rows(relit: RelitOcclusion) -> list[Any]:
        return [relit.rows]

    def fill(self) -> Iterator[None]:
        return iter(())

    def relight(self, _relit: RelitOcclusion) -> Iterator[None]:
        return iter(())

    def bind(self, _program: Any) -> None:
        """Nothing beside the rows."""

    def release(self) -> None:
        """Nothing is held."""


METHOD = Method(
    NAME,
    "Ambient occlusion",
    "ambient occlusion",
    "AO",
    "A",
    "Baked ambient occlusion: soft shadows without direction",
    Settings,
    NoLightSettings,
    "tests.ambient_occlusion",
    "tests.ambient_occlusion",
    "tests.ambient_occlusion_plan",
    frozenset({"self-shadowing"}),
    always=frozenset({"self-shadowing"}),
)
