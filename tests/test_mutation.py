"""Wrong operators and constants of the engine: which tests concern them, and that the tests notice them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests import mutation
from tests.import_graph import PROJECT, changed_files, distances, nearest_module, select_tests

TEXT = '''
LIMIT = 3

def area(width: float = 1.0, *, whole: bool = False) -> float:
    """Width 1 times ä width."""
    assert width > 0.0
    if whole and width >= 2:
        raise ValueError(f"{width + 1} is too much")
    return "ä" and width * width
'''


def test_operators_comparisons_and_numbers_of_functions_are_exchanged() -> None:
    changes = [(each.before, each.after) for each in mutation.mutants_of("x.py", TEXT)]
    assert changes == [
        ("whole and width >= 2", "(whole or width >= 2)"),
        ("width >= 2", "(width > 2)"),
        ("2", "4"),
        ('"ä" and width * width', "('ä' or width * width)"),
        ("width * width", "(width / width)"),
    ]
    for each in mutation.mutants_of("x.py", TEXT):
        changed = each.apply_to(TEXT)
        assert changed != TEXT
        compile(changed, "x.py", "exec")


def test_a_seed_draws_the_same_changes_of_different_modules() -> None:
    chosen = mutation.draw(3, 12)
    assert chosen == mutation.draw(3, 12) != mutation.draw(4, 12)
    assert len({each.file for each in chosen}) == 12


def test_the_test_of_a_module_comes_first_and_nearer_ones_before_others() -> None:
    found = [path.relative_to(PROJECT / "tests").as_posix() for path in select_tests("engine.geometry.camera")]
    assert found[0] == "engine/geometry/test_camera.py"
    assert "app/view/test_camera.py" in found
    assert nearest_module("engine.core.errors.InputError.remedy") == "engine.core.errors"
    assert nearest_module("numpy.linalg") is None
    steps = distances(["engine.core.errors"])
    assert steps["engine.core.errors"] == 0
    assert steps["engine.storage.untrusted"] == 1


def test_files_that_differ_are_named_once() -> None:
    assert len(set(changed_files("HEAD"))) == len(changed_files("HEAD"))


def test_only_a_failure_that_the_change_causes_kills_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A test that fails anyway is passed over; without another the change survives."""
    (tmp_path / "m.py").write_text(TEXT)
    mutant = mutation.mutants_of("m.py", TEXT)[-1]
    monkeypatch.setattr(mutation, "PROJECT", tmp_path)
    monkeypatch.setattr(mutation, "module_of", lambda path: path.stem)
    monkeypatch.setattr(mutation, "select_tests", lambda _name: [tmp_path / "test_m.py"])
    (tmp_path / "test_m.py").touch()
    always, killing = "test_m.py::test_always", "test_m.py::test_area"

    def fail(copy: Path, words: list[str], *, without_opengl: bool) -> str | None:
        assert without_opengl
        is_changed = (copy / "m.py").read_text() != TEXT
        run = {always, killing} - set(words[1:]) if words[0] == "test_m.py" else {words[0]}
        return next((test for test in (always, killing) if test in run and (test == always or is_changed)), None)

    monkeypatch.setattr(mutation, "first_failure", fail)
    excused: set[str] = set()
    assert mutation.find_killer(mutant, tmp_path, 3, excused) == killing
    assert excused == {always}
    killing = "test_m.py::test_always"
    assert mutation.find_killer(mutant, tmp_path, 3, set()) is None
    assert (tmp_path / "m.py").read_text() == TEXT


def test_the_quickest_file_runs_first_and_what_ran_whole_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "m.py").write_text(TEXT)
    monkeypatch.setattr(mutation, "PROJECT", tmp_path)
    monkeypatch.setattr(mutation, "SECONDS", tmp_path / "cache" / "seconds.json")
    monkeypatch.setattr(mutation, "module_of", lambda path: path.stem)
    names = ["test_slow.py", "test_middle.py", "test_quick.py", "test_far.py"]
    monkeypatch.setattr(mutation, "select_tests", lambda _name: [tmp_path / name for name in names])
    for name in names:
        (tmp_path / name).touch()
    mutation.SECONDS.parent.mkdir()
    mutation.SECONDS.write_text(json.dumps({"test_slow.py": 9.0, "test_middle.py": 2.0, "test_quick.py": 1.0}))
    asked: list[list[str]] = []

    def fail(_copy: Path, words: list[str], *, without_opengl: bool) -> str | None:
        asked.append(words)
        return None

    with monkeypatch.context() as patch:
        patch.setattr(mutation, "first_failure", fail)
        assert mutation.find_killer(mutation.mutants_of("m.py", TEXT)[-1], tmp_path, 3, {"test_m.py::test_no"}) is None
    assert asked == [["test_quick.py", "test_middle.py", "test_slow.py", "--deselect", "test_m.py::test_no"]]
    report = tmp_path / "junit.xml"
    cases = "".join(
        f'<testcase classname="tests.{name}" time="{took}"/>' for name, took in (("a", 1), ("a", 2), ("b", 4))
    )
    report.write_text(f"<testsuites><testsuite>{cases}</testsuite></testsuites>")
    mutation.learn_seconds(report)
    assert mutation.known_seconds()["tests/a.py"] == 3.0
    assert mutation.known_seconds()["test_slow.py"] == 9.0


@pytest.mark.long
def test_changes_of_the_engine_are_noticed(request: pytest.FixtureRequest) -> None:
    """Thirty changes, drawn by `--seed`: 95 % are killed, by tests without OpenGL where the code needs none."""
    changes = mutation.draw(request.config.getoption("--seed") or 0, 30)
    survivors = mutation.run(changes, files=12)
    assert len(survivors) <= (1.0 - mutation.GOAL) * len(changes), "\n".join(map(str, survivors))
