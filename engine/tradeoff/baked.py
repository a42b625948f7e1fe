"""Bakes of several settings at once: those over cube maps of one size share their rays, and nothing else.

What rays cost is nearly all of a bake, so a ladder of terms, coefficients or orders takes little more than its finest
step. Times stay those of a bake alone: its seconds are those of the shared rays, measured, and of its own vectors,
measured; as in any bake they begin when the reflectance is tabulated or factored. That transport is made in memory; the
seconds that a file would take to write are not part of it.
Gaussians are baked one setting after the other, into a file as for use.

Only the vertices that a picture shows are baked, which is about half of them, and the others get copies: the picture is
the same, and so are the times of its light and its frames, and its memory. The seconds of a bake are those of all
vertices: rays as many times more as more vertices need them, the rest as there are more vertices. (Gaussians that are
fitted beside fewer neighbours may differ a little.)
Chunks are made in an order that is spread over the model, so the first ones tell what all will take.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.effects.cost_model import BOUNCES
from engine.effects.setting import Setting
from engine.effects.sizes import MATT_ORDER
from engine.factor.separable_factors import SeparableFactors
from engine.ground import Ground
from engine.lamps import Lamp
from engine.mesh import Mesh
from engine.scene import Scene
from engine.steps import Step, Steps, part
from engine.transport import gaussian_bake, sh_bake, wavelet_bake
from engine.transport.gaussian import GaussianTransport
from engine.transport.gaussian_samples import GlossySurface
from engine.transport.lit import Lit, LitHarmonics, LitWavelets, lit_gaussians
from engine.transport.sh_lighting import scene_coefficients
from engine.transport.sh_transfer import ShTransport, transferred
from engine.transport.shared_rays import FINE, Indices, Make, chunks, counted, joined, wavelet_maker
from engine.transport.spherical_gaussian import Lobes
from engine.transport.visibility import Receivers, receivers
from engine.transport.wavelet import WaveletTransport, vectors_of
from engine.transport.wavelet_lighting import dark, lighting_of, tuples

#: Orders of harmonics up to this share their rays with wavelets.
HIGH = 8

#: Share of free memory that the transport of one group may take.
SHARE = 0.4

#: Chunks from which on the time of all of them is told.
TELLING = 6

#: Factors of one reflectance by their number of terms.
Factors = dict[int, SeparableFactors]


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
    """A bake of a group under way: `own_s` it took to prepare, `made_s` its rows, `parts` by their first vertices."""

    setting: Setting
    work: Any
    make: Make
    own_s: float
    made_s: float = 0.0
    parts: dict[int, Mapping[str, NDArray[Any]]] = field(default_factory=dict)


@dataclass(eq=False)
class _Rays:
    """The rays of a group under way: `chosen` of the vertices `of`, and the seconds of those that are `done`."""

    of: Receivers
    chosen: Indices
    ready_s: float
    cast_s: float = 0.0
    done: int = 0
    asked: int = 0

    def cast(self, vertices: Indices, edge: int) -> NDArray[np.uint8]:
        before = time.perf_counter()
        counts = counted(self.of, edge, vertices)
        self.cast_s += time.perf_counter() - before
        self.done += len(vertices)
        self.asked += int(np.count_nonzero(~self.of.free[vertices]))
        return counts

    def bake_s(self, member: _Member) -> float:
        """Seconds of a bake of all vertices, from those that are done."""
        more = len(self.of) / self.done
        rays = float(np.count_nonzero(~self.of.free)) / self.asked if self.asked else more
        return self.ready_s + member.own_s + rays * self.cast_s + more * member.made_s


def edge_of(setting: Setting) -> int:
    """Texels along an edge of the cube maps over which a setting sums visibility."""
    return setting["cube"] if setting.mode == "wavelet" else sh_bake.default_edge(setting["order"])


def groups(settings: Sequence[Setting]) -> list[list[Setting]]:
    """Those settings of harmonics and wavelets that share rays, coarse cube maps first.

    Harmonics of high orders come last and by themselves: their matrices take longer than all the rest.
    """
    shared = [setting for setting in settings if setting.mode in ("sh", "wavelet")]
    kinds = sorted({_kind(setting) for setting in shared})
    return [[setting for setting in shared if _kind(setting) == kind] for kind in kinds]


def is_high(setting: Setting) -> bool:
    """Whether a setting is of harmonics that share their rays with nothing."""
    return setting.mode == "sh" and setting["order"] > HIGH


def _kind(setting: Setting) -> tuple[bool, int]:
    return is_high(setting), edge_of(setting)


def bake_group(
    scene: Scene,
    group: Sequence[Setting],
    seconds: float = float("inf"),
    shown: Indices | None = None,
    known: Factors | None = None,
) -> Steps[tuple[list[Bake], list[LeftOut]]]:
    """The bakes of a group (see `groups`), and those settings that take too much memory or more than `seconds`.

    `shown` are the vertices, of model and ground, that pictures need; all of them where nothing is given. Factors of
    the reflectance are taken from `known`, and put there. How long it takes is told from the vertices that are done.
    """
    edge = edge_of(group[0])
    members, left_out = yield from part(_prepared(scene, group, {} if known is None else known), 0.0, 0.3)
    if not members:
        return [], left_out
    surface, first = members[0].work.surface, int(members[0].work.ground_vertex)
    before = time.perf_counter()
    of = receivers(surface)
    rays = _Rays(of, _chosen(shown, first, len(of)), time.perf_counter() - before)
    _warm_up(members, of, edge)
    deadline = time.perf_counter() + seconds
    for number, vertices in enumerate(_spread(chunks(rays.chosen, first, edge))):
        counts = rays.cast(vertices, edge)
        for member in members:
            before = time.perf_counter()
            member.parts[int(vertices[0])] = member.make(vertices, counts)
            member.made_s += time.perf_counter() - before
        done = rays.done / len(rays.chosen)
        if number + 1 >= TELLING or time.perf_counter() > deadline:
            left_out += _dropped(members, rays, done, deadline)
        if not members:
            return [], left_out
        yield Step(0.3 + 0.7 * done, f"baking {len(members)} settings on one set of rays")
    return [_finished(member, rays) for member in members], left_out


def _chosen(shown: Indices | None, first: int, vertices: int) -> Indices:
    """What is baked, rising: of the model and of the ground at least one vertex, for the others to copy."""
    if shown is None:
        return np.arange(vertices)
    return np.union1d(shown, [0, first] if first < vertices else [0]).astype(np.int64)


def _spread(some: list[Indices]) -> list[Indices]:
    """The same in another order, of which any beginning is spread evenly over the whole."""
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    return [some[number] for number in np.argsort(np.arange(len(some)) * golden % 1.0, kind="stable")]


def _warm_up(members: Sequence[_Member], of: Receivers, edge: int) -> None:
    """Have kernels compiled, and tables made that outlive a bake: later bakes of a process do not wait for them."""
    one = np.arange(1)
    counts = counted(of, edge, one)
    for member in members:
        member.make(one, counts)


def _dropped(members: list[_Member], rays: _Rays, done: float, deadline: float) -> list[LeftOut]:
    """Take those out that cost most, until the rest is done by the deadline as far as one can tell."""
    left_out: list[LeftOut] = []
    left_s = deadline - time.perf_counter()
    while members and (rays.cast_s + sum(member.made_s for member in members)) * (1.0 / done - 1.0) > left_s:
        costly = max(members, key=lambda member: member.made_s)
        members.remove(costly)
        left_out.append(LeftOut(costly.setting, too_long(rays.bake_s(costly))))
    return left_out


def too_long(seconds: float, what: str = "its bake") -> str:
    """Why a setting is left out of which something takes so many seconds."""
    told = f"{seconds:.0f}" if seconds >= 10.0 else f"{seconds:.2g}"
    return f"{what} takes about {told} s, for which there was no time"


def _prepared(scene: Scene, group: Sequence[Setting], known: Factors) -> Steps[tuple[list[_Member], list[LeftOut]]]:
    members: list[_Member] = []
    left_out: list[LeftOut] = []
    room = SHARE * psutil.virtual_memory().available
    for number, setting in enumerate(group):
        share = number / len(group), (number + 1) / len(group)
        try:
            work = yield from part(_work(scene, setting, known), *share)
        except ValueError as reason:
            left_out.append(LeftOut(setting, str(reason)))
            continue
        if work.size_bytes > room:
            needs = f"it needs {work.size_bytes / 1e9:.1f} GB of memory, more than is free"
            left_out.append(LeftOut(setting, needs))
            continue
        room -= work.size_bytes
        before = time.perf_counter()
        make = yield from _MAKER[setting.mode](work)
        members.append(_Member(setting, work, make, time.perf_counter() - before))
    return members, left_out


def _work(scene: Scene, setting: Setting, known: Factors) -> Steps[Any]:
    if setting.mode == "sh":
        return (yield from _sh_work(scene.mesh, scene.brdf, scene.ground, setting))
    terms = setting["terms"]
    if terms not in known:
        known[terms] = yield from wavelet_bake.factors_for(scene.brdf, terms)
    return _wavelet_work(scene.mesh, known[terms], scene.ground, setting)


def _sh_work(mesh: Mesh, brdf: Brdf, ground: Ground | None, setting: Setting) -> Steps[sh_bake.Work]:
    bounces = BOUNCES if setting["interreflection"] else 0
    settings = sh_bake.BakeSettings(setting["order"], edge_of(setting), FINE, bounces)
    return (yield from sh_bake.prepare(mesh, brdf, settings, ground))


def _wavelet_work(mesh: Mesh, factors: SeparableFactors, ground: Ground | None, setting: Setting) -> wavelet_bake.Work:
    settings = wavelet_bake.BakeSettings(setting["cube"], setting["coefficients"], FINE)
    return wavelet_bake.prepare(mesh, factors, settings, ground)


def _sh_maker(work: sh_bake.Work) -> Steps[Make]:
    of: Receivers = receivers(work.surface, work.caster)
    sent = (yield from sh_bake.reflected(work, of)) if work.settings.bounces else None
    baker = sh_bake.baker_of(work, of, sent)
    return lambda vertices, counts: {"rows": baker.rows(vertices, counts)}


def _wavelet_maker(work: wavelet_bake.Work) -> Steps[Make]:
    yield Step(1.0, "preparing vectors")
    settings = work.settings
    return wavelet_maker(work.surface, work.ground_vertex, work.factors, settings.edge, settings.coefficients)


_MAKER: Mapping[str, Callable[..., Steps[Any]]] = {"sh": _sh_maker, "wavelet": _wavelet_maker}


def _finished(member: _Member, rays: _Rays) -> Bake:
    work, before = member.work, time.perf_counter()
    some = joined(member.parts[start] for start in sorted(member.parts))
    member.parts.clear()
    transport: Any
    if member.setting.mode == "sh":
        table, bounces = work.table, bool(work.settings.bounces)
        rows = _for_all(some, rays, work.ground_vertex, 1 if table.diffuse else table.order**2)["rows"]
        first, albedo = work.ground_vertex, work.ground_albedo
        transport = ShTransport(work.surface, first, table.diffuse, albedo, table, bounces, rows)
        held = [table.values, rows]
    else:
        arrays = _for_all(some, rays, work.ground_vertex, work.factors.terms)
        parts = (work.surface, work.ground_vertex, work.factors, work.ground_albedo, work.settings.edge)
        transport = WaveletTransport(*parts, vectors_of(arrays))
        held = [work.factors.first, work.factors.second, *arrays.values()]
    taken_s = rays.bake_s(member) + time.perf_counter() - before
    memory = sum(array.nbytes for array in held)
    return Bake(member.setting, transport, taken_s, memory, int(work.size_bytes))


def _for_all(some: Mapping[str, NDArray[Any]], rays: _Rays, first: int, rows: int) -> Mapping[str, NDArray[Any]]:
    """Arrays of the vertices that were baked as those of all: others copy one of the model, or of the ground.

    A vertex of the model, which ends before vertex `first`, has so many `rows`, one of the ground has one.
    """
    if len(rays.chosen) == len(rays.of):
        return some
    copied = np.searchsorted(rays.chosen, np.arange(len(rays.of)), side="right") - 1
    of_model = int(np.searchsorted(rays.chosen, first))
    model = (copied[:first, None] * rows + np.arange(rows)).ravel()
    taken = np.concatenate([model, copied[first:] + of_model * (rows - 1)])
    return {name: array[taken] for name, array in some.items()}


def bake_gaussians(
    scene: Scene, setting: Setting, seconds: float = float("inf"), shown: Indices | None = None
) -> Steps[tuple[list[Bake], list[LeftOut]]]:
    """The bake of Gaussians in a file that is gone again, or why there is none, as `bake_group`.

    Where light from the model itself counts, all vertices are baked, because they light each other.
    """
    settings = gaussian_bake.BakeSettings(setting["lobes"], bool(setting["interreflection"]), order=MATT_ORDER)
    started = time.perf_counter()
    try:
        whole = yield from part(gaussian_bake.prepare(scene.mesh, scene.brdf, settings, scene.ground), 0.0, 0.2)
    except ValueError as reason:
        return [], [LeftOut(setting, str(reason))]
    vertices, first = len(whole.surface.positions), whole.model.ground_vertex
    chosen = _chosen(None if settings.indirect else shown, first, vertices)
    work = whole if len(chosen) == vertices else replace(whole, model=_only(whole.model, chosen))
    if time.perf_counter() - started + gaussian_bake.estimate_s(work) > seconds:
        return [], [LeftOut(setting, too_long(gaussian_bake.estimate_s(whole)))]
    with tempfile.TemporaryDirectory(prefix="lightarc-") as folder:
        made = yield from part(gaussian_bake.bake(Path(folder) / "lobes", work), 0.2, 1.0)
        transport = _of_all(made.transport, whole.surface, first, chosen)
    lobes = [array for of in transport.components for array in (of.weight, of.mean, of.sigma)]
    held = [*lobes, *([] if transport.diffuse is None else [transport.diffuse.rows])]
    taken_s = made.bake_s * vertices / len(chosen)
    return [Bake(setting, transport, taken_s, sum(array.nbytes for array in held), whole.size_bytes)], []


def _only(model: GlossySurface, chosen: Indices) -> GlossySurface:
    """A model with only the `chosen` vertices, and the faces that have no others, in the shade of all of it."""
    number = np.full(len(model.mesh.positions), -1)
    number[chosen] = np.arange(len(chosen))
    faces = number[model.mesh.faces]
    of_model, of, mesh = chosen[chosen < model.ground_vertex], model.of, model.mesh
    return replace(
        model,
        mesh=replace(
            mesh,
            positions=mesh.positions[chosen],
            normals=mesh.normals[chosen],
            uv=mesh.uv[chosen],
            faces=faces[(faces >= 0).all(axis=1)].astype(np.int32),
        ),
        ground_vertex=len(of_model),
        varied={name: values[of_model] for name, values in model.varied.items()},
        of=Receivers(of.caster, of.origin[chosen], of.normal[chosen], of.free[chosen]),
        frames=model.frames[chosen],
    )


def _of_all(some: GaussianTransport, surface: Mesh, first: int, chosen: Indices) -> GaussianTransport:
    """Lobes of the `chosen` vertices as those of all of `surface`, in memory."""
    copied = np.searchsorted(chosen, np.arange(len(surface.positions)), side="right") - 1
    components = tuple(
        Lobes(lobes.weight[copied[:first]], lobes.mean[copied[:first]], lobes.sigma[copied[:first]])
        for lobes in some.components
    )
    matt = some.diffuse
    diffuse = None if matt is None else replace(matt, mesh=surface, ground_vertex=first, rows=matt.rows[copied])
    return replace(some, mesh=surface, ground_vertex=first, components=components, diffuse=diffuse)


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
