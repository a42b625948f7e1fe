"""Bakes of several settings at once: those over cube maps of one size share their rays, and nothing else.

What rays cost is nearly all of a bake, so a sweep of terms, coefficients or orders takes little more than its finest
step. Times stay those of a bake alone: its seconds are those of the shared rays, measured, and of its own vectors,
measured; as in any bake they begin when the BRDF is tabulated or factored. That transport is made in memory; the
seconds that a file would take to write are not part of it.
Methods that share no rays are baked one setting after the other, into a file as for use.

Only the vertices that an image shows are baked, which is about half of them, and the others get copies: the image is
the same, and so are the times of its light and its frames, and its memory. The seconds of a bake are those of all
vertices: rays as many times more as more vertices need them, the rest as there are more vertices. (Gaussians that are
fitted beside fewer neighbours may differ a little.)
Chunks are made in an order that is spread over the model, so the first ones tell what all will take.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.core.budget import free_bytes
from engine.core.errors import UsageError
from engine.core.figure_text import size_text, time_text
from engine.core.steps import Step, Steps, part
from engine.geometry.ray_caster import RayCaster
from engine.planning.costs.setting import Setting
from engine.scene.scene import Scene
from engine.transport.baking.visibility import Receivers, receivers
from engine.transport.method import Subject, method_of, methods_with
from engine.transport.relight import RelightTransport, light_of
from engine.transport.shared_rays import Indices, Make, Sharing, chunks, count, join

#: Share of free memory that the transport of one group may take.
SHARE = 0.4

#: Chunks from which on the time of all of them is predicted.
TELLING = 6

#: Data that outlive a setting: factors of one BRDF by their number of terms.
Factors = dict[Any, Any]


@dataclass(frozen=True, eq=False)
class Bake:
    """Transport of one setting, and what it took: see `engine.tradeoff.point`."""

    setting: Setting
    transport: Any
    bake_s: float
    memory_bytes: int
    size_bytes: int
    another_s: float | None = None


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
        counts = count(self.of, edge, vertices)
        self.cast_s += time.perf_counter() - before
        self.done += len(vertices)
        self.asked += int(np.count_nonzero(~self.of.free[vertices]))
        return counts

    def bake_s(self, member: _Member) -> float:
        """Seconds of a bake of all vertices, from those that are done."""
        more = len(self.of) / self.done
        rays = float(np.count_nonzero(~self.of.free)) / self.asked if self.asked else more
        return self.ready_s + rays * self.cast_s + self.another_s(member)

    def another_s(self, member: _Member) -> float:
        """Seconds of a bake of another BRDF, which casts no ray."""
        return member.own_s + len(self.of) / self.done * member.made_s


def settings_of(setting: Setting) -> Any:
    """The settings of a bake with the parameters of `setting`."""
    method = method_of(setting.mode)
    return method.with_values(setting.parameters)


def _sharing(setting: Setting) -> Sharing:
    return cast(Sharing, method_of(setting.mode).baking)


def edge_of(setting: Setting) -> int:
    """Texels along an edge of the cube maps over which a setting sums visibility."""
    return _sharing(setting).edge_of(settings_of(setting))


def groups(settings: Sequence[Setting]) -> list[list[Setting]]:
    """Those settings that share rays, coarse cube maps first.

    Settings that take long beside their rays come last and by themselves.
    """
    names = [method.name for method in methods_with("shares_rays")]
    shared = [setting for setting in settings if setting.mode in names]
    kinds = sorted({_kind(setting) for setting in shared})
    return [[setting for setting in shared if _kind(setting) == kind] for kind in kinds]


def is_apart(setting: Setting) -> bool:
    """True for a setting that shares its rays with no other method's."""
    return _sharing(setting).is_apart(settings_of(setting))


def _kind(setting: Setting) -> tuple[bool, int]:
    return is_apart(setting), edge_of(setting)


def _subject(scene: Scene) -> Subject:
    return Subject(scene.mesh, scene.brdf, scene.ground)


def bake_group(
    scene: Scene,
    group: Sequence[Setting],
    seconds: float = float("inf"),
    shown: Indices | None = None,
    known: Factors | None = None,
    caster: RayCaster | None = None,
) -> Steps[tuple[list[Bake], list[LeftOut]]]:
    """The bakes of a group (see `groups`), and those settings that take too much memory or more than `seconds`.

    `shown` are the vertices, of model and ground, that images need; all of them where nothing is given. Factors of
    the BRDF are taken from `known`, and put there. How long it takes is predicted from the vertices that are
    done. Where the mesh is a part of a model, `caster` holds all that shades it.
    """
    edge = edge_of(group[0])
    members, left_out = yield from part(_prepare(scene, group, {} if known is None else known, caster), 0.0, 0.3)
    if not members:
        return [], left_out
    surface, first = members[0].work.surface, int(members[0].work.ground_vertex)
    before = time.perf_counter()
    of = receivers(surface, caster)
    rays = _Rays(of, _choose(shown, first, len(of)), time.perf_counter() - before)
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
            left_out += _drop(members, rays, done, deadline)
        if not members:
            return [], left_out
        yield Step(0.3 + 0.7 * done, f"baking {len(members)} settings on one set of rays")
    return [_finish(member, rays) for member in members], left_out


def _choose(shown: Indices | None, first: int, vertices: int) -> Indices:
    """Baked vertices, rising: of the model and of the ground at least one vertex, for the others to copy."""
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
    counts = count(of, edge, one)
    for member in members:
        member.make(one, counts)


def _drop(members: list[_Member], rays: _Rays, done: float, deadline: float) -> list[LeftOut]:
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
    return f"{what} takes about {time_text(seconds)}, for which there was no time"


def _prepare(
    scene: Scene, group: Sequence[Setting], known: Factors, caster: RayCaster | None
) -> Steps[tuple[list[_Member], list[LeftOut]]]:
    members: list[_Member] = []
    left_out: list[LeftOut] = []
    room = SHARE * free_bytes()
    for number, setting in enumerate(group):
        share = number / len(group), (number + 1) / len(group)
        try:
            work = yield from part(
                _sharing(setting).prepare_shared(_subject(scene), settings_of(setting), known), *share
            )
        except UsageError as reason:
            left_out.append(LeftOut(setting, str(reason)))
            continue
        if work.size_bytes > room:
            needs = f"it needs {size_text(work.size_bytes)} of memory, more than is free"
            left_out.append(LeftOut(setting, needs))
            continue
        room -= work.size_bytes
        if caster is not None and hasattr(work, "caster"):
            work = replace(work, caster=caster)
        before = time.perf_counter()
        make = yield from _sharing(setting).maker(work)
        members.append(_Member(setting, work, make, time.perf_counter() - before))
    return members, left_out


def _finish(member: _Member, rays: _Rays) -> Bake:
    work, before = member.work, time.perf_counter()
    some = join(member.parts[start] for start in sorted(member.parts))
    member.parts.clear()
    sharing = _sharing(member.setting)
    transport = sharing.assemble(work, _for_all(some, rays, work.ground_vertex, sharing.rows_of(work)))
    joined_s = time.perf_counter() - before
    taken_s, another_s = rays.bake_s(member) + joined_s, rays.another_s(member) + joined_s
    memory = sum(array.nbytes for array in method_of(member.setting.mode).baking.hold(transport))
    return Bake(
        member.setting,
        transport,
        taken_s,
        memory,
        method_of(member.setting.mode).estimate_file_bytes(work.size_bytes),
        _another_s(member.setting, transport, taken_s, another_s),
    )


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


def bake_alone(
    scene: Scene, setting: Setting, seconds: float = float("inf"), shown: Indices | None = None
) -> Steps[tuple[list[Bake], list[LeftOut]]]:
    """The bake of a setting in a file that is gone again, or why there is none, as `bake_group`."""
    baking = method_of(setting.mode).baking
    started = time.perf_counter()
    try:
        whole = yield from part(baking.prepare(_subject(scene), settings_of(setting)), 0.0, 0.2)
    except UsageError as reason:
        return [], [LeftOut(setting, str(reason))]
    vertices, first = len(whole.surface.positions), len(scene.mesh.positions)
    chosen = _choose(shown, first, vertices)
    work = baking.restrict(whole, chosen)
    if time.perf_counter() - started + baking.estimate_s(work) > seconds:
        return [], [LeftOut(setting, too_long(baking.estimate_s(whole)))]
    with tempfile.TemporaryDirectory(prefix="lightarc-") as folder:
        made = yield from part(baking.bake(Path(folder) / "alone", work), 0.2, 1.0)
        transport = baking.complete(made.transport, whole, chosen)
    taken_s = made.bake_s * vertices / work.vertices
    memory = sum(array.nbytes for array in baking.hold(transport))
    another_s = _another_s(setting, transport, taken_s, taken_s * (1.0 - made.visibility_s / made.bake_s))
    return [
        Bake(
            setting,
            transport,
            taken_s,
            memory,
            method_of(setting.mode).estimate_file_bytes(whole.size_bytes),
            another_s,
        )
    ], []


def _another_s(setting: Setting, transport: Any, bake_s: float, without_rays_s: float) -> float | None:
    """Seconds of a bake of another BRDF: all of it with interreflection, none where the bake takes any BRDF."""
    if not method_of(setting.mode).baking.why_baked_for_one(transport):
        return None
    return bake_s if setting.parameters.get("interreflection") else without_rays_s


def relight_transport(bake: Bake, scene: Scene) -> RelightTransport:
    """RelightTransport bake under the light of `scene`: all that has to be worked out when the light has changed."""
    method = method_of(bake.setting.mode)
    return method.baking.relight_transport(bake.transport, light_of(scene), method.light())
