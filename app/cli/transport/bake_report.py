"""Common parts of all modes of `lightarc bake`: the subject, the estimate, and the record."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from app.arguments.usage import CANCELLED, DONE
from app.cli.transport import project_input
from app.cli.transport.scene_options import mesh_of
from app.session.cache import visibility_folder
from engine.core.figure_text import size_text, time_text
from engine.core.steps import Step, Steps, drain, part
from engine.factor.factor_file import open_reflectance
from engine.geometry.backs import with_backs
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.parts import split_parts
from engine.scene.scene import brdfs_of_parts
from engine.storage.resumable import discard_unfinished, find_unfinished
from engine.transport.baking.check import BakeCheck, warnings_of_check
from engine.transport.method import Baked, Subject, Work, method_of

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.scene.material import Material

#: Share of the progress at which the bake ends and its check begins.
CHECKED_FROM = 0.95

#: Said while a bake is estimated.
COMPILING = "estimating the bake; the first one compiles its kernels"

#: The reason why some bakes have no check.
UNCHECKED = "Not compared with the reference, which shows neither parameters that vary nor effects that are left out."


def subject_of(arguments: argparse.Namespace) -> Subject:
    """The subject that the arguments name; the usual errors if they name none."""
    if project_input.is_given(arguments):
        scene = project_input.setup_of(arguments).scene
        ground = None if scene.ground is None else replace(scene.ground, cells=arguments.ground_cells)
        return make_subject(_brush(scene.mesh, arguments), scene.brdf, ground, scene.material)
    ground = None
    if arguments.ground is not None:
        ground = Ground(albedo=arguments.ground, cells=arguments.ground_cells)
    brdf = open_reflectance(arguments.brdf)
    return make_subject(_brush(mesh_of(arguments), arguments), brdf, ground, getattr(arguments, "of_parts", None))


def make_subject(mesh: Mesh, brdf: Brdf, ground: Ground | None, material: Material | None) -> Subject:
    """The subject of a bake of a model, whose parts have their BRDFs where `material` has several for them."""
    parts = brdfs_of_parts(mesh, material)
    whole = split_parts(mesh) if parts else mesh
    return Subject(with_backs(whole, ground), brdf, ground, kept=visibility_folder(), parts=parts)


def _brush(mesh: Mesh, arguments: argparse.Namespace) -> Mesh:
    return mesh if arguments.brushing is None else mesh.brush(arguments.brushing)


def carry_out(
    arguments: argparse.Namespace,
    show: Callable[[Step], None],
    work: Work,
    kind: str,
    bake: Callable[[], Steps[Any]],
    *,
    estimated_s: float,
    parameters: dict[str, Any],
    start: float,
    check: Callable[[Baked], Steps[BakeCheck | None]],
) -> tuple[Baked | None, dict[str, Any]]:
    """Report the estimate of `bake` of a `kind`, run it, and return its outcome and the record that all modes share.

    The outcome is None where it was cancelled, and the record then all that there is to say. `start` is how much of
    the progress was shown before; `check` compares the bake with the reference and keeps the result in its file.
    With --restart nothing of an earlier bake is used, and nothing is left of this one.
    """
    size = method_of(kind).estimate_file_bytes(work.size_bytes)
    expected = f"{work.vertices:,} vertices, about {size_text(size)} and {time_text(estimated_s)}"
    print(expected, file=sys.stderr, flush=True)
    parameters = {"mode": arguments.mode, "brdf": arguments.brdf, "ground_albedo": arguments.ground, **parameters}
    record = {
        "output": None,
        "vertices": work.vertices,
        "estimated_s": estimated_s,
        "size_bytes": size,
        "knobs": parameters,
    }
    if arguments.restart:
        discard_unfinished(arguments.output)
    started = time.perf_counter()
    try:
        with closing(bake()) as steps:  # an interrupted one lets go of its file here
            done: Baked = drain(part(steps, start, CHECKED_FROM), show)
    except KeyboardInterrupt:
        record |= {"bake_s": time.perf_counter() - started, "cancelled": True, "exit_code": CANCELLED}
        if arguments.restart:
            discard_unfinished(arguments.output)
        left = find_unfinished(arguments.output)
        size_bytes = left.stat().st_size if left else 0
        return None, {**record, "unfinished": str(left) if left else None, "unfinished_bytes": size_bytes}
    checked, notes = _check(done, check, show) if not arguments.no_check else (None, [])
    is_unchecked = checked is None and not notes and not arguments.no_check
    return done, {
        **record,
        "check": None if checked is None else checked.model_dump(),
        "output": arguments.output,
        "size_bytes": done.file.size_bytes,
        "faces": len(work.surface.faces),
        "bake_s": done.bake_s,
        "visibility_s": done.visibility_s,
        "skipped": [*_skip(done, work), *([UNCHECKED] if is_unchecked else [])],
        "chunks": done.chunks,
        "chunks_resumed": done.resumed_chunks,
        "warnings": [*warnings_of_check(checked, done.file.kind), *notes],
        "cancelled": False,
        "exit_code": DONE,
    }


def _check(
    done: Baked, check: Callable[[Baked], Steps[BakeCheck | None]], show: Callable[[Step], None]
) -> tuple[BakeCheck | None, list[str]]:
    """The check of a bake, which may be interrupted: the bake itself is complete, and the notes say so."""
    try:
        with closing(check(done)) as steps:
            return drain(part(steps, CHECKED_FROM, 1.0), show), []
    except KeyboardInterrupt:
        return None, ["the bake is complete, but its check against the reference was cancelled"]


def _skip(done: Baked, work: Work) -> list[str]:
    """The vertices that needed no rays, and the reason."""
    if not done.unoccluded_vertices:
        return []
    return [
        f"No rays for {done.unoccluded_vertices:,} of {work.vertices:,} vertices, which see their whole hemisphere."
    ]
