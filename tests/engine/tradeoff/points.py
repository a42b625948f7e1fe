"""Measured points without a measurement."""

from __future__ import annotations

from typing import Any, cast

from hypothesis import strategies as st

from engine.planning.costs.setting import Setting
from engine.tradeoff.point import Point


def point(error: float, frame_s: float = 0.01, memory: int = 0, setting: Setting | None = None, **more: float) -> Point:
    figures = {"error_flip": 0.1, "error_uncertainty": 0.0, "relight_s": 0.0, "bake_s": 0.0, **more}
    return Point(
        setting or Setting("direct"),
        error_rmse_rel=error,
        frame_s=frame_s,
        memory_bytes=memory,
        size_bytes=memory,
        **cast(Any, figures),
    )


#: Few different values, so that ties are frequent.
VALUES = st.sampled_from([0.0, 0.01, 0.02, 0.05, 0.1, 0.4, 1.0])

POINTS = st.lists(
    st.builds(
        lambda error, unsure, frame, relight, bake, memory, directions: point(
            error,
            frame,
            memory,
            Setting("direct", {"directions": directions}),
            error_uncertainty=unsure,
            relight_s=relight,
            bake_s=bake,
        ),
        VALUES,
        st.sampled_from([0.0, 0.001, 0.01]),
        VALUES,
        VALUES,
        VALUES,
        st.integers(0, 5).map(lambda each: 10**each),
        st.integers(1, 64),
    ),
    max_size=12,
)
