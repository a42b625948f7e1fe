"""Quantised pairs and kept tiles in bundles: bit for bit, in as few bits as promised, and not believed when forged."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.bundle.bundle import open_bundle, save_bundle, verify_bundle
from engine.bundle.manifest import MANIFEST
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.encode import encode_exr, encode_png
from engine.scene.material import Material
from engine.shading.mixed import keep_tiles
from engine.shading.power_law import PowerLawMap, fit
from engine.shading.quantise import quantise
from engine.shading.shading_map import ShadingMap
from engine.storage.scratch import keep_in_memory
from tests.engine.bundle.test_bundle import assert_same, forge, members_of, save

HEIGHT, WIDTH, SLICES = 21, 35, 4


def make_law(bits: int, bound: float | None) -> PowerLawMap:
    random = np.random.default_rng(3)
    slices = random.random((SLICES, HEIGHT, WIDTH, 3), dtype=np.float32) - np.float32(0.01)
    shading_map = ShadingMap(slices, 0.7, np.linspace(0.0, 0.7, SLICES))
    law = drain(fit(shading_map))
    if bits < 32:
        law = drain(quantise(law, shading_map, bits))  # type: ignore[arg-type]
    return law if bound is None else drain(keep_tiles(law, shading_map, bound, size=8))


@pytest.mark.parametrize("name", ["woven.lightarc", "woven"], ids=["zip", "folder"])
@pytest.mark.parametrize("bound", [None, 0.0, 0.44], ids=["pair", "all", "some"])
@pytest.mark.parametrize("bits", [8, 16, 32])
def test_every_form_comes_back_bit_for_bit(tmp_path: Path, bits: int, bound: float | None, name: str) -> None:
    law = make_law(bits, bound)
    assert bound != 0.44 or (law.kept is not None and (law.kept.place < 0).any())
    path = save(tmp_path / name, Material(None, law))
    restored = open_bundle(path)
    assert_same(restored, Material(None, law))
    with keep_in_memory(0):
        assert_same(open_bundle(path), Material(None, law))
    assert verify_bundle(path).problems == ()
    assert restored.power_law is not None
    assert np.array_equal(restored.power_law.lookup(3.2, 16.01, 0.3), law.lookup(3.2, 16.01, 0.3))


@pytest.mark.parametrize("bits", [8, 16])
def test_the_manifest_says_bits_and_bound_and_the_codes_are_of_these_bits(tmp_path: Path, bits: int) -> None:
    law = make_law(bits, None)
    members = members_of(save(tmp_path / "woven.lightarc", Material(None, law)))
    storage = json.loads(members[MANIFEST])["power_law"]["storage"]
    assert (storage["exponent_bits"], storage["scale_bits"]) == (bits, 16)
    assert 0 < storage["measured_radiance"] <= storage["bound_radiance"]
    codes: Any = cv2.imdecode(np.frombuffer(members["power_law_exponent.png"], np.uint8), cv2.IMREAD_UNCHANGED)
    assert codes.dtype.itemsize * 8 == bits
    assert np.array_equal(np.float32(codes[..., ::-1] * np.float64(storage["exponent_step"])), law.exponent)
    assert "power_law_exponent.exr" not in members


def test_kept_tiles_and_power_law_add_up_for_other_programs(tmp_path: Path) -> None:
    import OpenEXR

    law = make_law(32, 0.44)
    path = save(tmp_path / "woven", Material(None, law))
    file = OpenEXR.File(str(path / "power_law_kept_tiles.exr"), separate_channels=True).channels()
    for index in range(SLICES):
        kept = np.stack([file[f"slice{index:02d}.{channel}"].pixels for channel in "RGB"], axis=2)
        power = law.scale * (index / (SLICES - 1)) ** law.exponent if index else 0.0
        shown = kept + (1.0 - file["A"].pixels[..., None]) * power
        np.testing.assert_allclose(shown, law.slice_image(0.7 * index / (SLICES - 1)), rtol=1e-5, atol=1e-7)


def test_exponents_that_no_code_gives_are_not_written(tmp_path: Path) -> None:
    law = make_law(8, None)
    between = dataclasses.replace(law, exponent=law.exponent + np.float32(law.storage.exponent_step / 2))
    with pytest.raises(ValueError, match="not multiples of the step"):
        drain(save_bundle(tmp_path / "woven.lightarc", Material(None, between)))


CODES = np.zeros((HEIGHT, WIDTH, 3), np.uint8)
PLANE = np.zeros((HEIGHT, WIDTH), np.float32)
PARTIAL = np.pad(np.ones((8, 7), np.float32), ((0, HEIGHT - 8), (0, WIDTH - 7)))
KEPT = {f"slice{index:02d}.{channel}": PLANE for index in range(SLICES) for channel in "RGB"}


@pytest.mark.parametrize(
    ("member", "content", "problem"),
    [
        ("power_law_exponent__png", encode_png(CODES.astype(np.uint16)), "8 bits each"),
        ("power_law_exponent__png", encode_png(CODES[:-1]), "21 x 35 pixels"),
        ("power_law_exponent__png", encode_png(CODES[..., 0]), "RGB image"),
        ("power_law_exponent__png", encode_png(CODES)[:60], "damaged|cannot be decoded"),
        ("power_law_exponent__png", b"BM" + bytes(100), "is not a PNG"),
        ("power_law_scale__exr", encode_exr(dict.fromkeys("RGB", PLANE), half=False), "16-bit floats"),
        ("power_law_kept_tiles__exr", encode_exr({**KEPT, "A": PARTIAL}, half=False), "whole tiles"),
        ("power_law_kept_tiles__exr", encode_exr({**KEPT, "A": PLANE}, half=False), "tiles must be"),
        ("power_law_kept_tiles__exr", encode_exr(KEPT, half=False), "other channels"),
        ("power_law_kept_tiles__exr", b"v/1\1" + bytes(100), "damaged"),
    ],
)
def test_fault_9_forged_codes_and_tiles(tmp_path: Path, member: str, content: bytes, problem: str) -> None:
    path = save(tmp_path / "woven.lightarc", Material(None, make_law(8, 0.44)))
    forge(path, lambda value: None, **{member: content})
    with pytest.raises(InputError, match=problem):
        open_bundle(path)
    assert len(verify_bundle(path).problems) == 1


@pytest.mark.parametrize(
    "change",
    [
        lambda law: law["storage"].update(exponent_bits=16),
        lambda law: law["storage"].update(exponent_bits=12),
        lambda law: law["storage"].update(exponent_step=0.0),
        lambda law: law["storage"].update(exponent_bits=32),
        lambda law: law["storage"].update(scale_bits=32),
        lambda law: law["kept_tiles"].update(size_px=7),
        lambda law: law["kept_tiles"].update(size_px=1 << 30),
        lambda law: law["kept_tiles"].update(slices=3),
        lambda law: law.update(storage=None),
    ],
)
def test_fault_9_forged_storage(tmp_path: Path, change: Any) -> None:
    path = save(tmp_path / "woven.lightarc", Material(None, make_law(8, 0.44)))
    forge(path, lambda value: change(value["power_law"]))
    with pytest.raises(InputError):
        open_bundle(path)
    assert not verify_bundle(path).ok
