"""Bundles of materials larger than memory: written strip by strip, sound as zip, refused where memory lacks."""

import hashlib
import json
import tracemalloc
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.bundle.bundle import open_bundle, save_bundle
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.scene.material import Material
from engine.shading.power_law import fit
from engine.shading.shading_map import ShadingMap, target_radiance
from engine.storage.scratch import keep_in_memory, scratch_array

HEIGHT, WIDTH, SLICES = 1920, 240, 6


@pytest.fixture
def material(monkeypatch: pytest.MonkeyPatch) -> Material:
    """A material whose slices lie in a file."""
    monkeypatch.setattr("engine.storage.scratch.IN_MEMORY_BYTES", 1 << 20)
    slices = scratch_array((SLICES, HEIGHT, WIDTH, 3), np.float32)
    texture = np.random.default_rng(0).random((HEIGHT, WIDTH, 3), np.float32)
    for index in range(SLICES):
        slices[index] = texture * np.float32(index / (SLICES - 1))
    shading_map = ShadingMap(slices, 0.5, target_radiance(0.5, SLICES))
    return Material(shading_map, drain(fit(shading_map)))


def test_a_zip_of_strips_is_sound(material: Material, tmp_path: Path) -> None:
    path = drain(save_bundle(tmp_path / "large.lightarc", material))
    with zipfile.ZipFile(path) as packed:
        assert packed.testzip() is None
        members = json.loads(packed.read("manifest.json"))["members"]
        for name, stated in members.items():
            content = packed.read(name)
            assert (len(content), hashlib.sha256(content).hexdigest()) == (stated["size_bytes"], stated["sha256"])
    assert material.shading_map is not None
    again = open_bundle(path).shading_map
    assert again is not None
    assert np.array_equal(again.slices, material.shading_map.slices)


@pytest.mark.parametrize("name", ["large.lightarc", "large"])
def test_writing_holds_strips_and_no_maps(material: Material, tmp_path: Path, name: str) -> None:
    drain(save_bundle(tmp_path / f"first-{name}", material))  # what is loaded once is not counted
    assert material.shading_map is not None
    size_bytes = material.shading_map.slices.nbytes
    tracemalloc.start()
    drain(save_bundle(tmp_path / name, material))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 0.5 * size_bytes


def test_a_bundle_that_memory_cannot_hold_is_refused_in_words(
    material: Material, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import psutil

    path = drain(save_bundle(tmp_path / "large.lightarc", material))
    free: Any = psutil.virtual_memory()._replace(available=1 << 20)
    monkeypatch.setattr("engine.bundle.maps._READ_UNASKED_BYTES", 1 << 20)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: free)
    with pytest.raises(InputError, match=r"of memory, and 1.* are free"):
        open_bundle(path)
    with keep_in_memory(0):  # where maps lie on the disk
        assert open_bundle(path).shading_map is not None
