"""Portable float maps: both orders of bytes, colours and grey, and what is cut short or hostile."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.images.decode import read_image
from engine.light.environment_file import open_environment

LIGHT = np.random.default_rng(6).uniform(0.0, 40.0, (4, 8, 3)).astype(np.float32)


def pfm(values: np.ndarray, order: str, scale: float = 1.0) -> bytes:
    kind, sign = "F" if values.ndim == 3 else "f", "-" if order == "<" else ""
    head = f"P{kind}\n{values.shape[1]} {values.shape[0]}\n{sign}{scale:g}\n"
    return head.encode() + values[::-1].astype(f"{order}f4").tobytes()


@pytest.mark.parametrize("order", "<>")
def test_an_environment_comes_back_bit_for_bit(tmp_path: Path, order: str) -> None:
    path = tmp_path / "sky.pfm"
    path.write_bytes(pfm(LIGHT, order))
    found = open_environment(str(path))
    assert np.array_equal(found.radiance, LIGHT)
    assert not found.health.warnings


def test_grey_is_grey_and_a_scale_is_named(tmp_path: Path) -> None:
    path = tmp_path / "a.pfm"
    path.write_bytes(pfm(LIGHT[..., 0], "<", 2.5))
    found = read_image(path)
    assert np.array_equal(found.pixels, np.repeat(LIGHT[..., :1], 3, axis=2))
    assert any("scale of 2.5" in warning for warning in found.warnings)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (pfm(LIGHT, "<")[:-1], "incomplete"),
        (b"PF\n8 4\n0\n" + bytes(400), "no order"),
        (b"PF\n8 -4\n-1\n" + bytes(400), "header"),
        (b"PF\n60000 60000\n-1\n", "megapixels"),
        (b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80), "KTX"),
    ],
)
def test_others_are_refused_by_name(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "a.pfm"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_image(path)
