"""The plots as files: all values that are shown, under their angles; and the ranking of models."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any

import numpy as np

from app.brdf.fit_section import Ranking
from app.commands import brdf as commands_brdf
from app.widgets.plot_files import distinct, grid, table
from app.window.main_window import MainWindow
from engine.brdf.brdf import brdf_from_text
from engine.brdf.ranking import Offer


def read(content: bytes) -> list[list[str]]:
    return [*csv.reader(io.StringIO(content.decode()))]


def test_a_table_has_every_digit_and_a_name_for_each_column() -> None:
    x, y = np.array([-1.0, 0.5]), np.array([1.0 / 3.0, 2e-17])
    heading, *rows = read(table("angle", x, {"one, two": y}))
    assert heading == ["angle", "one, two"]
    assert [[float(value) for value in row] for row in rows] == [[-1.0, 1.0 / 3.0], [0.5, 2e-17]]


def test_a_grid_begins_at_0_degrees_of_both_angles() -> None:
    values = np.arange(9.0).reshape(3, 3)  # theta_d falls from row to row
    heading, *rows = read(grid(values))
    assert [float(angle) for angle in heading[1:]] == [15.0, 45.0, 75.0]
    assert [float(value) for value in rows[0]] == [15.0, 6.0, 7.0, 8.0]
    assert [float(value) for value in rows[2]] == [75.0, 0.0, 1.0, 2.0]


def test_equal_names_are_told_apart() -> None:
    assert distinct(["ggx", "ward", "ggx", "ggx"]) == ["ggx", "ward", "ggx (2)", "ggx (3)"]


def test_the_window_writes_what_it_shows(window: MainWindow, qtbot: Any, tmp_path: Path) -> None:
    tab = window.brdf
    window.show_workspace("brdf")
    commands_brdf.add_model(window.bench, "lambert:albedo=0.5")
    qtbot.waitUntil(lambda: bool(tab.known) and bool(tab.albedos), timeout=120_000)
    with qtbot.waitSignal(tab.save_plots(tmp_path / "plots").succeeded, timeout=60_000):
        pass
    files = {path.name: path.read_bytes() for path in (tmp_path / "plots").iterdir()}
    assert {name for name in files if name.endswith(".svg")} == {
        "plane-of-incidence.svg",
        "half-difference.svg",
        "albedo.svg",
    }
    assert all(b"<svg" in content[:400] for name, content in files.items() if name.endswith(".svg"))
    _, *rows = read(files["plane-of-incidence.csv"])
    above = [float(value) for angle, value in rows if abs(float(angle)) < 89.0]
    assert np.allclose(above, 0.5 / np.pi, rtol=1e-6)
    _, *rows = read(files["albedo.csv"])
    assert np.allclose([float(value) for _, value in rows], 0.5, atol=0.01)


def test_a_fit_of_the_ranking_becomes_an_entry(window: MainWindow, monkeypatch: Any, qtbot: Any) -> None:
    offers = [Offer(brdf_from_text("ggx:alpha=0.3"), 0.1, 0.2), Offer(brdf_from_text("ward"), 0.3, 0.4)]

    def all_models(_brdf: Any, _weighting: Any) -> Any:
        yield from ()
        return offers

    monkeypatch.setattr("app.brdf.fit_section.all_models", all_models)
    window.show_workspace("brdf")
    commands_brdf.add_model(window.bench, "lambert:albedo=0.5")
    section = window.brdf.inspector.fit
    section.rank.click()
    qtbot.waitUntil(lambda: section.ranking is not None, timeout=60_000)
    (ranking,) = window.findChildren(Ranking)
    assert [ranking.table.item(row, 0).text() for row in range(2)] == ["GGX", "Ward"]  # type: ignore[union-attr]
    ranking.add.click()
    (_, added) = window.bench.document.project.comparison.entries
    assert added.brdf == offers[0].brdf
    ranking.close()
