"""`lightarc figures` as a user types it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from app.cli.figures import report
from engine.figures.papers.catalogue import FIGURES
from tests.app.command import Command


def test_a_figure_is_drawn_from_one_command(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    ran = lightarc("figures", "wang-2", "wang-2", "--mesh", mesh, "--quick", "-o", tmp_path / "out", "--json")
    assert ran.code == 0, ran.err
    found = json.loads(ran.out)
    [figure] = found["figures"]
    folder = tmp_path / "out" / figure["name"]
    assert (folder / figure["picture"]).is_file()
    assert all((folder / plot).is_file() for plot in figure["plots"])
    compared = [image for image in found["pictures"] if image["error_rmse_rel"] is not None]
    assert [image["knobs"]["terms"] for image in compared] == 2 * [1, 2, 4]
    assert {"name", "panel", "knobs", "error_rmse_rel", "error_uncertainty"} <= set(compared[0])
    files = [folder / "radiance" / compared[0][name] for name in ("radiance", "reference")]
    known = json.loads(lightarc("compare", *files, "--json").out)
    # silhouettes count here, and do not in the figure
    assert known["rmse_rel"] == pytest.approx(compared[0]["error_rmse_rel"], rel=0.3)
    shown = report(found)
    assert "K = 4" in shown
    assert "%" in shown


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("wang-9",), 2, "unknown figure 'wang-9' (did you mean"),
        (("wang-2", "--mesh", "nowhere.obj"), 3, "nowhere.obj"),
        (("wang-2", "--env", "nowhere.hdr"), 3, "nowhere.hdr"),
    ],
)
def test_mistakes_get_a_sentence(
    lightarc: Command, tmp_path: Path, words: tuple[str, ...], code: int, said: str
) -> None:
    ran = lightarc("figures", *words, "--quick", "-o", tmp_path / "out")
    assert ran.code == code
    assert said in ran.err
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_place_of_the_folder_is_refused(lightarc: Command, mesh: Path, tmp_path: Path) -> None:
    ran = lightarc("figures", "wang-2", "--mesh", mesh, "--quick", "-o", mesh)
    assert ran.code == 3
    assert "tetrahedron.obj" in ran.err


def test_cancelling_leaves_no_figure(
    lightarc: Command, mesh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("engine.figures.papers.wang_2.compare_with", interrupt)
    ran = lightarc("figures", "wang-2", "--mesh", mesh, "--quick", "-o", tmp_path / "out")
    assert ran.code == 4
    assert not (tmp_path / "out").exists()


def test_cancelling_later_keeps_the_figures_that_are_complete(
    lightarc: Command, mesh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("engine.figures.papers.wang_3.compare_with", interrupt)
    ran = lightarc("figures", "wang-2", "wang-3", "--mesh", mesh, "--quick", "-o", tmp_path / "out", "--json")
    assert ran.code == 4
    found = json.loads(ran.out)
    assert found["cancelled"]
    assert [figure["name"] for figure in found["figures"]] == ["wang-2"]
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["wang-2"]


def test_every_figure_says_what_it_shows(lightarc: Command) -> None:
    said = " ".join(lightarc("figures", "-h").out.split())
    assert all(name in said for name in FIGURES)
