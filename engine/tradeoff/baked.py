"""Bakes of several settings at once: those over cube maps of one size share their rays, and nothing else.

What rays cost is nearly all of a bake, so a ladder of terms, coefficients or orders takes little more than its finest
step. Times stay those of a bake alone: its seconds are those of the shared rays, measured, and of its own tables and
vectors, measured. That transport is made in memory; the seconds that a file would take to write are not part of it.
Gaussians are baked one setting after the other, into a file as for use.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.effects.setting import Setting
from engine.ground import Ground
from engine.lamps import Lamp
from engine.mesh import Mesh
from engine.scene import Scene
from engine.steps import Step, Steps, part
from engine.transport import gaussian_bake, sh_bake, wavelet_bake
from engine.transport.gaussian import GaussianTransport
from engine.transport.lit import Lit, LitHarmonics, LitWavelets, lit_gaussians
from engine.transport.sh_lighting import scene_coefficients
from engine.transport.sh_transfer import ShTransport, transferred
from engine.transport.visibility import Receivers, receivers, visibility_shares
from engine.transport.wavelet import (
    DIFFUSE,
    WaveletTransport,
    cube_texels,
    light_maps,
    transport_vectors,
    vectors_of,
    vertex_frames,
)
from engine.transport.wavelet_lighting import dark, lighting_of, tuples

#: Parts along a side into which a texel is cut where visibility changes.
FINE = 4

#: Reflections between parts of the model where they count.
BOUNCES = 4

#: Share of free memory that the transport of one group may take.
SHARE = 0.4

#: Visibility counts of one chunk, about 50 ms of rays.
CHUNK = 1 << 20

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Bake:
    """Transport of one setting, and what it took: see `engine.tradeoff.point`."""

    setting: Setting
    transport: Any
    bake_s: float
    memory_bytes: int
    size_bytes: int


@dataclass(frozen=True)
class LeftOut:
    """A setting that was not measured, and why."""

    setting: Setting
    reason: str


@dataclass(eq=False)
class _Member:
    """A bake of a group under way."""

    setting: Setting
    work: Any
    make: Callable[[NDArray[np.int64], NDArray[np.uint8]], Mapping[str, NDArray[Any]]]
    own_s: float
    made_s: float = 0.0
    parts: list[Mapping[str, NDArray[Any]]] = field(default_factory=list)


def edge_of(setting: Setting) -> int:
    """Texels along an edge of the cube maps over which a setting sums visibility."""
    return setting["cube"] if setting.mode == "wavelet" else sh_bake.default_edge(setting["order"])


def groups(settings: Sequence[Setting]) -> list[list[Setting]]:
    """Those settings of harmonics and wavelets that share rays, coarse cube maps first."""
    shared = [setting for setting in settings if setting.mode in ("sh", "wavelet")]
    edges = sorted({edge_of(setting) for setting in shared})
    return [[setting for setting in shared if edge_of(setting) == edge] for edge in edges]


def bake_group(
    scene: Scene, group: Sequence[Setting], seconds: float = float("inf")
) -> Steps[tuple[list[Bake], list[LeftOut]]]:
    """The bakes of a group (see `groups`), and those settings that take too much memory or more than `seconds`.

    How long all of it takes is told from the vertices that are done.
    """
    edge = edge_of(group[0])
    members, left_out = yield from part(_prepared(scene, group), 0.0, 0.3)
    if not members:
        return [], left_out
    surface: Mesh = members[0].work.surface
    before = time.perf_counter()
    of = receivers(surface)
    rays_s = time.perf_counter() - before
    _warm_up(members, of, edge)
    deadline = time.perf_counter() + seconds
    for start, stop in pairwise(_bounds(len(surface.positions), int(members[0].work.ground_vertex), edge)):
        vertices = np.arange(start, stop)
        before = time.perf_counter()
        counts = _visible(of, edge, vertices)
        rays_s += time.perf_counter() - before
        for member in members:
            before = time.perf_counter()
            member.parts.append(member.make(vertices, counts))
            member.own_s += time.perf_counter() - before
            member.made_s += time.perf_counter() - before
        done = int(stop) / len(surface.positions)
        left_out += _dropped(members, rays_s, done, deadline)
        if not members:
            return [], left_out
        yield Step(0.3 + 0.7 * done, f"baking {len(members)} settings on one set of rays")
    return [_finished(member, rays_s) for member in members], left_out


def _warm_up(members: Sequence[_Member], of: Receivers, edge: int) -> None:
    """Have kernels compiled, and tables made that outlive a bake: later bakes of a process do not wait for them."""
    one = np.arange(1)
    counts = _visible(of, edge, one)
    for member in members:
        member.make(one, counts)


def _visible(of: Receivers, edge: int, vertices: NDArray[np.int64]) -> NDArray[np.uint8]:
    """(B, 6 N²) how many parts of each texel are seen."""
    shares: list[NDArray[np.uint8]] = [counts for _, counts in visibility_shares(of, edge, FINE, vertices)]
    return np.concatenate(shares)


def _dropped(members: list[_Member], rays_s: float, done: float, deadline: float) -> list[LeftOut]:
    """Take those out that cost most, until the rest is done by the deadline as far as one can tell."""
    left_out: list[LeftOut] = []
    left_s = deadline - time.perf_counter()
    while members and (rays_s + sum(member.made_s for member in members)) * (1.0 / done - 1.0) > left_s:
        costly = max(members, key=lambda member: member.made_s)
        members.remove(costly)
        takes_s = (rays_s + costly.made_s) / done
        left_out.append(LeftOut(costly.setting, f"it takes about {takes_s:.0f} s, for which there is no time"))
    return left_out


def _bounds(vertices: int, first: int, edge: int) -> NDArray[np.int64]:
    """Where chunks begin, and the end; none mixes model and ground."""
    step = max(1, CHUNK // (6 * edge * edge))
    ends = np.array([0, first, vertices], np.int64)
    return np.unique(np.concatenate([np.arange(0, first, step), np.arange(first, vertices, step), ends]))


def _prepared(scene: Scene, group: Sequence[Setting]) -> Steps[tuple[list[_Member], list[LeftOut]]]:
    members: list[_Member] = []
    left_out: list[LeftOut] = []
    room = SHARE * psutil.virtual_memory().available
    for number, setting in enumerate(group):
        share = number / len(group), (number + 1) / len(group)
        before = time.perf_counter()
        prepare = _PREPARE[setting.mode]
        try:
            work = yield from part(prepare(scene.mesh, scene.brdf, scene.ground, setting), *share)
        except ValueError as reason:
            left_out.append(LeftOut(setting, str(reason)))
            continue
        if work.size_bytes > room:
            needs = f"it needs {work.size_bytes / 1e9:.1f} GB of memory, more than is free"
            left_out.append(LeftOut(setting, needs))
            continue
        room -= work.size_bytes
        make = yield from _MAKER[setting.mode](work)
        members.append(_Member(setting, work, make, time.perf_counter() - before))
    return members, left_out


def _sh_work(mesh: Mesh, brdf: Brdf, ground: Ground | None, setting: Setting) -> Steps[sh_bake.Work]:
    bounces = BOUNCES if setting["interreflection"] else 0
    settings = sh_bake.BakeSettings(setting["order"], edge_of(setting), FINE, bounces)
    return (yield from sh_bake.prepare(mesh, brdf, settings, ground))


def _wavelet_work(mesh: Mesh, brdf: Brdf, ground: Ground | None, setting: Setting) -> Steps[wavelet_bake.Work]:
    factors = yield from wavelet_bake.factors_for(brdf, setting["terms"])
    settings = wavelet_bake.BakeSettings(setting["cube"], setting["coefficients"], FINE)
    return wavelet_bake.prepare(mesh, factors, settings, ground)


def _sh_maker(work: sh_bake.Work) -> Steps[Any]:
    of: Receivers = receivers(work.surface, work.caster)
    sent = (yield from sh_bake.reflected(work, of)) if work.settings.bounces else None
    baker = sh_bake.baker_of(work, of, sent)
    return lambda vertices, counts: {"rows": baker.rows(vertices, counts)}


def _wavelet_maker(work: wavelet_bake.Work) -> Steps[Any]:
    yield Step(1.0, "preparing vectors")
    settings, maps = work.settings, light_maps(work.factors)
    texels, frames = cube_texels(settings.edge), vertex_frames(work.surface, work.factors.isotropic)
    ground = np.ones((1, 1, 1), np.float32)

    def make(vertices: NDArray[np.int64], counts: NDArray[np.uint8]) -> Arrays:
        of_model = vertices[0] < work.ground_vertex
        chart, shown = (work.factors.chart, maps) if of_model else (DIFFUSE, ground)
        return transport_vectors(frames[vertices], counts, FINE**2, texels, chart, shown, settings.coefficients)

    return make


_PREPARE: Mapping[str, Callable[..., Steps[Any]]] = {"sh": _sh_work, "wavelet": _wavelet_work}
_MAKER: Mapping[str, Callable[..., Steps[Any]]] = {"sh": _sh_maker, "wavelet": _wavelet_maker}


def _finished(member: _Member, rays_s: float) -> Bake:
    work, before = member.work, time.perf_counter()
    arrays = {name: np.concatenate([part[name] for part in member.parts]) for name in member.parts[0]}
    member.parts.clear()
    transport: Any
    if member.setting.mode == "sh":
        table, bounces = work.table, bool(work.settings.bounces)
        first, albedo = work.ground_vertex, work.ground_albedo
        transport = ShTransport(work.surface, first, table.diffuse, albedo, table, bounces, arrays["rows"])
        shared = table.values.nbytes
    else:
        parts = (work.surface, work.ground_vertex, work.factors, work.ground_albedo, work.settings.edge)
        transport = WaveletTransport(*parts, vectors_of(arrays))
        shared = work.factors.first.nbytes + work.factors.second.nbytes
    memory = shared + sum(array.nbytes for array in arrays.values())
    taken_s = rays_s + member.own_s + time.perf_counter() - before
    return Bake(member.setting, transport, taken_s, memory, int(work.size_bytes))


def bake_gaussians(
    scene: Scene, setting: Setting, seconds: float = float("inf")
) -> Steps[tuple[list[Bake], list[LeftOut]]]:
    """The bake of Gaussians in a file that is gone again, or why there is none, as `bake_group`."""
    started = time.perf_counter()
    settings = gaussian_bake.BakeSettings(setting["lobes"], indirect=bool(setting["interreflection"]))
    try:
        work = yield from part(gaussian_bake.prepare(scene.mesh, scene.brdf, settings, scene.ground), 0.0, 0.2)
    except ValueError as reason:
        return [], [LeftOut(setting, str(reason))]
    takes_s = gaussian_bake.estimate_s(work)
    if time.perf_counter() - started + takes_s > seconds:
        return [], [LeftOut(setting, f"it takes about {takes_s:.0f} s, for which there is no time")]
    with tempfile.TemporaryDirectory(prefix="lightarc-") as folder:
        made = yield from part(gaussian_bake.bake(Path(folder) / "lobes", work), 0.2, 1.0)
        size = (Path(folder) / "lobes").stat().st_size
        transport = made.transport
        lobes = [array for of in transport.components for array in (of.weight, of.mean, of.sigma)]
        matt = transport.diffuse.rows.nbytes if transport.diffuse is not None else 0
        held = sum(array.nbytes for array in lobes) + matt
    return [Bake(setting, transport, time.perf_counter() - started, held, size)], []


def lit(bake: Bake, scene: Scene) -> Lit:
    """What the light of `scene` makes of a bake: all that has to be worked out when the light has changed."""
    if isinstance(bake.transport, GaussianTransport):
        around, of_map = scene.environment, {"rotation": scene.environment_rotation, "factor": scene.irradiance}
        own = (Lamp(scene.light, (scene.irradiance,) * 3),) if around is None and scene.irradiance > 0.0 else ()
        return lit_gaussians(bake.transport, around, **of_map, lamps=(*own, *scene.lamps))
    if isinstance(bake.transport, ShTransport):
        light = scene_coefficients(scene, bake.transport.order)
        return LitHarmonics(bake.transport, transferred(bake.transport, light))
    edge, lamps = bake.transport.edge, scene.lamps
    if scene.environment is None:
        own = (Lamp(scene.light, (scene.irradiance,) * 3),) if scene.irradiance > 0.0 else ()
        return LitWavelets(bake.transport, tuples(bake.transport, dark(edge, (*own, *lamps))))
    turn, factor = scene.environment_rotation, scene.irradiance
    lighting = lighting_of(scene.environment, edge, rotation=turn, factor=factor, lamps=lamps)
    return LitWavelets(bake.transport, tuples(bake.transport, lighting))
