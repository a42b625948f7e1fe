"""What all modes of `lightarc bake` have in common: what is baked, saying how much it will take, and the record."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

from engine.steps import Step, Steps, drain, part

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.cube_map import CubeMap
    from engine.ground import Ground
    from engine.mesh import Mesh
    from engine.transport.radiance_error import RadianceError


class Work(Protocol):
    """A bake that is ready to begin, of whatever mode."""

    @property
    def surface(self) -> Mesh: ...
    @property
    def vertices(self) -> int: ...
    @property
    def size_bytes(self) -> int: ...


class Outcome(Protocol):
    """A bake that is done, of whatever mode; `visibility_s` is part of `bake_s`."""

    @property
    def bake_s(self) -> float: ...
    @property
    def visibility_s(self) -> float: ...
    @property
    def chunks(self) -> int: ...
    @property
    def resumed_chunks(self) -> int: ...
    @property
    def free_vertices(self) -> int: ...


Done = TypeVar("Done", bound=Outcome)


@dataclass(frozen=True, eq=False)
class Subject:
    """What is baked."""

    mesh: Mesh
    brdf: Brdf
    ground: Ground | None


def subject_of(arguments: argparse.Namespace) -> Subject:
    """What the arguments name; the usual errors where they name nothing."""
    from app.cli import usage
    from engine.factor.factor_file import open_reflectance
    from engine.ground import Ground
    from engine.shapes import open_mesh

    ground = None
    if arguments.ground is not None:
        ground = usage(lambda: Ground(albedo=arguments.ground, cells=arguments.ground_cells))
    return Subject(brdf=usage(open_reflectance, arguments.brdf), mesh=open_mesh(arguments.mesh), ground=ground)


def carry_out(
    arguments: argparse.Namespace,
    show: Callable[[Step], None],
    work: Work,
    bake: Callable[[], Steps[Done]],
    *,
    estimated_s: float,
    knobs: dict[str, Any],
    start: float,
) -> tuple[Done | None, dict[str, Any]]:
    """Say what `bake` will take, run it, and return its outcome and the record that all modes share.

    The outcome is None where it was cancelled, and the record then all that there is to say. `start` is how much of
    the progress was shown before. With --restart nothing of an earlier bake is used, and nothing is left of this one.
    """
    from app.cli import CANCELLED, DONE
    from engine.files.atomic import discard_unfinished, unfinished

    expected = f"{work.vertices:,} vertices, {work.size_bytes / 1e6:.1f} MB, about {words_of_time(estimated_s)}"
    print(expected, file=sys.stderr, flush=True)
    knobs = {"mode": arguments.mode, "brdf": arguments.brdf, "ground_albedo": arguments.ground, **knobs}
    record = {
        "output": None,
        "vertices": work.vertices,
        "estimated_s": estimated_s,
        "size_bytes": work.size_bytes,
        "knobs": knobs,
    }
    if arguments.restart:
        discard_unfinished(arguments.output)
    started = time.perf_counter()
    try:
        done = drain(part(bake(), start, 1.0), show)
    except KeyboardInterrupt:
        record |= {"bake_s": time.perf_counter() - started, "cancelled": True, "exit_code": CANCELLED}
        if arguments.restart:
            discard_unfinished(arguments.output)
        left = unfinished(arguments.output)
        size_bytes = left.stat().st_size if left else 0
        return None, {**record, "unfinished": str(left) if left else None, "unfinished_bytes": size_bytes}
    return done, {
        **record,
        "output": arguments.output,
        "faces": len(work.surface.faces),
        "bake_s": done.bake_s,
        "visibility_s": done.visibility_s,
        "skipped": _skipped(done, work),
        "chunks": done.chunks,
        "chunks_resumed": done.resumed_chunks,
        "warnings": [],
        "cancelled": False,
        "exit_code": DONE,
    }


def error_under(
    name: str | None, edge: int, measure: Callable[[CubeMap], Steps[RadianceError]], show: Callable[[Step], None]
) -> dict[str, Any]:
    """The record of the error under the environment `name`, as a cube map of `edge`; nothing where none is named."""
    from engine.cube_map import cube_of
    from engine.environment_file import open_environment

    if name is None:
        return {}
    environment = open_environment(name)
    found = drain(measure(cube_of(environment, edge)), show)
    return {
        "error_env": environment.name,
        "error_rmse_rel": found.rmse_rel,
        "error_mean_rel": found.mean_rel,
        "error_negative_rel": found.negative_rel,
        "error_pairs": found.pairs,
    }


def error_lines(result: dict[str, Any]) -> list[str]:
    """What there is to say of the error, where it was measured."""
    if "error_rmse_rel" not in result:
        return []
    mean = result.get("error_mean_rel", 0.0)
    brighter = f"; {100.0 * abs(mean):.1f} % {'brighter' if mean > 0.0 else 'darker'} in the mean"
    return [
        f"error under {result['error_env']}: {100.0 * result['error_rmse_rel']:.1f} % of the radiance "
        f"(RMS, {result['error_pairs']:,} pairs of vertex and view){brighter if abs(mean) >= 1e-3 else ''}"
    ]


def words_of_time(seconds: float) -> str:
    return f"{seconds:.1f} s" if seconds < 120.0 else f"{seconds / 60.0:.1f} min"


def _skipped(done: Outcome, work: Work) -> list[str]:
    """What needed no rays, and why."""
    if not done.free_vertices:
        return []
    return [f"No rays for {done.free_vertices:,} of {work.vertices:,} vertices, which see their whole hemisphere."]
