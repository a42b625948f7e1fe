"""The measures of importing, on photographs small enough for a test."""

import pytest

from engine.bench import capture
from engine.steps import drain


@pytest.mark.parametrize(
    ("measure", "name"),
    [
        (capture.import_raw, "raw"),
        (capture.import_tiff, "tiff"),
        (capture.import_aligned, "aligned"),
        (capture.import_bracketed, "bracketed"),
    ],
)
def test_imports_are_measured_with_their_memory(tmp_path, monkeypatch, measure, name):
    for key, value in (("COUNT", 4), ("HEIGHT", 80), ("WIDTH", 96)):
        monkeypatch.setattr(capture, key, value)
    taken = measure(tmp_path)
    assert taken.name == f"import-{name}-24mp"
    assert taken.time_s > 0
    assert taken.limit_s > 0
    assert taken.more["peak_memory_bytes"] >= taken.more["memory_before_bytes"]


def test_AL3_alignment_keeps_what_is_promised(tmp_path):
    (found,) = drain(capture.alignment(tmp_path))
    assert found.error <= found.bound
