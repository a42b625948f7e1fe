"""Records of visibility: the same counts as without one, found once, and found anew where they cannot be read."""

from __future__ import annotations

import os
import sqlite3
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.ray_caster import RayCaster
from engine.transport.baking.visibility import Receivers, receivers, visibility_shares
from engine.transport.baking.visibility_record import _remove_oldest, is_kept, keep_visibility
from engine.transport.method import Subject, method_of
from tests.engine.planning.brute_force import bowl, sphere

EDGE, FINE = 8, 4


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Factors of few texels and trials of few views: what they are is compared, not how true they are."""
    for name, value in {
        "gaussian.bake.PROBE_VIEWS": 2,
        "gaussian.bake.TEST_EDGE": 16,
        "wavelet.bake.MAP_SIZE": 16,
    }.items():
        monkeypatch.setattr(f"engine.transport.{name}", value)


@pytest.fixture(scope="module")
def model() -> Receivers:
    return receivers(bowl())


@pytest.fixture
def rays(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Rays that were cast, by call."""
    cast: list[int] = []
    occluded = RayCaster.occluded

    def count(self: RayCaster, origin: NDArray[np.float64], *words: object, **more: object) -> NDArray[np.bool_]:
        cast.append(len(origin))
        return occluded(self, origin, *words, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(RayCaster, "occluded", count)
    return cast


def counts_of(of: Receivers, vertices: NDArray[np.int64] | None = None) -> NDArray[np.uint8]:
    return np.concatenate([counts for _, counts in visibility_shares(of, EDGE, FINE, vertices)])


def test_counts_are_those_without_a_record_and_cost_no_ray_again(
    model: Receivers, tmp_path: Path, rays: list[int]
) -> None:
    known = counts_of(model)
    kept = keep_visibility(model, tmp_path / "visibility")
    assert np.array_equal(counts_of(kept), known)
    rays.clear()
    assert np.array_equal(counts_of(keep_visibility(model, tmp_path / "visibility")), known)
    assert rays == []


def test_a_record_says_whether_it_holds_all(model: Receivers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.transport.baking.visibility_record.TEXELS", 6 * EDGE * EDGE * 10)
    kept = keep_visibility(model, tmp_path)
    assert not is_kept(model, EDGE, FINE)
    assert not is_kept(kept, EDGE, FINE)
    assert not list(tmp_path.iterdir())
    counts_of(kept, np.arange(len(model) - 1))
    assert is_kept(kept, EDGE, FINE) == ((len(model) - 1) % 10 != 0)
    counts_of(kept)
    assert is_kept(kept, EDGE, FINE)
    assert not is_kept(kept, EDGE, FINE + 1)


def test_gaussians_of_another_brdf_cast_no_ray_for_direct_light(tmp_path: Path, rays: list[int]) -> None:
    folder = tmp_path / "visibility"
    for number, text in enumerate(("ggx:kd=0.2,alpha=0.4,f0=0.5", "ggx:kd=0.1,alpha=0.3,f0=0.2/0.5/0.8")):
        subject = Subject(bowl(rows=6), brdf_from_text(text), kept=folder)
        method = method_of("gaussian")
        work = drain(method.baking.prepare(subject, method.settings(cube=EDGE, samples=16)))
        before = method.baking.estimate_s(work)
        rays.clear()
        drain(method.baking.bake(tmp_path / str(number), work))
        assert (rays == []) == (number == 1)
        if number == 0:
            assert method.baking.estimate_s(work) < before
    plain = replace(work, kept=None)
    drain(method.baking.bake(tmp_path / "plain", plain))
    assert (tmp_path / "plain").read_bytes() == (tmp_path / "1").read_bytes()


def test_some_vertices_are_read_as_all_are(model: Receivers, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks are smaller than what is asked for, and begin elsewhere."""
    monkeypatch.setattr("engine.transport.baking.visibility_record.TEXELS", 6 * EDGE * EDGE * 10)
    known = counts_of(model)
    kept = keep_visibility(model, tmp_path)
    chosen = np.array([3, 9, 10, 11, 55, 123])
    assert np.array_equal(counts_of(kept, chosen), known[chosen])
    assert np.array_equal(counts_of(kept, chosen), known[chosen])
    asked = [chunk for chunk, _ in visibility_shares(kept, EDGE, FINE, chosen)]
    assert np.array_equal(np.concatenate(asked), chosen)


def test_another_surface_has_another_record(model: Receivers, tmp_path: Path) -> None:
    counts_of(keep_visibility(model, tmp_path))
    ball = receivers(sphere())
    assert np.array_equal(counts_of(keep_visibility(ball, tmp_path)), counts_of(ball))
    assert len(list(tmp_path.iterdir())) == 2


@pytest.mark.parametrize("damage", ["file", "block", "length", "crc"])
def test_what_cannot_be_read_is_found_anew(model: Receivers, tmp_path: Path, damage: str) -> None:
    known = counts_of(model)
    counts_of(keep_visibility(model, tmp_path))
    (path,) = tmp_path.iterdir()
    if damage == "file":
        path.write_bytes(b"no database at all" * 500)
    else:
        value = {"block": "x'00112233'", "length": "'text'", "crc": "data"}[damage]
        crc = "crc + 1" if damage == "crc" else "crc"
        with sqlite3.connect(path) as file:
            file.execute(f"UPDATE blocks SET data = {value}, crc = {crc}")
        file.close()
    assert np.array_equal(counts_of(keep_visibility(model, tmp_path)), known)
    assert np.array_equal(counts_of(keep_visibility(model, tmp_path)), known)


def test_a_folder_that_cannot_be_made_keeps_nothing(model: Receivers, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert keep_visibility(model, tmp_path / "file" / "visibility").record is None


def test_the_oldest_records_go_first(tmp_path: Path) -> None:
    for number in range(3):
        path = tmp_path / f"visibility-{number}.sqlite"
        path.write_bytes(bytes(100))
        os.utime(path, (number, number))
    _remove_oldest(tmp_path, 250)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["visibility-1.sqlite", "visibility-2.sqlite"]


@pytest.mark.parametrize("name", ["sh", "wavelet"])
def test_a_bake_of_another_brdf_casts_no_ray(tmp_path: Path, rays: list[int], name: str) -> None:
    """The file is the one of a bake without a record, bit by bit."""
    method, mesh = method_of(name), bowl(rows=8)
    settings = method.with_values({"order": 4, "cube": 8, "coefficients": 24, "terms": 2})

    def bake(text: str, kept: Path | None) -> bytes:
        subject = Subject(mesh, brdf_from_text(text), kept=kept)
        work = drain(method.baking.prepare(subject, settings))
        drain(method.baking.bake(tmp_path / "a.transport", work))
        return (tmp_path / "a.transport").read_bytes()

    bake("ggx:alpha=0.3", tmp_path / "visibility")
    rays.clear()
    again = bake("phong:exponent=20", tmp_path / "visibility")
    assert rays == []
    assert again == bake("phong:exponent=20", None)
    assert rays
