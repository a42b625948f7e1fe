"""Directional maps in bundles: every bit comes back, and what was forged is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.bundle.bundle import open_bundle, save_bundle, verify_bundle
from engine.bundle.manifest import NUMBERS, PLANE_FILES, WEIGHTS
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.storage.archive import open_archive
from engine.storage.records import read_manifest, write_manifest
from tests.engine.domes import dome_material


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return drain(save_bundle(tmp_path / "dome", dome_material()))


def forge(folder: Path, name: str, content: bytes) -> None:
    """Put `content` in place of a member, with a manifest that agrees."""
    import hashlib

    (folder / name).write_bytes(content)
    manifest = read_manifest((folder / "manifest.json").read_bytes(), folder)
    member = manifest.members[name].model_copy(
        update={"sha256": hashlib.sha256(content).hexdigest(), "size_bytes": len(content)}
    )
    forged = manifest.model_copy(update={"members": {**manifest.members, name: member}})
    (folder / "manifest.json").write_bytes(write_manifest(forged))


def forge_numbers(folder: Path, **changes: Any) -> None:
    forge(folder, NUMBERS, json.dumps({**json.loads((folder / NUMBERS).read_text()), **changes}).encode())


@pytest.mark.parametrize("name", ["dome.lightarc", "dome"])
def test_every_bit_comes_back(tmp_path: Path, name: str) -> None:
    path = drain(save_bundle(tmp_path / name, dome_material()))
    ours, found = dome_material().directional, open_bundle(path).directional
    assert ours is not None
    assert found is not None
    for field in ("planes", "low", "step", "mean", "vectors", "lights", "table"):
        assert np.array_equal(getattr(ours, field), getattr(found, field)), field
    for field in ("kernel", "r_max", "leave_one_out", "in_sample", "mean_picture"):
        assert getattr(ours, field) == getattr(found, field), field
    assert verify_bundle(path).problems == ()
    assert verify_bundle(path).schema_version == 2


def test_the_same_material_gives_the_same_bytes(tmp_path: Path) -> None:
    one, other = (drain(save_bundle(tmp_path / name, dome_material())) for name in ("a.lightarc", "b.lightarc"))
    assert one.read_bytes() == other.read_bytes()


def test_a_manifest_without_a_directional_map_is_that_of_before(folder: Path) -> None:
    manifest = read_manifest((folder / "manifest.json").read_bytes(), folder)
    plain = manifest.model_copy(update={"directional": None, "schema_version": 1})
    assert b"directional" not in write_manifest(plain).split(b'"members"')[0].split(b'"health"')[0]
    wrong = manifest.model_copy(update={"schema_version": 1})
    with pytest.raises(InputError, match="schema 2"):
        read_manifest(write_manifest(wrong), folder)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"low": [0.0]}, "other numbers"),
        ({"vectors": []}, "other numbers"),
        ({"lights": [[0.0, 0.0, 0.5]] * 12}, "not unit vectors"),
        ({"lights": [[0.0, 0.0, -1.0]] * 12}, "cannot be interpolated"),
        ({"lights": [[0.0, 0.0, 1.0]] * 12, "kernel_noise": 0.0}, "cannot be interpolated"),
        ({"kernel_length": 0.0}, "kernel_length"),
        ({"step": [-1.0]}, "step"),
        ({"extra": 1}, "extra"),
    ],
)
def test_forged_numbers_are_refused(folder: Path, changes: dict[str, Any], words: str) -> None:
    forge_numbers(folder, **changes)
    with pytest.raises(InputError, match=words):
        open_bundle(folder)


def test_a_plane_of_another_size_is_refused(folder: Path) -> None:
    from engine.images.encode import encode_png

    forge(folder, PLANE_FILES[0], encode_png(np.zeros((7, 8), np.uint8)))
    with pytest.raises(InputError, match="grey image of 7 x 9"):
        open_bundle(folder)


def test_weights_that_the_numbers_do_not_give_are_found(folder: Path) -> None:
    kernel = json.loads((folder / NUMBERS).read_text())["kernel_length"]
    forge_numbers(folder, kernel_length=2.0 * kernel)
    assert any(WEIGHTS in problem for problem in verify_bundle(folder).problems)


def test_members_are_those_that_are_promised(folder: Path) -> None:
    names = set(
        open_archive(
            folder,
            frozenset(
                {*PLANE_FILES, NUMBERS, WEIGHTS, "manifest.json", "brdf.json"}
                | {"preview.png", "shader/lightarc.glsl", "viewer/index.html"}
            ),
        ).sizes
    )
    planes = len(dome_material().directional.planes)  # type: ignore[union-attr]
    assert {NUMBERS, WEIGHTS, *PLANE_FILES[:planes], "viewer/index.html", "shader/lightarc.glsl"} < names
