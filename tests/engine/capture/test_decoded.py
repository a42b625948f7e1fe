"""An import of photographs that have been decoded before: the stack of one that decodes anew, bit for bit."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import engine.capture.photograph.decode as decoding
from engine.capture.decoded import Decoded, find_kept, mark_of
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.capture.lights.sources import find
from engine.capture.photograph.decode import read_photograph
from engine.capture.stack import RECORD
from engine.core.steps import drain
from tests.engine.capture.calibration.generated import Capture, render, write

OPTIONS: dict[str, Any] = {"white_balance": "camera", "transfer": "auto", "bands": ()}
SETTINGS = {
    "calibrated": ImportSettings(),
    "direct": ImportSettings(calibrate="none"),
    "near": ImportSettings(lamp_distance=4.0, calibrate="none"),
    "aligned": ImportSettings(motion="translation", calibrate="none"),
    "cut": ImportSettings(crop=(3, 4, 20, 10), calibrate=("gains",)),
}


@pytest.fixture(scope="module")
def decoded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, Decoded]]:
    """Photographs, and what was decoded of them: of the second one without codes."""
    folder = tmp_path_factory.mktemp("decoded") / "photographs"
    write(
        render(Capture(seed=5, distance=3.0, gains=(0.7, 1.2), file_format="jpg", lamps=8, height=40, width=48)), folder
    )
    with closing(Decoded(OPTIONS)) as kept:
        for index, path in enumerate(sorted(folder.glob("*.jpg"))):
            mark = mark_of(path)
            assert mark is not None
            kept.keep(mark, read_photograph(path, **OPTIONS, keep_codes=index != 1))
        yield folder, kept


def _import(folder: Path, settings: ImportSettings, target: Path) -> tuple[bytes, bytes, dict[str, Any]]:
    """The pixels, and the record but for their kind: they are kept as radiance where one has no codes."""
    stack = drain(import_stack(find([folder]), settings, target))
    record = json.loads((target / RECORD).read_text())
    kind = ("codes", "radiance_crc32", "saturated_crc32", "lightarc_stack", "record_sha256")
    rest = {name: value for name, value in record.items() if name not in kind}
    return stack.radiance[:].tobytes(), stack.saturated[:].tobytes(), rest


@pytest.mark.parametrize("kind", SETTINGS)
def test_an_import_takes_what_is_decoded_and_gives_the_same_bits(
    decoded: tuple[Path, Decoded], kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, _ = decoded
    with monkeypatch.context() as other, monkeypatch.context() as patch:
        other.setattr("engine.capture.photograph.decode._supplies", [])
        other.setattr("engine.capture.decoded._open", [])
        expected = _import(folder, SETTINGS[kind], tmp_path / "expected")
        other.undo()
        patch.setattr(decoding, "Decoding", None)  # which nobody may ask
        patch.setattr("engine.capture.decoded.read_noted_exposure", None)
        assert _import(folder, SETTINGS[kind], tmp_path / "found") == expected


def test_a_photograph_is_known_by_its_file_and_by_what_was_asked(decoded: tuple[Path, Decoded], tmp_path: Path) -> None:
    folder, _ = decoded
    path = sorted(folder.glob("*.jpg"))[0]
    moved = path.with_name("moved.jpg")
    assert find_kept(path, OPTIONS) is not None
    assert find_kept(path, {**OPTIONS, "transfer": "linear"}) is None
    path.rename(moved)
    try:
        found = find_kept(moved, OPTIONS)
        assert found is not None
        assert found.photograph.path == moved
        known = read_photograph(moved)
        assert np.array_equal(known.radiance, decoding.read_photograph(moved, half_size=False).radiance)
        before = moved.stat().st_mtime_ns
        os.utime(moved, ns=(before, before + 1))
        assert find_kept(moved, OPTIONS) is None
        os.utime(moved, ns=(before, before))
        assert find_kept(moved, OPTIONS) is not None
    finally:
        moved.rename(path)
