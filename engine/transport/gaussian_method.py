"""Gaussians as one of the transport methods (`engine.transport.method.Baking`)."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.errors import UsageError
from engine.core.figure_text import count_text, percent, size_text
from engine.core.steps import Step, Steps
from engine.geometry.mesh import Mesh
from engine.light.cube_map import cube_of
from engine.light.environment import EnvironmentMap
from engine.transport.baking.file import TransportFile
from engine.transport.baking.parts import kinds_of, refuse_another_brdf
from engine.transport.baking.radiance_error import error_lines
from engine.transport.baking.settings import ERROR_VERTICES, GaussianSettings
from engine.transport.baking.visibility import Receivers
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.gaussian.fitting.lobes import Lobes
from engine.transport.gaussian.fitting.views import VIEWS
from engine.transport.gaussian.lighting import filter_for, levels_under
from engine.transport.gaussian.samples import GlossySurface, model_on_ground
from engine.transport.gaussian.transfer import GaussianTransport, radiance_towards
from engine.transport.method import Relight, Subject
from engine.transport.relight import Illuminated, Light, RelightGaussians, relight_gaussians

Indices = NDArray[np.int64]

#: Edge of the cube map that errors are measured under.
ERROR_EDGE = 64

bake, estimate_s = gaussian_bake.bake, gaussian_bake.estimate_s
transport_of, casts_rays = gaussian_bake.transport_of, gaussian_bake.casts_rays


def bake_settings(settings: GaussianSettings) -> gaussian_bake.BakeSettings:
    """Settings of the bake; ValueError for impossible ones."""
    return gaussian_bake.BakeSettings(
        lobes=settings.lobes,
        indirect=bool(settings.interreflection),
        samples=settings.samples,
        order=settings.order,
        edge=settings.cube or gaussian_bake.EDGE,
        fine=settings.fine,
        weights=settings.weights,
        compress=settings.compress,
    )


def prepare(
    subject: Subject, settings: GaussianSettings, tested: EnvironmentMap | None = None
) -> Steps[gaussian_bake.Work]:
    """Fit some vertices and lay the bake out; weights are judged under `tested`, or in the studio."""
    asked, varied = bake_settings(settings), subject.variations
    environment = None if tested is None else (tested.name, cube_of(tested, ERROR_EDGE))
    probes = gaussian_bake.PROBES if tested is None else ERROR_VERTICES
    mesh, ground = subject.mesh, subject.ground
    kinds = kinds_of(mesh, subject.parts)
    steps = gaussian_bake.prepare(mesh, subject.brdf, asked, ground, varied, environment, probes, subject.kept, kinds)
    return (yield from steps)


def again(file: TransportFile, brdf: Brdf, kept: Path | None) -> Steps[gaussian_bake.Work]:
    """The bake in `file` with another BRDF; UsageError where parameters vary over the model."""
    yield Step(0.0, "looking at the BRDF")
    before = transport_of(file)
    refuse_another_brdf(file)
    if file.settings["variations"]:
        raise UsageError(f"parameters of the BRDF of {file.path} vary over the model; bake again with another")
    names = gaussian_bake.BakeSettings.__dataclass_fields__
    settings = gaussian_bake.BakeSettings(**{name: file.settings[name] for name in names})
    model = model_on_ground(file.mesh, before.ground_vertex, before.ground_albedo, brdf, {})
    return (yield from gaussian_bake.lay_out(model, settings, kept=kept))


def parameters(work: gaussian_bake.Work, _settings: GaussianSettings) -> dict[str, Any]:
    """The settings of a bake as its record states them."""
    settings = work.settings
    return {
        "lobes": settings.lobes,
        "indirect": settings.indirect,
        "views": VIEWS,
        "samples": settings.samples,
        "order": settings.order,
        "cube": settings.edge,
        "fine": settings.fine,
        "weights": settings.weights,
        "compress": settings.compress,
    }


def measure(
    work: gaussian_bake.Work,
    _subject: Subject,
    _settings: GaussianSettings,
    _tested: EnvironmentMap | None,
    _vertices: int = ERROR_VERTICES,
) -> Steps[dict[str, Any]]:
    """Errors by either way to weigh, which `prepare` has measured, and which way was taken for direct light."""
    yield Step(1.0, "comparing with the sum over all texels")
    error, taken = work.error, work.weights[0]
    return {
        "error_env": work.tested,
        "error_rmse_rel": error.of(taken),
        "error_mean_rel": error.mean_of(taken),
        "error_plain_rmse_rel": error.plain_rmse_rel,
        "error_preserving_rmse_rel": error.preserving_rmse_rel,
        "error_glossy_plain_rmse_rel": error.glossy_plain_rmse_rel,
        "error_glossy_preserving_rmse_rel": error.glossy_preserving_rmse_rel,
        "error_pairs": error.pairs,
        "weights_taken": taken,
    }


def figures(work: gaussian_bake.Work, baked: gaussian_bake.Baked, _prepared_s: float) -> dict[str, Any]:
    """Figures of the fit, and the size that compression has brought."""
    flipped = baked.figures.get("direct_flipped_pairs", 0.0)
    words = [f"{count_text(flipped)} pairs of neighbours disagree on which Gaussian is which."] if flipped else []
    alone = "No light between parts of the model; --indirect adds it."
    return {
        "matt_s": baked.diffuse_s,
        **baked.figures,
        "skipped": [] if work.settings.indirect else [alone],
        "warnings": words,
    }


def lines(result: dict[str, Any]) -> list[str]:
    """The errors and the size in sentences."""
    words = {"plain": "nearest to the highlights", "preserving": "with all their energy"}
    plain, preserving = (percent(result[f"error_{name}_rmse_rel"], 3) for name in words)
    found = [
        *error_lines(result),
        f"Gaussians {words[result['weights_taken']]}: error {plain} plain, {preserving} with all energy; "
        f"off the highlights themselves by {percent(result['direct_error_rel_mean'])} on average, "
        f"{percent(result['direct_error_rel_worst'])} for the worst hundredth",
    ]
    if "compressed_bytes" in result:
        before, after = (size_text(result[name]) for name in ("uncompressed_bytes", "compressed_bytes"))
        found.append(
            f"Gaussians take {after} instead of {before}, which changes the radiance by "
            f"{percent(result['compression_error_rel'])}"
        )
    return found


def relight_transport(transport: GaussianTransport, light: Light, _asked: object) -> RelightGaussians:
    """The filtered light beside the lobes, and the diffuse part under it."""
    return relight_gaussians(
        transport, light.environment, rotation=light.rotation, factor=light.factor, lamps=light.lamps
    )


def relighter(transport: GaussianTransport, _subject: Subject) -> Relight:
    """The same, with everything that drawing would otherwise wait for."""

    def relight(light: Light, asked: Any, _wanted: Brdf) -> Steps[RelightGaussians]:
        yield Step(0.0, "relighting")
        found = relight_transport(transport, light, asked)
        found.transport.texels.flags.writeable = False
        found.light.atlas.texels.flags.writeable = False
        return found

    return relight


def why_baked_for_one(_transport: GaussianTransport) -> str:
    """The lobes are those of the BRDF."""
    return "The bake is of another BRDF; Gaussians are baked for one."


def illuminate(file: TransportFile, light: Light, _asked: object, _brdf: str | None) -> Steps[Illuminated]:
    """The lobes of `file` under `light`."""
    transport = transport_of(file)
    yield Step(0.0, "filtering the light")
    before = time.perf_counter()
    reported: dict[str, Any] = {}
    if light.environment is not None:
        levels = levels_under(light.environment, transport.sigma_range)
        filter_for(light.environment, levels)
        reported = {"light_cube": levels.edge, "light_levels": len(levels.sigma)}
    filtered = time.perf_counter()
    found = relight_transport(transport, light, None)
    reported |= {
        "brdf": transport.brdf,
        "lobes": transport.lobes,
        "indirect": len(transport.components) > 1,
        "light_s": filtered - before,
        "relight_s": time.perf_counter() - filtered,
    }
    return Illuminated(
        found,
        reported,
        lambda eye: _negative_rel(radiance_towards(transport, found.light, found.diffuse, eye)),
        "bake the diffuse part with a higher --order",
    )


def _negative_rel(radiance: NDArray[np.float64]) -> float:
    """Radiance below 0 as a fraction of the radiance above."""
    kept = float(radiance.clip(0.0).sum())
    return float((-radiance).clip(0.0).sum()) / kept if kept > 0.0 else 0.0


def restrict(work: gaussian_bake.Work, chosen: Indices) -> gaussian_bake.Work:
    """Work for `chosen` vertices alone; all are baked with interreflection, because they light each other."""
    if work.settings.indirect or len(chosen) == work.vertices:
        return work
    return replace(work, model=_only(work.model, chosen))


def complete(transport: GaussianTransport, work: gaussian_bake.Work, chosen: Indices) -> GaussianTransport:
    """The lobes of all vertices."""
    everything = np.arange(work.vertices)
    return _expand_to_all(
        transport, work.surface, work.model.ground_vertex, everything if work.settings.indirect else chosen
    )


def hold(transport: GaussianTransport) -> list[NDArray[Any]]:
    """The lobes, and the rows of the diffuse part."""
    lobes = [array for of in transport.components for array in (of.weight, of.mean, of.sigma)]
    return [*lobes, *([] if transport.diffuse is None else [transport.diffuse.rows])]


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
            part=None,
            colours=None,
        ),
        ground_vertex=len(of_model),
        varied={name: values[of_model] for name, values in model.varied.items()},
        kinds=None if model.kinds is None else model.kinds.choose(of_model),
        of=Receivers(of.caster, of.origin[chosen], of.normal[chosen], of.free[chosen]),
        frames=model.frames[chosen],
    )


def _expand_to_all(some: GaussianTransport, surface: Mesh, first: int, chosen: Indices) -> GaussianTransport:
    """Lobes of the `chosen` vertices as those of all of `surface`, in memory."""
    copied = np.searchsorted(chosen, np.arange(len(surface.positions)), side="right") - 1
    components = tuple(
        Lobes(lobes.weight[copied[:first]], lobes.mean[copied[:first]], lobes.sigma[copied[:first]])
        for lobes in some.components
    )
    diffuse = some.diffuse
    if diffuse is not None:
        diffuse = replace(diffuse, mesh=surface, ground_vertex=first, rows=diffuse.rows[copied])
    return replace(some, mesh=surface, ground_vertex=first, components=components, diffuse=diffuse)
