"""Wavelets as one of the transport methods (`engine.transport.method.Baking`)."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import Brdf
from engine.core.errors import UsageError
from engine.core.figure_text import count_text, percent
from engine.core.steps import Step, Steps, drain, part
from engine.factor.factor_file import open_reflectance
from engine.factor.separable_factors import SeparableFactors
from engine.light.environment import EnvironmentMap
from engine.transport.baking.blend import blend_from_text, mixture, pad, together
from engine.transport.baking.file import TransportFile
from engine.transport.baking.occluder import occluder_error
from engine.transport.baking.parts import kinds_of, refuse_another_brdf
from engine.transport.baking.radiance_error import error_lines, error_record, rounding_lines
from engine.transport.baking.settings import BOUNCES, ERROR_VERTICES, WaveletLight, WaveletSettings
from engine.transport.method import Relight, Subject
from engine.transport.relight import Illuminated, Light, RelightWavelets
from engine.transport.shared_rays import Make, wavelet_maker
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.error import best_terms, wavelet_error
from engine.transport.wavelet.lighting import Lighting, dark, lighting_of, tuples
from engine.transport.wavelet.quantise import rounding_error_rel
from engine.transport.wavelet.relight import Relighter
from engine.transport.wavelet.transfer import WaveletTransport, radiance_from, remix, vectors_of

estimate_s, bake, transport_of = wavelet_bake.estimate_s, wavelet_bake.bake, wavelet_bake.transport_of
casts_rays = wavelet_bake.casts_rays


def bake_settings(settings: WaveletSettings) -> wavelet_bake.BakeSettings:
    """Settings of the bake; ValueError for impossible ones."""
    bounces = BOUNCES if settings.interreflection else 0
    return wavelet_bake.BakeSettings(
        settings.cube, settings.coefficients, settings.fine, settings.occluder_cells, bounces
    )


def prepare(
    subject: Subject, settings: WaveletSettings, tested: EnvironmentMap | None = None
) -> Steps[wavelet_bake.Work]:
    """Factor the BRDFs and lay the bake out, without terms that make the error under `tested` larger."""
    asked, kinds = bake_settings(settings), kinds_of(subject.mesh, subject.parts)
    if kinds is not None and (settings.blend or settings.albedo):
        raise UsageError("--blend and --albedo are for a model of one BRDF; choose one with --material FILE#NAME")
    brdfs, sources = _brdfs(subject.brdf, settings) if kinds is None else (list(kinds.brdfs), [])
    yield Step(0.0, "factoring the BRDF")
    bases = []
    for number, brdf in enumerate(brdfs):
        steps = wavelet_bake.factors_for(
            brdf, settings.terms, kind=settings.map, weighting=settings.weighting, signs=settings.signs
        )
        base = yield from part(steps, number / len(brdfs), (number + 1) / len(brdfs))
        if tested is not None:
            base = base.truncate((yield from part(best_terms(base, brdf, tested), 1.0, 1.0)))
        bases.append(base)
    mixed = None
    if settings.blend or settings.albedo:
        mixed = mixture(subject.mesh, [each.terms for each in bases], sources, settings.albedo)
    most = max(base.terms for base in bases)
    factors = together([base if kinds is None else pad(base, most) for base in bases])
    work = wavelet_bake.prepare(subject.mesh, factors, asked, subject.ground, mixed, kinds)
    return replace(work, kept=subject.kept)


def again(file: TransportFile, brdf: Brdf, kept: Path | None) -> Steps[wavelet_bake.Work]:
    """The bake in `file` with another BRDF; UsageError where several were mixed."""
    before = transport_of(file)
    refuse_another_brdf(file)
    if before.mixture is not None:
        raise UsageError(f"{file.path} mixes several BRDFs; bake again with other ones")
    named = {name: file.settings.get(name, value) for name, value in asdict(wavelet_bake.BakeSettings()).items()}
    settings = wavelet_bake.BakeSettings(**named)
    yield Step(0.0, "factoring the BRDF")
    kind = before.factors.hemisphere_map.kind
    terms = max(before.factors.terms, WaveletSettings.terms)
    factors = yield from wavelet_bake.factors_for(brdf, terms, kind=kind)
    albedo = before.ground_albedo
    return replace(wavelet_bake.lay_out(file.mesh, before.ground_vertex, factors, settings, albedo), kept=kept)


def _brdfs(brdf: Brdf, settings: WaveletSettings) -> tuple[list[Brdf], list[str]]:
    """All BRDFs of a mixture, and the sources of the weights of all but the first."""
    blends = [blend_from_text(text) for text in settings.blend]
    return [brdf, *(open_reflectance(text) for text, _ in blends)], [source for _, source in blends]


def parameters(work: wavelet_bake.Work, settings: WaveletSettings) -> dict[str, Any]:
    """The settings of a bake as its record states them."""
    return {
        "terms": work.terms,
        "bounces": work.settings.bounces,
        "cube": work.settings.edge,
        "coefficients": work.settings.coefficients,
        "fine": work.settings.fine,
        "occluder_cells": work.settings.occluder_cells,
        "map": work.factors.hemisphere_map.kind,
        "weighting": settings.weighting,
        "signs": settings.signs,
        "blend": list(settings.blend),
        "albedo": settings.albedo,
    }


def measure(
    work: wavelet_bake.Work,
    subject: Subject,
    settings: WaveletSettings,
    tested: EnvironmentMap | None,
    vertices: int = ERROR_VERTICES,
) -> Steps[dict[str, Any]]:
    """The error of the vertices under `tested` (`wavelet_error`) and of a simplified occluder, and terms left out."""
    brdfs = [] if tested is None else work.kinds.brdfs if work.kinds else _brdfs(subject.brdf, settings)[0]
    measure = lambda cube: wavelet_error(work, brdfs, cube.radiance, vertices=vertices)  # noqa: E731
    found = yield from error_record(tested, work.settings.edge, measure)
    asked = subject.brdf.terms if isinstance(subject.brdf, SeparableFactors) else settings.terms
    left_out = max(0, asked - work.terms)
    return {**found, "terms_not_stored": left_out, **(_occluder(work) if work.settings.occluder_cells else {})}


def _occluder(work: wavelet_bake.Work) -> dict[str, Any]:
    """Costs and savings of the simplified occluder, at some vertices."""
    vertices = np.unique(np.linspace(0, work.ground_vertex - 1, 200).astype(int))
    found = occluder_error(work.surface, work.occluder, work.settings.edge, vertices)
    return {
        "occluder_faces": found.faces,
        "occluder_open_rms": found.open_rms,
        "occluder_time_rel": found.time_rel,
    }


def figures(_work: wavelet_bake.Work, baked: wavelet_bake.Baked, _prepared_s: float) -> dict[str, Any]:
    """Number of vectors, and of their coefficients."""
    return {
        "vectors": baked.transport.rows,
        "coefficients_kept_mean": float(baked.transport.vectors.counts.mean()),
        "rounding_error_rel": rounding_error(baked.file),
        "skipped": []
        if baked.transport.bounces is not None
        else ["No light between parts of the model; --interreflection adds it."],
        "warnings": [],
    }


def rounding_error(file: TransportFile) -> float:
    """The error of coefficients by the step that they were rounded to, which older files do not state."""
    return rounding_error_rel(file.arrays["words"], file.arrays["peaks"], int(file.settings.get("step", 1)))


def lines(result: dict[str, Any]) -> list[str]:
    """The errors in sentences."""
    found = [*error_lines(result), *rounding_lines(result)]
    left_out = result.get("terms_not_stored", 0)
    if "error_rmse_rel" in result and result["knobs"].get("bounces"):
        found.append("errors of vertices are those of direct light: interreflection is compared in the check alone")
    if left_out:
        asked = left_out + result["knobs"]["terms"]
        found.append(f"{left_out} of the {asked} terms are not stored: they make no image better")
    if "occluder_faces" in result:
        found.append(
            f"shadows from {count_text(result['occluder_faces'])} triangles: the open share of the sky is off by "
            f"{percent(result['occluder_open_rms'])} RMS, rays take {result['occluder_time_rel']:.2f} of the time"
        )
    return found


def relight_transport(transport: WaveletTransport, light: Light, _asked: WaveletLight) -> RelightWavelets:
    """The light in wavelets, times the transport."""
    return RelightWavelets(transport, tuples(transport, _lighting(transport, light)))


def relighter(transport: WaveletTransport, _subject: Subject) -> Relight:
    """The same, where what is the same under the next light is kept, and the last mixture."""
    kept, last = Relighter(transport), (WaveletLight(), transport)

    def relight(light: Light, asked: WaveletLight, _wanted: Brdf) -> Steps[RelightWavelets]:
        nonlocal kept, last
        yield Step(0.0, "relighting")
        if asked != last[0]:
            last = asked, _mix_as(transport, asked)
            kept = Relighter(last[1])
        return RelightWavelets(last[1], kept.tuples(_lighting(last[1], light)))

    return relight


def _mix_as(transport: WaveletTransport, asked: WaveletLight) -> WaveletTransport:
    """`transport` with the weights and colours that are `asked` in place of its own."""
    if not asked.weight and asked.albedo is None:
        return transport
    return remix(transport, list(asked.weight) or None, asked.albedo)


def why_baked_for_one(_transport: WaveletTransport) -> str:
    """The factors of the BRDF are part of the transport."""
    return "The bake is of another BRDF; wavelets are baked for one."


def illuminate(file: TransportFile, light: Light, asked: WaveletLight, _brdf: str | None) -> Steps[Illuminated]:
    """The K-tuples of `file` under `light`."""
    yield Step(0.0, "relighting")
    transport = _mix_as(transport_of(file), asked)
    before = time.perf_counter()
    lighting = _lighting(transport, light)
    encoded = time.perf_counter()
    rows = tuples(transport, lighting)
    reported = {
        "brdf": transport.factors.name,
        "terms": transport.terms,
        "cube": transport.edge,
        "rounding_error_rel": rounding_error(file),
        "light_coefficients": lighting.light.kept,
        "light_rmse_rel": lighting.light.rmse_rel,
        "sky_energy_error_rel": lighting.light.energy_error_rel,
        "directional_lights": len(lighting.directional.direction),
        "light_s": encoded - before,
        "relight_s": time.perf_counter() - encoded,
    }
    return Illuminated(
        RelightWavelets(transport, rows),
        reported,
        lambda eye: radiance_from(transport, rows, eye).negative_rel,
        "bake the BRDF with --signs nonnegative, or factor it with --method nonnegative: those have no negative term",
    )


def _lighting(transport: WaveletTransport, light: Light) -> Lighting:
    if light.environment is None:
        return dark(transport.edge, light.lamps)
    around, turn, factor = light.environment, light.rotation, light.factor
    return lighting_of(around, transport.edge, rotation=turn, factor=factor, lamps=light.lamps)


def restrict(work: wavelet_bake.Work, _chosen: NDArray[np.int64]) -> wavelet_bake.Work:
    """All of it: where few vertices are wanted, rays are shared."""
    return work


def complete(transport: WaveletTransport, _work: wavelet_bake.Work, _chosen: NDArray[np.int64]) -> WaveletTransport:
    """It is complete."""
    return transport


def hold(transport: WaveletTransport) -> list[NDArray[Any]]:
    """The maps and the vectors."""
    of, several = transport.factors, [transport.vectors, *([transport.bounces] if transport.bounces else [])]
    arrays = [array for each in several for array in (each.indices, each.words, each.peaks, each.counts)]
    return [of.first, of.second, *arrays]


def edge_of(settings: WaveletSettings) -> int:
    """That of the light."""
    return settings.cube


def is_apart(_settings: WaveletSettings) -> bool:
    """Rays are nearly all that it takes."""
    return False


def prepare_shared(subject: Subject, settings: WaveletSettings, known: dict[Any, Any]) -> Steps[wavelet_bake.Work]:
    """Factors of so many terms serve all settings."""
    if settings.terms not in known:
        known[settings.terms] = yield from wavelet_bake.factors_for(subject.brdf, settings.terms)
    return wavelet_bake.prepare(subject.mesh, known[settings.terms], bake_settings(settings), subject.ground)


def maker(work: wavelet_bake.Work) -> Steps[Make]:
    """Makes vectors."""
    yield Step(1.0, "preparing vectors")
    settings = work.settings
    return wavelet_maker(work.surface, work.ground_vertex, work.factors, settings.edge, settings.coefficients)


def rows_of(work: wavelet_bake.Work) -> int:
    """One for each term."""
    return work.factors.terms


def assemble(work: wavelet_bake.Work, arrays: Mapping[str, NDArray[Any]]) -> WaveletTransport:
    """The vectors with their factors."""
    parts = (work.surface, work.ground_vertex, work.factors, work.ground_albedo, work.settings.edge)
    bounces = vectors_of(drain(wavelet_bake.reflect(work, [arrays]))) if work.settings.bounces else None
    return WaveletTransport(*parts, vectors_of(arrays), None, bounces)
