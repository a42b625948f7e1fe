"""The frame of each mode beside the plain model, in an image that is small enough for every machine."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.transport import frame_4k


@pytest.mark.parametrize(
    "mode",
    [
        "brdf",
        "sh_texels",
        *(pytest.param(mode, marks=pytest.mark.long) for mode in ("shading_map", "directional_map", "pbr_maps", "sh")),
    ],
)
def test_a_mode_stands_beside_the_plain_model(gl: Any, mode: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frame_4k, "SIZE", (32, 18))
    monkeypatch.setattr(frame_4k, "EDGE", 16)
    monkeypatch.setattr(frame_4k, "best_of", lambda work: work() or 0.5)
    device = gl.info["GL_RENDERER"]
    found = getattr(frame_4k, mode)()
    assert found.name == f"gl-4k-{mode.replace('_', '-')}"
    assert found.time_s == found.limit_s == 0.5
    assert ("sky_s" in found.more) == (mode != "sh")
    assert found.more["device_mb"] > 0.1
    assert found.more["device"] == device
