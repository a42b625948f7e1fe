"""Effects that are forced on a model that has none of them: all the work is done, and nothing changes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.ray_caster import RayCaster
from engine.light.cube_map import cube_of
from engine.planning import bake as bake_plan
from engine.planning.costs.cost_model import CostModel
from engine.planning.plan import plan
from engine.transport.gaussian.transfer import GaussianTransport
from engine.transport.wavelet.quantise import encode_light
from engine.transport.wavelet.transfer import WaveletTransport, relight_transport
from tests.engine.planning.brute_force import gradient_sky, sphere

PAINT = "ggx:kd=0.4,alpha=0.4,f0=0.04"


def arrays_of(transport: WaveletTransport | GaussianTransport) -> list[Any]:
    """The arrays that light is multiplied with."""
    if isinstance(transport, WaveletTransport):
        return [relight_transport(transport, encode_light(cube_of(gradient_sky(), transport.edge).radiance))]
    assert transport.diffuse is not None
    parts = [(each.weight, each.mean, each.sigma) for each in transport.components]
    return [transport.diffuse.rows, *(array for part in parts for array in part)]


@pytest.mark.parametrize("mode", [pytest.param("wavelet", marks=pytest.mark.long), "gaussian"])
def test_T1_forced_shadows_of_a_convex_model_change_nothing(
    costs: CostModel, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: str
) -> None:
    mesh, brdf = sphere(2), brdf_from_text(PAINT)
    options: dict[str, Any] = {"cost": costs, "error": 0.5, "modes": (mode,)}
    lean = plan(mesh, brdf, gradient_sky(), **options)
    full = plan(mesh, brdf, gradient_sky(), force=("self-shadowing",), **options)
    assert (lean.decision("self-shadowing"), full.decision("self-shadowing")) == ("skipped", "forced on")
    assert lean.setting == full.setting
    calls: list[int] = []
    was = RayCaster.occluded

    def note(caster: RayCaster, origin: Any, direction: Any, **more: Any) -> Any:
        calls.append(len(origin))
        return was(caster, origin, direction, **more)

    monkeypatch.setattr(RayCaster, "occluded", note)
    found = []
    for name, chosen in (("lean", lean), ("full", full)):
        calls.clear()
        ready = drain(bake_plan.prepare(chosen, mesh, brdf))
        baked = drain(ready.start(tmp_path / f"{name}.transport"))
        found.append((arrays_of(baked.transport), sum(calls)))
    (one, no_rays), (other, rays) = found
    assert no_rays == 0
    assert rays > 0
    for first, second in zip(one, other, strict=True):
        np.testing.assert_allclose(second, first, rtol=0.0, atol=1e-12)
