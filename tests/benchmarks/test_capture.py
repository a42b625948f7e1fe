"""The measures of importing, on photographs small enough for a test."""

from pathlib import Path
from typing import Any

import pytest

from benchmarks import capture
from engine.core.steps import drain


@pytest.mark.parametrize(
    ("measure", "name"),
    [
        pytest.param(capture.import_raw, "raw", marks=pytest.mark.long),
        (capture.import_tiff, "tiff"),
        (capture.import_aligned, "aligned"),
        pytest.param(capture.import_bracketed, "bracketed", marks=pytest.mark.long),
    ],
)
def test_imports_are_measured_with_their_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, measure: Any, name: str
) -> None:
    for key, value in (("COUNT", 4), ("HEIGHT", 80), ("WIDTH", 96)):
        monkeypatch.setattr(capture, key, value)
    taken = measure(tmp_path)
    assert taken.name == f"import-{name}-24mp"
    assert taken.time_s > 0
    assert taken.limit_s > 0
    assert taken.more["peak_memory_bytes"] >= taken.more["memory_before_bytes"]


def test_AL3_alignment_keeps_what_is_promised(tmp_path: Path) -> None:
    (found,) = drain(capture.alignment(tmp_path))
    assert found.bound is not None
    assert found.error <= found.bound
