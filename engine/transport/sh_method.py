"""Spherical harmonics as one of the transport methods (`engine.transport.method.Baking`)."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.core.steps import Steps, part
from engine.factor.factor_file import open_reflectance
from engine.geometry.camera import Vector
from engine.light.environment import EnvironmentMap
from engine.transport.baking.file import TransportFile
from engine.transport.baking.parts import kinds_of, refuse_another_brdf
from engine.transport.baking.radiance_error import error_lines, error_record, rounding_lines
from engine.transport.baking.settings import BOUNCES, ERROR_VERTICES, ShLight, ShSettings
from engine.transport.baking.spatially_varying import variation_from_text, variation_to_text
from engine.transport.baking.visibility import Receivers, receivers
from engine.transport.method import Relight, Subject
from engine.transport.relight import Illuminated, Light, RelightSh
from engine.transport.sh import bake as sh_bake
from engine.transport.sh.basis import apply_window, window
from engine.transport.sh.brdf_table_varying import VariedTable, table_of, tables_of
from engine.transport.sh.error import sh_error
from engine.transport.sh.lighting import lamp_coefficients, project, turn_about_y
from engine.transport.sh.near_light import TOLERANCE, near_light
from engine.transport.sh.transfer import (
    ShTransport,
    local_views,
    rounding_error_rel,
    sum_signed_radiance,
    transfer,
    with_table,
)
from engine.transport.shared_rays import Make

estimate_s, transport_of, casts_rays = sh_bake.estimate_s, sh_bake.transport_of, sh_bake.casts_rays


def bake_settings(settings: ShSettings, *, shadows: bool = True) -> sh_bake.BakeSettings:
    """Settings of the bake; UsageError for impossible ones."""
    edge = settings.cube or sh_bake.default_edge(settings.order)
    bounces = BOUNCES if settings.interreflection else 0
    return sh_bake.BakeSettings(settings.order, edge, settings.fine, bounces, shadows=shadows)


def prepare(subject: Subject, settings: ShSettings, _tested: EnvironmentMap | None = None) -> Steps[sh_bake.Work]:
    """Tabulate the BRDF and lay the bake out."""
    mesh, ground, variations = subject.mesh, subject.ground, subject.variations
    kinds = kinds_of(mesh, subject.parts)
    work = yield from sh_bake.prepare(mesh, subject.brdf, bake_settings(settings), ground, variations, kinds)
    return replace(work, kept=subject.kept)


def again(file: TransportFile, brdf: Brdf, kept: Path | None) -> Steps[sh_bake.Work]:
    """The bake in `file` with another BRDF; UsageError where parameters vary over the model."""
    before = transport_of(file)
    refuse_another_brdf(file)
    if file.settings.get("variations"):
        raise UsageError(f"parameters of the BRDF of {file.path} vary over the model; bake again with another")
    settings = sh_bake.BakeSettings(**{name: file.settings[name] for name in sh_bake.BakeSettings.__dataclass_fields__})
    table = yield from table_of(brdf, settings.order, (), file.mesh)
    work = sh_bake.lay_out(file.mesh, before.ground_vertex, before.ground_albedo, brdf, table, settings)
    return replace(work, kept=kept)


def bake(path: str | os.PathLike[str], work: sh_bake.Work, cluster: str | None = None) -> Steps[sh_bake.Baked]:
    """`sh.bake.bake`."""
    return (yield from sh_bake.bake(path, work, cluster=cluster))


def parameters(work: sh_bake.Work, _settings: ShSettings) -> dict[str, Any]:
    """The settings of a bake as its record states them."""
    settings = work.settings
    return {
        "order": settings.order,
        "cube": settings.edge,
        "fine": settings.fine,
        "bounces": settings.bounces,
        "gather": settings.gather,
    }


def measure(
    work: sh_bake.Work,
    subject: Subject,
    _settings: ShSettings,
    tested: EnvironmentMap | None,
    vertices: int = ERROR_VERTICES,
) -> Steps[dict[str, Any]]:
    """The error of the vertices under `tested` (`sh_error`)."""
    of, varied, kinds = subject.brdf, subject.variations, kinds_of(subject.mesh, subject.parts)
    measure = lambda cube: sh_error(work, of, cube, variations=varied, kinds=kinds, vertices=vertices)  # noqa: E731
    return (yield from error_record(tested, work.settings.edge, measure))


def figures(work: sh_bake.Work, baked: sh_bake.Baked, prepared_s: float) -> dict[str, Any]:
    """Seconds and errors of the tables, and what was left out."""
    skipped = []
    if work.table.diffuse:
        skipped.append("No matrices: a diffuse model looks the same from every side, and a vector does.")
    if not work.settings.bounces:
        skipped.append("No light between parts of the model; --interreflection adds it.")
    warnings = list(work.table.health.warnings)
    if work.settings.bounces and not work.table.diffuse:
        warnings.append("Light between parts of the model counts as reflected evenly to all sides until the last time.")
    return {
        "bounce_s": baked.bounce_s,
        "table_s": prepared_s,
        "table_error_rel": work.table.error_rel,
        "rounding_error_rel": rounding_error(baked.file),
        **_vary(work),
        "stored": "vectors" if work.table.diffuse else "matrices",
        "skipped": skipped,
        "warnings": warnings,
    }


def _vary(work: sh_bake.Work) -> dict[str, Any]:
    """Numbers of the tables of a BRDF that varies, and the error of interpolation between them."""
    if not isinstance(work.table, VariedTable) or not work.plan.header.settings["variations"]:
        return {}
    return {"tables": [len(some) for some in work.table.nodes], "interpolation_rel": work.table.interpolation_rel}


def lines(result: dict[str, Any]) -> list[str]:
    """The error and the tables in sentences."""
    found = [*error_lines(result), *rounding_lines(result)]
    if "tables" in result:
        grid = " × ".join(map(str, result["tables"]))
        found.append(
            f"the reflectance varies over {grid} tables; between them it is off by up to "
            f"{percent(result['interpolation_rel'], 3)}"
        )
    return found


def relight_transport(transport: ShTransport, light: Light, asked: ShLight) -> RelightSh:
    """The coefficients of the light, times the transport."""
    coefficients, _ = _coefficients_at(transport, light, asked)
    return RelightSh(transport, transfer(transport, coefficients))


def relighter(transport: ShTransport, subject: Subject) -> Relight:
    """The same; the table of the last BRDF is kept."""
    baked = subject.brdf, tuple(map(variation_to_text, subject.variations))
    last = baked, transport

    def relight(light: Light, asked: ShLight, brdf: Brdf) -> Steps[RelightSh]:
        nonlocal last
        wanted = brdf, asked.vary
        if wanted == baked or subject.parts:
            last = baked, transport
        elif wanted != last[0]:
            last = wanted, (yield from _with_brdf(transport, brdf, asked))
        last[1].mesh.tangents.flags.writeable = False  # drawing would otherwise wait for them
        return relight_transport(last[1], light, asked)

    return relight


def why_baked_for_one(transport: ShTransport) -> str:
    """Interreflection is of one BRDF, and what was baked of a diffuse one holds nothing of the view."""
    if transport.interreflection:
        return "The bake is of another BRDF; interreflection is baked for one."
    return "A diffuse model was baked, which holds nothing of the view." if transport.diffuse else ""


def illuminate(file: TransportFile, light: Light, asked: ShLight, brdf: str | None) -> Steps[Illuminated]:
    """The rows of `file` under `light`, with another BRDF, or one that varies, where that is asked for."""
    transport = transport_of(file)
    named = brdf or str(file.settings["brdf"])
    if brdf or asked.vary:
        transport = yield from part(_with_brdf(transport, open_reflectance(named), asked), 0.0, 0.3)
    before = time.perf_counter()
    coefficients, reported = _coefficients_at(transport, light, asked)
    projected = time.perf_counter()
    rows = transfer(transport, coefficients)
    reported |= {
        "brdf": named,
        "order": transport.order,
        "interreflection": transport.interreflection,
        "table_error_rel": transport.table.error_rel,
        "rounding_error_rel": rounding_error(file),
        "light_s": projected - before,
        "relight_s": time.perf_counter() - projected,
    }
    return Illuminated(
        RelightSh(transport, rows),
        reported,
        lambda eye: _negative_rel(transport, rows, eye),
        "a higher order or --window rings less",
        _warnings(reported),
    )


def rounding_error(file: TransportFile) -> float:
    """The error of matrices by the step that they were rounded to, which vectors and older files do not have."""
    step = 0.0 if file.settings["diffuse"] else float(file.settings.get("step", 0.0))
    return rounding_error_rel(file.arrays["rows"], step)


def _coefficients_at(
    transport: ShTransport, light: Light, asked: ShLight
) -> tuple[NDArray[np.floating[Any]], dict[str, Any]]:
    """Of all light, the same for all vertices (order², 3) or at each of them (V, order², 3), and figures of it."""
    coefficients: Any = apply_window(_coefficients(light, transport.order), asked.window)
    nearby, reported = _nearby(transport, light, asked.near_points)
    if nearby is not None:
        coefficients = coefficients + nearby * window(transport.order, asked.window)[:, None]
    return coefficients, reported


def _coefficients(light: Light, order: int) -> NDArray[np.float64]:
    """(order², 3) of a rotated environment, and of lamps in closed form."""
    total = np.zeros((order**2, 3))
    if light.environment is not None:
        total += light.factor * turn_about_y(project(light.environment, order), light.rotation)
    return np.asarray(total + sum(lamp_coefficients(lamp, order) for lamp in light.lamps))


def _nearby(
    transport: ShTransport, light: Light, points: int | None
) -> tuple[NDArray[np.float32] | None, dict[str, Any]]:
    """(V, order², 3) of near lamps, and how they were found: by a grid about the model and one on the ground."""
    if not light.near_lamps:
        if points is not None:
            raise UsageError("--near-points needs --near-lamp")
        return None, {}
    places, first = transport.mesh.positions, transport.ground_vertex
    found = [near_light(light.near_lamps, some, transport.order, points) for some in (places[:first], places[first:])]
    counts = [some.points for some in found if len(some.coefficients)]
    reported = {"near_points": counts, "near_error_rel": max(some.error_rel for some in found)}
    return np.concatenate([some.coefficients for some in found]), reported


def _warnings(reported: dict[str, Any]) -> tuple[str, ...]:
    error = reported.get("near_error_rel", 0.0)
    if error <= 1.5 * TOLERANCE:
        return ()
    return (f"Between the points where it was found, the light of near lamps is off by {percent(error, 3)} RMS.",)


def _with_brdf(transport: ShTransport, brdf: Brdf, asked: ShLight) -> Steps[ShTransport]:
    """The transport with another BRDF, which varies where that is `asked`."""
    variations = [variation_from_text(each) for each in asked.vary]
    table = yield from table_of(brdf, transport.order, variations, transport.mesh, transport.ground_vertex)
    try:
        return with_table(transport, table)
    except UsageError as reason:
        raise UsageError(f"The BRDF cannot be changed without another bake: {reason}") from None


def _negative_rel(transport: ShTransport, rows: NDArray[np.float32], eye: Vector) -> float:
    """Radiance of the vertices below 0 towards `eye`, as a fraction of the radiance above."""
    everything = np.arange(len(transport.mesh.positions))
    signed = sum_signed_radiance(transport, rows, local_views(transport, eye), everything)
    kept = float(np.maximum(signed, 0.0).sum())
    return float(np.maximum(-signed, 0.0).sum()) / kept if kept > 0.0 else 0.0


def restrict(work: sh_bake.Work, _chosen: NDArray[np.int64]) -> sh_bake.Work:
    """All of it: where few vertices are wanted, rays are shared."""
    return work


def complete(transport: ShTransport, _work: sh_bake.Work, _chosen: NDArray[np.int64]) -> ShTransport:
    """It is complete."""
    return transport


def hold(transport: ShTransport) -> list[NDArray[Any]]:
    """The table and the rows."""
    return [*(table.values for table in tables_of(transport.table)), transport.rows]


#: Orders up to this share their rays with other methods.
HIGH = 8


def edge_of(settings: ShSettings) -> int:
    """That of the order, where no other is asked for."""
    return settings.cube or sh_bake.default_edge(settings.order)


def is_apart(settings: ShSettings) -> bool:
    """Matrices of high orders take longer than all the rest."""
    return settings.order > HIGH


def prepare_shared(subject: Subject, settings: ShSettings, _known: dict[Any, Any]) -> Steps[sh_bake.Work]:
    """Nothing outlives a setting."""
    return (yield from prepare(subject, settings))


def maker(work: sh_bake.Work) -> Steps[Make]:
    """Makes matrices or vectors, after light between parts of the model has been followed."""
    of: Receivers = receivers(work.surface, work.caster)
    sent = (yield from sh_bake.reflect(work, of)) if work.settings.bounces else None
    baker = sh_bake.baker_of(work, of, sent)
    return lambda vertices, counts: {"rows": baker.rows(vertices, counts)}


def rows_of(work: sh_bake.Work) -> int:
    """A vector has one, a matrix as many as there are coefficients."""
    return 1 if work.table.diffuse else work.table.order**2


def assemble(work: sh_bake.Work, arrays: Mapping[str, NDArray[Any]]) -> ShTransport:
    """The rows with their table."""
    table, bounces = work.table, bool(work.settings.bounces)
    first, albedo = work.ground_vertex, work.ground_albedo
    return ShTransport(work.surface, first, table.diffuse, albedo, table, bounces, arrays["rows"])
