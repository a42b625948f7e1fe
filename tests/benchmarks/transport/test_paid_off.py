"""Break-even of a bake: the reference is timed at the requested error, and both sides of the ratio are real."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from benchmarks.transport import paid_off
from engine.brdf.brdf import brdf_from_text
from engine.core.errors import MissingCapability
from engine.core.steps import drain
from engine.figures.figure import coarse_bust
from engine.geometry.camera import frame
from engine.light.environment_file import open_environment
from engine.render.reference import reference
from engine.scene.scene import Scene

SIZE = (48, 48)


@pytest.fixture
def scene() -> Scene:
    mesh = coarse_bust(9, 13)
    return Scene(mesh, frame(mesh.positions), brdf_from_text("lambert"), environment=open_environment("studio"))


def test_the_reference_is_timed_at_the_error_that_is_asked_for(scene: Scene) -> None:
    truth = drain(reference(scene, SIZE, samples=256, seed=1))
    for samples in (6, 24):
        error = paid_off._error(drain(reference(scene, SIZE, samples=samples, seed=3)).image, truth).rmse_rel
        seconds, taken = paid_off.equal_error_s(scene, SIZE, truth, error)
        assert taken == pytest.approx(samples, rel=0.35)
        assert seconds > 0.0


@pytest.mark.parametrize("mode", ["sh", pytest.param("wavelet", marks=pytest.mark.long)])
def test_a_bake_is_measured_beside_the_reference(scene: Scene, mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paid_off, "FRAMES", 2)
    try:
        found = paid_off.measure("test", mode, scene, SIZE, 32)
    except MissingCapability as missing:
        pytest.skip(str(missing))
    assert found.more["light_speedup"] == pytest.approx(found.limit_s / found.time_s)
    assert found.time_s < found.more["frame_cpu_s"]
    assert 0.0 < found.more["error_rmse_rel"] < 0.5
    saved = found.limit_s - found.more["frame_cpu_s"]
    expected = math.ceil(found.more["bake_cpu_s"] / saved) if saved > 0.0 else None
    assert found.more["break_even_frames"] == expected


def test_without_real_data_the_built_in_bust_is_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(paid_off, "coarse_bust", lambda *_: coarse_bust(9, 13))
    scene = paid_off.scene_of(tmp_path / "none.obj", tmp_path / "none.hdr")
    assert scene.mesh.name == "blob"
    assert scene.environment is not None
    assert scene.environment.name == "studio"
