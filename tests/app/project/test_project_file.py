"""Project files: what is written is read again, whatever was open, undone, killed, moved or removed."""

from __future__ import annotations

import contextlib
import dataclasses
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.making import material_of, stack_of
from app.document.comparison import MARKERS, Comparison, Entry
from app.document.document import ImportChoices, Look, Project, Step
from app.document.factoring import RUN_NUMBERS, Factoring, Run
from app.document.measured import Accuracy, scene_key
from app.document.scene import scene_of_project
from app.project import places
from app.project.copying import collect, copy
from app.project.database import APPLICATION
from app.project.photographs import files_of, keep, take_marks
from app.project.project_file import KEPT_STEPS, History, Writer, data_folder, read, state_name
from app.project.report import describe, identity, problems_of
from engine.brdf.brdf import MODELS, brdf_from_text
from engine.capture.lights.sources import find
from engine.core.colour import REC_2020
from engine.core.errors import InputError, OutputError
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import drain
from engine.factor.settings import FactorSettings
from engine.geometry.camera import Camera
from engine.geometry.shapes import shape
from engine.light.lamps import LampSettings
from engine.scene.material import Material, material_of_maps
from engine.shading.shading_map import ShadingMap
from engine.surface.pbr_maps import PbrMaps, clip_wide
from tests.engine.domes import dome_material


def write(path: Path, project: Project, steps: tuple[Step, ...] = ()) -> Path:
    writer = Writer(path)
    writer.write(History(project, steps, len(steps)))
    writer.close()
    return path


@pytest.mark.parametrize("number", [0, RUN_NUMBERS - 1])
def test_every_number_that_a_run_can_get_is_read_again(tmp_path: Path, number: int) -> None:
    """Numbers of runs are drawn by chance; a project must not be called damaged for one of them."""
    run = Run(number, len(MARKERS) - 1, "Phong", "model:phong", FactorSettings(), "phong")
    project = Project(factoring=Factoring(runs=(run,), current=number))
    found = read(write(tmp_path / "a.lap", project)).current.factoring
    assert (found.current, found.runs[0].number, found.runs[0].identity) == (number, number, len(MARKERS) - 1)


def same(left: Any, right: Any) -> bool:
    """Equality by value, also of what is compared by identity."""
    if isinstance(left, np.ndarray):
        return isinstance(right, np.ndarray) and left.dtype == right.dtype and np.array_equal(left, right)
    if dataclasses.is_dataclass(left) and not isinstance(left, type):
        names = [part.name for part in dataclasses.fields(left)]
        return type(left) is type(right) and all(same(getattr(left, name), getattr(right, name)) for name in names)
    if isinstance(left, tuple):
        return isinstance(right, tuple) and len(left) == len(right) and all(map(same, left, right))
    return bool(left == right)


def shading_map() -> ShadingMap:
    slices = np.linspace(0.0, 1.0, 3 * 4 * 5 * 3, dtype=np.float32).reshape(3, 4, 5, 3)
    return ShadingMap(slices, 1.0, np.array([0.1, 0.5, 1.0]))


def full(photographs: Path) -> Project:
    """A project with something of each kind."""
    entries = tuple(Entry(name, kind(), at % 12) for at, (name, kind) in enumerate(MODELS.items()))
    return Project(
        sources=find([photographs]),
        import_choices=ImportChoices(outline=(1.0, 2.5, 3.0), highlights={"a.png": (0.5, 1.0)}),
        excluded=frozenset({"felt_10deg.png"}),
        material=Material(
            shading_map(),
            None,
            brdf="ggx:alpha=0.3",
            elevation_deg=(10.0, 90.0),
            name="Felt",
            health=Health({"condition": float("inf")}),
        ),
        provenance={"software": "test", "list": [1, 2.5, None, {"deep": True}]},
        mesh=shape("sphere"),
        look=Look(lamps=(LampSettings(),), light_theta_deg=12.25, forced=("shadows",)),
        comparison=Comparison(entries, (photographs / "x.binary",)),
        name="Felt – größer",
    )


def test_a_project_is_read_as_it_was_written(tmp_path: Path, photographs: Path) -> None:
    project = full(photographs)
    opened = read(write(tmp_path / "Felt.lap", project))
    assert not opened.missing
    for part in dataclasses.fields(Project):
        assert same(getattr(opened.current, part.name), getattr(project, part.name)), part.name


def test_a_directional_material_is_read_as_it_was_written(tmp_path: Path) -> None:
    project = Project(material=dome_material(), representation="directional", name="Dome")
    opened = read(write(tmp_path / "Dome.lap", project))
    assert not opened.missing
    assert opened.current.representation == "directional"
    before, found = project.material.directional, opened.current.material.directional
    assert before is not None
    assert found is not None
    for part in dataclasses.fields(before):
        assert same(getattr(found, part.name), getattr(before, part.name)), part.name
    assert np.array_equal(found.table, before.table)


def test_colours_beyond_rec709_are_read_as_they_were_written(tmp_path: Path) -> None:
    plain = np.full((4, 6), 0.5, np.float32)
    colours = np.random.default_rng(1).random((4, 6, 3), np.float32)
    base, _, wide = clip_wide(REC_2020, colours, None)
    normal = np.zeros((4, 6, 3), np.float32)
    normal[..., 2] = 1.0
    maps = PbrMaps(base, normal, plain, plain, plain, wide=wide)
    found = read(write(tmp_path / "Wide.lap", Project(material=material_of_maps(maps, "wide")))).current.material.pbr
    assert wide is not None
    assert found is not None
    assert found.wide is not None
    assert (found.wide.space, found.wide.clipped) == ("rec2020", wide.clipped)
    np.testing.assert_array_equal(found.wide.base_colour, colours)


def test_what_was_measured_under_lamps_on_a_ground_is_kept(tmp_path: Path) -> None:
    look = Look(lamps=(LampSettings(),), has_ground=True)
    scene = scene_of_project(Project(look=look), shape("sphere"), brdf_from_text("lambert"), Camera((0.0, 0.0, 3.0)))
    accuracy = Accuracy((), scene_key(scene, 2), (32, 24), 4, "test")
    found = read(write(tmp_path / "a.lap", Project(accuracy=accuracy, look=look))).current.accuracy
    assert found is not None
    assert (found.of[1], found.of[8]) == (look.ground, (LampSettings().lamp,))


def test_a_state_has_the_same_name_without_being_written(tmp_path: Path, photographs: Path) -> None:
    project = full(photographs)
    path = write(tmp_path / "Felt.lap", project)
    assert state_name(project, data_folder(path)) == identity(path)["state"]
    other = dataclasses.replace(project, look=Look())
    assert state_name(other, data_folder(path)) != identity(path)["state"]


def test_states_of_the_history_share_what_they_shared(tmp_path: Path) -> None:
    first = Project(mesh=shape("sphere"))
    second = dataclasses.replace(first, look=Look(gain=2.0))
    third = dataclasses.replace(second, look=first.look)
    steps = (Step("Gain", "gain 1", first, second), Step("Gain", "", second, third))
    opened = read(write(tmp_path / "a.lap", third, steps))
    assert [(step.text, step.gesture) for step in opened.steps] == [("Gain", "gain 1"), ("Gain", "")]
    assert opened.position == 2
    states = [opened.state(str(state)) for step in opened.steps for state in (step.old, step.new)]
    assert [state.look.gain for state in states] == [1.0, 2.0, 2.0, 1.0]
    assert len({id(state.mesh) for state in (*states, opened.current)}) == 1
    assert states[1] is states[2]


def test_only_the_latest_steps_are_kept_and_a_long_session_stays_small(tmp_path: Path) -> None:
    path, writer, steps, current = tmp_path / "a.lap", Writer(tmp_path / "a.lap"), [], Project()
    for at in range(400):
        new = dataclasses.replace(current, look=Look(gain=1.0 + at / 1000))
        steps.append(Step("Gain", "", current, new))
        current = new
        if at % 20 == 19:
            writer.write(History(current, tuple(steps), len(steps)))
    writer.close()
    opened = read(path)
    assert len(opened.steps) == opened.position == KEPT_STEPS
    assert opened.current.look.gain == current.look.gain
    assert path.stat().st_size < 5e6 / 5


def test_what_was_undone_can_be_done_again_after_a_restart(tmp_path: Path) -> None:
    first, second = Project(), Project(look=Look(gain=2.0))
    writer = Writer(tmp_path / "a.lap")
    writer.write(History(second, (Step("Gain", "", first, second),), 1))
    writer.write(History(first, (Step("Gain", "", first, second),), 0))
    writer.close()
    opened = read(tmp_path / "a.lap")
    assert opened.position == 0
    assert opened.current.look.gain == 1.0
    assert opened.state(str(opened.steps[0].new)).look.gain == 2.0


def test_steps_of_an_opened_project_are_written_again_without_reading_them(tmp_path: Path) -> None:
    first, second = Project(), Project(look=Look(gain=2.0))
    path = write(tmp_path / "a.lap", second, (Step("Gain", "", first, second),))
    opened = read(path)
    third = dataclasses.replace(opened.current, name="Third")
    write(path, third, (*opened.steps, Step("Name", "", opened.current, third)))
    again = read(path)
    assert [step.text for step in again.steps] == ["Gain", "Name"]
    assert again.state(str(again.steps[0].old)).look.gain == 1.0


def test_what_can_be_made_again_may_be_deleted(tmp_path: Path, photographs: Path) -> None:
    path = write(tmp_path / "a.lap", full(photographs))
    shutil.rmtree(data_folder(path))
    opened = read(path)
    assert opened.missing
    assert opened.current.mesh is None
    assert opened.current.material.shading_map is None
    assert opened.current.material.brdf == "ggx:alpha=0.3"
    assert len(opened.current.comparison.entries) == len(MODELS)


@pytest.mark.parametrize("at", [0, 1000, 5000])
def test_damage_is_named_and_never_a_traceback(tmp_path: Path, photographs: Path, at: int) -> None:
    path = write(tmp_path / "a.lap", full(photographs))
    content = bytearray(path.read_bytes())
    content[at : at + 400] = bytes(range(200)) * 2
    path.write_bytes(content)
    with contextlib.suppress(InputError, OutputError):
        drain(problems_of(path))


def test_no_class_but_those_of_the_document_is_made(tmp_path: Path) -> None:
    path = write(tmp_path / "a.lap", Project())
    with sqlite3.connect(path) as connection:
        (text,) = connection.execute("SELECT parts FROM state").fetchone()
        connection.execute("UPDATE state SET parts = ?", (text.replace('"name"', '"nothing"'),))
        connection.execute("UPDATE value SET text = ?", ('{"is": "Popen", "of": {"args": "true"}}',))
    connection.close()
    with pytest.raises(InputError, match="damaged"):
        read(path)


def test_a_newer_version_and_other_files_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.lap", Project())
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE meta SET value = '999' WHERE name = 'schema'")
    connection.close()
    with pytest.raises(InputError, match=r"newer version .lightarc .*schema 999; this one"):
        read(path)
    other = tmp_path / "b.lap"
    with sqlite3.connect(other) as connection:
        connection.execute("CREATE TABLE a(b)")
        connection.execute(f"PRAGMA application_id={APPLICATION + 1}")
    connection.close()
    with pytest.raises(InputError, match="not a Lightarc project"):
        read(other)
    (tmp_path / "c.lap").write_bytes(b"no database" * 1000)
    with pytest.raises((InputError, OutputError)):
        read(tmp_path / "c.lap")


def test_a_project_that_was_removed_is_written_anew(tmp_path: Path) -> None:
    path, writer = tmp_path / "a.lap", Writer(tmp_path / "a.lap")
    writer.write(History(Project(name="One")))
    path.unlink()
    writer.write(History(Project(name="Two")))
    writer.close()
    assert read(path).current.name == "Two"


def test_a_second_process_finds_it_claimed_and_a_dead_one_leaves_it_interrupted(tmp_path: Path) -> None:
    path = tmp_path / "a.lap"
    words = f"claim(Path({str(path)!r}))"
    program = f"from pathlib import Path; from app.project.places import claim; print({words}, flush=True); input()"
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", program], text=True, **pipes) as other:
        assert other.stdout is not None
        assert other.stdout.readline().strip() == "True"
        assert not places.claim(path)
        assert not places.was_interrupted(path)
        other.kill()
    assert places.was_interrupted(path)
    assert places.interrupt(tmp_path) == [path]
    assert places.claim(path)
    places.release(path)
    assert not places.was_interrupted(path)


def test_a_copy_has_all_and_a_collected_project_opens_without_its_photographs(
    tmp_path: Path, photographs: Path
) -> None:
    images = tmp_path / "pictures"
    shutil.copytree(photographs, images)
    path = write(tmp_path / "a.lap", full(images))
    drain(copy(path, tmp_path / "b.lap"))
    assert not read(tmp_path / "b.lap").missing
    keep(path, drain(take_marks(files_of(read(path).current))))
    drain(collect(path, tmp_path / "away" / "c.lap"))
    shutil.rmtree(images)
    (tmp_path / "away").rename(tmp_path / "elsewhere")
    found = describe(tmp_path / "elsewhere" / "c.lap")
    assert found["missing"] == []
    assert len(found["photographs"]) == 5
    assert not drain(problems_of(tmp_path / "elsewhere" / "c.lap"))
    assert describe(path)["missing"] == describe(path)["photographs"]
    with pytest.raises(InputError, match="missing"):
        drain(collect(path, tmp_path / "d.lap"))
    assert not (tmp_path / "d.lap").exists()
    assert not data_folder(tmp_path / "d.lap").exists()


def test_photographs_that_moved_with_the_project_are_found(tmp_path: Path, photographs: Path) -> None:
    together = tmp_path / "together"
    shutil.copytree(photographs, together / "pictures")
    write(together / "a.lap", full(together / "pictures"))
    together.rename(tmp_path / "moved")
    assert describe(tmp_path / "moved" / "a.lap")["missing"] == []


SESSION = """
import dataclasses, sys
from pathlib import Path
from app.document.document import Look, Project, Step
from app.project.project_file import History, Writer
from engine.geometry.shapes import shape
writer, current, steps = Writer(Path(sys.argv[1])), Project(mesh=shape("sphere")), ()
for at in range(10_000):
    new = dataclasses.replace(current, look=Look(gain=1.0 + at / 1000), name=str(at))
    steps, current = (*steps, Step("Gain", "", current, new))[-50:], new
    writer.write(History(current, steps, len(steps)))
    print(at, flush=True)
"""


@pytest.mark.campaign(rounds=300)
def test_every_acknowledged_gesture_is_there_after_a_kill(tmp_path: Path, seed: int) -> None:
    path, random = tmp_path / "a.lap", np.random.default_rng(seed)
    with subprocess.Popen([sys.executable, "-c", SESSION, str(path)], stdout=subprocess.PIPE, text=True) as session:
        assert session.stdout is not None
        session.stdout.readline()
        time.sleep(float(random.uniform(0.0, 0.4)))
        os.kill(session.pid, signal.SIGKILL)
        acknowledged = int(session.stdout.read().split()[-1] or 0)
    opened = read(path)
    assert int(opened.current.name) in (acknowledged, acknowledged + 1)
    assert opened.current.mesh is not None
    assert not drain(problems_of(path))


def test_the_verb_shows_checks_and_collects(tmp_path: Path, photographs: Path, lightarc: Any) -> None:
    path = write(tmp_path / "a.lap", full(photographs))
    assert lightarc("project", "info", path, "--json").code == 0
    assert "The project is sound." in lightarc("project", "verify", path).out
    keep(path, drain(take_marks(files_of(read(path).current))))
    listed = lightarc("project", "collect", path, "-o", tmp_path / "b.lap")
    assert listed.code == 3
    assert str(photographs / "felt_10deg.png") in listed.err
    assert not (tmp_path / "b.lap").exists()
    assert lightarc("project", "collect", path, "-o", tmp_path / "b.lap", "--include-outside").code == 0
    assert read(tmp_path / "b.lap").current.name == "Felt – größer"
    assert lightarc("project", "collect", path, "-o", tmp_path / "b.lap").code != 0
    assert lightarc("project", "info", tmp_path / "none.lap").code == 3


def test_the_last_change_is_that_of_the_document_and_not_of_the_file(tmp_path: Path, photographs: Path) -> None:
    path = write(tmp_path / "a.lap", full(photographs))
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE meta SET value = '1480-05-01T00:00:00+00:00' WHERE name = 'changed'")
    opened = read(path)
    with contextlib.closing(Writer(path)) as writer:
        writer.write(History(opened.current, opened.steps, opened.position))
    shutil.copy(path, tmp_path / "b.lap")
    assert describe(tmp_path / "b.lap")["last_change"].startswith("1480")
    write(path, dataclasses.replace(opened.current, notes="Linen"))
    assert describe(path)["last_change"].startswith("20")


def test_photographs_that_are_gone_are_said_once(tmp_path: Path, photographs: Path, lightarc: Any) -> None:
    path = write(tmp_path / "a.lap", full(shutil.copytree(photographs, tmp_path / "photographs")))
    (tmp_path / "photographs").rename(tmp_path / "moved")
    found = lightarc("project", "verify", path)
    assert found.code == 3
    assert found.out.count("missing") + found.err.count("missing") == 1, found


def test_brdfs_that_were_measured_are_within_the_file(tmp_path: Path) -> None:
    from engine.brdf.table import HalfDifferenceTable

    values = np.random.default_rng(3).random((4, 5, 6, 3))
    table = HalfDifferenceTable(values, np.zeros((4, 5, 6), bool), "measured", "table")
    entry = Entry("measured", table, 0, path=tmp_path / "gone.binary")
    path = write(tmp_path / "a.lap", Project(comparison=Comparison((entry,))))
    shutil.rmtree(data_folder(path))
    again = read(path).current.comparison.entries[0].brdf
    directions = np.array([[0.3, 0.1, 0.9], [0.0, 0.5, 0.8]])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    assert np.array_equal(again.f(directions, directions[::-1]), table.f(directions, directions[::-1]))
    assert brdf_from_text("lambert").f(directions, directions).shape == (2, 3)


def test_a_start_that_was_killed_does_not_hide_the_work_of_the_session_before(tmp_path: Path) -> None:
    begin = """
import os, signal, sys
from pathlib import Path
from app.document.document import Project, Step
from app.project.places import claim, new_path
from app.project.project_file import History, Writer
path, project, later = new_path(Path(sys.argv[1])), Project(), Project(name="Felt")
claim(path)
work = (later, (Step("Name", "", project, later),), 1) if len(sys.argv) > 2 else (project,)
Writer(path).write(History(*work))
os.kill(os.getpid(), signal.SIGKILL)
"""
    folder = places.projects_folder()
    for words in (["work"], [], []):
        subprocess.run([sys.executable, "-c", begin, str(folder), *words], check=False)
    (found,) = places.interrupt(folder)
    assert read(found).current.name == "Felt"
    assert list(folder.glob("*.lap")) == [found]


def test_a_project_that_has_a_place_of_its_own_is_found_interrupted_among_the_recent_ones(tmp_path: Path) -> None:
    path, other = write(tmp_path / "own" / "Felt.lap", Project(name="Felt")), tmp_path / "own" / "photographs"
    other.mkdir()
    recent = [other, tmp_path / "gone" / "Old.lap", path]
    assert places.interrupt(tmp_path / "projects", recent) == []
    words = f"from pathlib import Path; from app.project.places import claim; claim(Path({str(path)!r}))"
    subprocess.run([sys.executable, "-c", words], check=True, cwd=Path(__file__).parents[3])
    assert places.interrupt(tmp_path / "projects", recent) == [path]
    assert places.claim(path)
    assert places.interrupt(tmp_path / "projects", recent) == []
    places.release(path)


def test_photographs_that_were_left_out_worry_nobody_any_more(tmp_path: Path, photographs: Path) -> None:
    sources, choices = find([photographs]), ImportChoices(motion="none")
    stack = drain(stack_of(sources, choices, tmp_path / "stack"))
    doubt = Health(findings=(Finding(Verdict.WARNING, "is in doubt", stack.sources[1]),))
    stack = dataclasses.replace(stack, health=doubt)
    for excluded in (frozenset[str](), frozenset(stack.sources[1:2])):
        project = Project(
            sources=sources, import_choices=choices, imported_with=choices, stack=stack, excluded=excluded
        )
        project = dataclasses.replace(project, material=drain(material_of(project)))
        assert any("in doubt" in text for text in project.material.health.warnings) == (not excluded)
        told = describe(write(tmp_path / "a.lap", project))["warnings"]
        assert any("in doubt" in text for text in told) == (not excluded)
