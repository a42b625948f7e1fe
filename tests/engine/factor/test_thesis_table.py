"""The table of the thesis: which rows there are, and that they are measured alike."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, drain
from engine.factor.data import factor_data
from engine.factor.textures import THESIS, SearchSettings, mccool
from engine.factor.thesis_table import FIGURE_4_2, Row, thesis_table


def test_every_method_has_its_rows_and_they_appear_one_by_one() -> None:
    settings = SearchSettings(terms=2, size=6, low_size=0, restarts=0, guesses=False)  # a search takes long
    brdfs = {"paint": brdf_from_text("lafortune:preset=blue-paint"), "metal": brdf_from_text("cook-torrance:m=0.4")}
    table = thesis_table(brdfs, settings=settings, count=400, max_theta=np.radians(70.0), pairs=500)
    steps: list[Step] = []
    while True:
        try:
            steps.append(next(table))
        except StopIteration as finished:
            rows: tuple[Row, ...] = finished.value
            break
    assert [row.brdf for row in rows] == ["paint"] * 10 + ["metal"] * 10
    kinds = [(row.method, row.parametrisation, row.reciprocal) for row in rows[:6]]
    assert kinds == [
        ("mccool", "", True),
        ("mccool", "", False),
        ("search", "in-out", True),
        ("search", "in-out", False),
        ("search", "half-diff", True),
        ("search", "half-diff", False),
    ]
    assert [(row.method, row.reciprocal) for row in rows[6:8]] == [("mccool", True), ("mccool", False)]
    assert [row.size_bytes for row in rows[6:8]] == [2 * 6 * 6 * 12, 3 * 4 * 4 * 12]
    assert [(row.method, row.parametrisation) for row in rows[8:10]] == [
        ("separable", "in-out"),
        ("separable", "half-diff"),
    ]
    assert all(row.size_bytes <= max(rows[5].size_bytes, 2 * 17 * 16 * 12) for row in rows[6:10])
    assert [row.textures for row in rows[:6]] == [2, 3, 2, 2, 2, 2]
    shown = [len(step.partial) for step in steps]
    assert shown == sorted(shown)
    assert shown[-1] == 20
    assert all(row.max_theta_deg == np.degrees(np.radians(70.0)) for row in rows)
    assert all(row.samples == 400 for row in rows)
    data = factor_data(brdfs["paint"], 400, np.radians(70.0))
    assert rows[0].metrics == drain(mccool(data, 6, reciprocal=True)).term_errors[-1].metrics
    for row in rows[2], rows[4], rows[12], rows[14]:
        assert row.metrics.sq_log <= rows[0 if row.brdf == "paint" else 10].metrics.sq_log


def test_the_figure_is_the_thesis_ones() -> None:
    assert replace(THESIS, size=24) == FIGURE_4_2
    assert FIGURE_4_2.terms == 5
