"""A first image from kept visibility: the transport of a bake of the same order, but for a coarser cube map."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.ground import Ground
from engine.geometry.ray_caster import RayCaster
from engine.transport import preview as module
from engine.transport.method import Subject, method_of
from engine.transport.preview import ORDER, add_up, preview
from tests.engine.planning.brute_force import bowl

GLOSSY = brdf_from_text("ggx:kd=0.3,alpha=0.3,f0=0.2")


@pytest.fixture(scope="module")
def subject(tmp_path_factory: pytest.TempPathFactory) -> Subject:
    """A bowl on a ground whose visibility is kept by a bake in wavelets."""
    folder = tmp_path_factory.mktemp("kept")
    of = Subject(bowl(), GLOSSY, Ground(albedo=0.5), kept=folder / "visibility")
    wavelets = method_of("wavelet")
    settings = wavelets.with_values({"cube": 32, "terms": 1})
    work = drain(wavelets.baking.prepare(of, settings))
    drain(wavelets.baking.bake(folder / "wavelets.transport", work))
    return of


def test_the_matrices_are_those_of_a_bake(subject: Subject, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sh = method_of("sh")
    work = drain(sh.baking.prepare(subject, sh.with_values({"order": ORDER, "cube": 32})))
    baked = drain(sh.baking.bake(tmp_path / "sh.transport", work)).transport
    monkeypatch.setattr(RayCaster, "occluded", None)  # no ray is cast
    first = drain(preview(subject))
    assert first is not None
    assert first.rows.shape == baked.rows.shape
    assert first.ground_albedo == baked.ground_albedo
    apart = np.sqrt(np.mean((first.rows - baked.rows) ** 2) / np.mean(baked.rows**2))
    assert 0.0 < apart < 0.01, "texels of twice the edge lose the horizon within a texel, and nothing else"


def test_there_is_none_without_visibility_nor_of_a_model_too_large(
    subject: Subject, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert drain(preview(Subject(bowl(), GLOSSY, kept=tmp_path))) is None
    assert drain(preview(Subject(bowl(), GLOSSY))) is None
    monkeypatch.setattr(module, "MAX_BYTES", 1000)
    assert drain(preview(subject)) is None


def test_shares_of_a_cube_map_add_up_face_by_face() -> None:
    counts = np.random.default_rng(3).integers(0, 17, (2, 6, 8, 8)).astype(np.uint8)
    sums = add_up(counts.reshape(2, -1), 8, 4).reshape(2, 6, 4, 4)
    for index in np.ndindex(sums.shape):
        vertex, face, i, j = index
        assert sums[index] == counts[vertex, face, 2 * i : 2 * i + 2, 2 * j : 2 * j + 2].sum(dtype=np.int64)
