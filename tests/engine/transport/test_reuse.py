"""Another BRDF on a bake whose visibility is kept: the transport of a fresh bake, without a change of the file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.light.environment_file import open_environment
from engine.transport.baking.file import open_transport
from engine.transport.method import Subject, method_of
from engine.transport.reuse import with_brdf
from tests.engine.planning.brute_force import bowl

FIRST, OTHER = "ggx:kd=0.2,alpha=0.4,f0=0.5", "ggx:kd=0.1,alpha=0.3,f0=0.6"
SETTINGS: dict[str, dict[str, Any]] = {
    "sh": {"order": 4, "cube": 8},
    "wavelet": {"cube": 8, "coefficients": 16, "terms": 2},
    "gaussian": {"cube": 8, "samples": 16},
}


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Factors of few texels and trials of few views: what they are is compared, not how true they are."""
    for name, value in {
        "gaussian.bake.PROBE_VIEWS": 2,
        "gaussian.bake.TEST_EDGE": 16,
        "wavelet.bake.MAP_SIZE": 16,
    }.items():
        monkeypatch.setattr(f"engine.transport.{name}", value)


def bake(path: Path, mode: str, text: str, kept: Path | None, **more: Any) -> Path:
    method = method_of(mode)
    subject = Subject(bowl(rows=6), brdf_from_text(text), Ground(cells=4), kept=kept)
    settings = method.settings(**{**SETTINGS[mode], **more})
    drain(method.baking.bake(path, drain(method.baking.prepare(subject, settings))))
    return path


@pytest.mark.parametrize("mode", ["sh", "wavelet", "gaussian"])
def test_transport_of_another_brdf_is_that_of_a_fresh_bake(tmp_path: Path, mode: str) -> None:
    kept = tmp_path / "visibility"
    path = bake(tmp_path / "first", mode, FIRST if mode != "sh" else "lambert:albedo=0.4", kept)
    before = path.read_bytes()
    found = drain(with_brdf(open_transport(path), brdf_from_text(OTHER), kept, open_environment("studio")))
    terms = {"terms": 4} if mode == "wavelet" else {}
    fresh = open_transport(bake(tmp_path / "fresh", mode, OTHER, None, **terms))
    assert found.file.kind == mode
    assert set(found.file.arrays) == set(fresh.arrays)
    for name, array in fresh.arrays.items():
        assert np.array_equal(found.file.arrays[name], array), name
    assert path.read_bytes() == before
    assert found.error["error_env"] == "studio"
    assert 0.0 < found.error["error_rmse_rel"] < 1.0


@pytest.mark.parametrize("mode", ["wavelet", "gaussian"])
def test_a_bake_whose_visibility_is_not_kept_says_what_another_takes(tmp_path: Path, mode: str) -> None:
    file = open_transport(bake(tmp_path / "first", mode, FIRST, tmp_path / "visibility"))
    for kept in (None, tmp_path / "elsewhere"):
        with pytest.raises(UsageError, match=r"visibility is not kept.*bake again .* takes about \d"):
            drain(with_brdf(file, brdf_from_text(OTHER), kept))


def test_light_between_parts_of_the_model_takes_rays(tmp_path: Path) -> None:
    kept = tmp_path / "visibility"
    file = open_transport(bake(tmp_path / "first", "sh", FIRST, kept, interreflection=True))
    with pytest.raises(UsageError, match="bake again"):
        drain(with_brdf(file, brdf_from_text(OTHER), kept))


def test_what_a_file_does_not_say_asks_for_a_bake(tmp_path: Path) -> None:
    kept = tmp_path / "visibility"
    mixed = open_transport(bake(tmp_path / "mixed", "wavelet", FIRST, kept, blend=("lambert:albedo=0.5:y",)))
    with pytest.raises(UsageError, match="mixes several"):
        drain(with_brdf(mixed, brdf_from_text(OTHER), kept))
