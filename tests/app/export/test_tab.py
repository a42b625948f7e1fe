"""From the window to a bundle and back: everything that the Material workspace makes, and disks that fail."""

from __future__ import annotations

import dataclasses
import errno
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt

from app.document.document import Look
from app.document.variation import VariedParameter
from app.project.report import identity
from app.window.main_window import MainWindow
from engine.bundle.bundle import open_bundle
from engine.bundle.manifest import describe_bundle
from engine.core.colour import luminance
from engine.core.figure_text import size_text
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.scene.material import Material, error_figures
from engine.storage import atomic
from engine.surface.recover import recover
from tests.app.window.test_main_window import fill
from tests.engine.exchange.materials import dome_stack, measure_maps
from tests.present import present


@pytest.fixture
def tab(window: MainWindow, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setattr("app.commands.export_bundle.SIZE", (160, 120))
    fill(window)
    roughen(window)
    window.bench.write_into(tmp_path)
    window.show_workspace("export")
    window.export.name.setText("felt.lightarc")
    return window.export


def test_ctrl_enter_writes_the_bundle_beside_what_was_written_last(
    window: MainWindow, tab: Any, qtbot: Any, tmp_path: Path
) -> None:
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow, timeout=30_000)
    qtbot.keyClick(window, Qt.Key.Key_Return, Qt.KeyboardModifier.ControlModifier)
    qtbot.waitUntil((tmp_path / "felt.lightarc").exists, timeout=60_000)
    rest(window, qtbot)
    assert window.settings.now.output_folder == str(tmp_path)


def test_parts_that_the_material_lacks_are_unchecked_and_say_why(window: MainWindow, tab: Any) -> None:
    box, figure = tab.parts["planes"]
    assert (box.isChecked(), box.isEnabled(), figure.text()) == (False, False, "needs lamps all round")
    assert box.toolTip() == "This material has none: needs lamps all round"
    material, box = window.bench.document.project.material, tab.parts["power-law"][0]
    assert box.isChecked()
    for found, checked in ((None, False), (material.power_law, True)):
        window.bench.document.change("Power law", material=dataclasses.replace(material, power_law=found))
        assert (box.isChecked(), box.isEnabled()) == (checked, checked)
    box.click()
    window.bench.document.change("Name", name="Felt")
    assert not box.isChecked()


def test_maps_of_the_surface_are_offered_and_what_is_left_out_belongs_to_the_project(
    window: MainWindow, tab: Any
) -> None:
    document, (box, figure) = window.bench.document, tab.parts["pbr"]
    assert (box.isChecked(), box.isEnabled(), figure.text()) == (False, False, "make them in Material")
    made = dataclasses.replace(drain(recover(dome_stack(), np.arange(24))), maps=measure_maps(48, 64))
    document.change("Make surface maps", surface=made, surface_from=document.project.surface_recipe)
    assert (box.isChecked(), box.isEnabled()) == (True, True)
    assert figure.text() == size_text(made.maps.size_bytes)
    box.click()
    assert document.project.exporting.left_out == {"pbr"}
    assert "pbr" not in tab._list_chosen()
    document.undo_stack.undo()
    assert box.isChecked()
    document.change("Exclude", excluded=frozenset(["a rather long name of a photograph 10.tif"]))
    assert (box.isChecked(), box.isEnabled(), figure.text()) == (False, False, "out of date")


def roughen(window: MainWindow) -> None:
    """Make the right half of the filled stack too restless for a power law."""
    stack = window.bench.document.project.stack
    assert stack is not None
    radiance = stack.radiance[:]
    half = radiance[:, :, 32:]
    half *= np.random.default_rng(6).uniform(0.6, 1.4, half.shape[:3])[..., None]
    means = luminance(radiance).mean(axis=(1, 2), dtype=np.float64)
    window.bench.document.change("Rough", stack=dataclasses.replace(stack, radiance=radiance, mean_radiance=means))


def rest(window: MainWindow, qtbot: Any) -> None:
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=30_000)


def build(window: MainWindow, qtbot: Any, **settings: Any) -> Material:
    """The material of the filled stack with these settings."""
    window.bench.document.change("Settings", **settings)
    window.bench.build_material()
    rest(window, qtbot)
    return window.bench.document.project.material


def export(window: MainWindow, qtbot: Any) -> str:
    """Click, wait, and say what the window says."""
    rest(window, qtbot)
    qtbot.mouseClick(window.export.export, Qt.MouseButton.LeftButton)
    rest(window, qtbot)
    return window.export.verdict.text()


def assert_same(one: Material, other: Material) -> None:
    """Bit for bit, with everything that says how the material was made."""
    for name in ("slices", "r_max", "mean_radiance", "clipped", "order"):
        assert np.array_equal(getattr(one.shading_map, name), getattr(other.shading_map, name)), name
    for name in ("scale", "exponent", "r_max", "rms", "rms_per_channel", "error_map", "storage"):
        assert np.array_equal(getattr(one.power_law, name), getattr(other.power_law, name)), name
    assert one.power_law is not None
    kept, other_kept = one.power_law.kept, present(other.power_law).kept
    assert (kept is None) == (other_kept is None)
    if kept is not None:
        assert other_kept is not None
        assert np.array_equal(kept.place, other_kept.place)
        assert np.array_equal(kept.slices, other_kept.slices)
    for part in ("shading_map", "power_law"):
        assert dict(getattr(one, part).health.figures) == dict(getattr(other, part).health.figures)
    assert (one.elevation_deg, one.brdf, one.sigma) == (other.elevation_deg, other.brdf, other.sigma)


@pytest.mark.parametrize(
    ("settings", "suffix"),
    [
        pytest.param({"mixed": True, "error_bound_percent": 10.0}, ".lightarc", id="mixed", marks=pytest.mark.long),
        pytest.param({"exponent_bits": 8, "scale": "least-squares"}, "", id="8 bits", marks=pytest.mark.long),
        pytest.param(
            {"mixed": True, "error_bound_percent": 4.0, "exponent_bits": 16, "tileable": True},
            ".lightarc",
            id="mixed 16-bit tile",
        ),
        pytest.param(
            {"excluded": frozenset({"a rather long name of a photograph 90.tif"}), "slices": 6},
            "",
            id="excluded",
            marks=pytest.mark.long,
        ),
    ],
)
def test_what_the_material_workspace_makes_is_exported_verified_and_reopened(
    tab: Any, window: MainWindow, qtbot: Any, lightarc: Any, tmp_path: Path, settings: dict[str, Any], suffix: str
) -> None:
    made = build(window, qtbot, **settings)
    project = window.bench.document.project
    tab.name.setText(f"felt{suffix}")
    assert export(window, qtbot).startswith(f"felt{suffix} written and verified")
    target = tmp_path / f"felt{suffix}"
    done = lightarc("bundle", "verify", target)
    assert done.code == 0, done.err
    assert_same(open_bundle(target), made)
    manifest = describe_bundle(target)
    assert manifest["figures"] == error_figures(made)
    assert manifest["provenance"]["excluded_photographs"] == sorted(project.excluded)
    qtbot.waitUntil(lambda: window.projects.is_saved, timeout=30_000)
    assert manifest["provenance"]["project"] == identity(window.projects.path)
    chain = manifest["provenance"]["chain"]
    assert chain["steps"][-2:] == ["Settings", "Build material"]
    assert chain["material"]["slices"] == project.slices

    window.new()
    window.open([target])
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=30_000)
    rest(window, qtbot)
    reopened = window.bench.document.project
    assert_same(reopened.material, made)
    for name in ("slices", "tileable", "evened", "scale", "exponent_bits", "mixed"):
        assert getattr(reopened, name) == getattr(project, name), name
    if project.mixed:
        assert reopened.error_bound_percent == pytest.approx(project.error_bound_percent)
        assert made.power_law is not None
        assert made.power_law.kept is not None
        assert 0 < (made.power_law.kept.place >= 0).mean() < 1
    window.bench.write_into(tmp_path)
    window.show_workspace("export")
    window.export.name.setText("again.lightarc")
    assert "verified" in export(window, qtbot)
    again = describe_bundle(tmp_path / "again.lightarc")["provenance"]
    assert again.pop("project")["state"] != manifest["provenance"].pop("project")["state"]
    assert again == manifest["provenance"]


def test_a_bundle_brings_the_view_back_that_it_was_exported_with(
    tab: Any, window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    build(window, qtbot)
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)  # a model that comes later is framed anew
    document = window.bench.document
    look = Look(light_theta_deg=12.0, light_phi_deg=-170.0, gain=3.0, exposure_ev=-1.5, tone_map="aces", mode="direct")
    document.change("View", look=look)
    camera = Camera((3.0, 2.0, 1.0), (0.25, 0.25, 0.25), fov_deg=20.0)
    window.view.viewport.look_from(camera)  # as a drag does: the document alone would follow the view a moment later
    window.view.come_to_rest()
    assert document.project.camera == camera
    tab.name.setText("felt")
    assert "verified" in export(window, qtbot)
    window.new()
    assert document.project.look != look
    qtbot.waitUntil(lambda: not window.bench.jobs.active, timeout=60_000)
    window.open([tmp_path / "felt"])
    qtbot.waitUntil(lambda: document.project.has_map, timeout=30_000)
    assert document.project.look == look
    assert document.project.camera == camera
    window.undo.trigger()
    assert (document.project.look, document.project.camera) == (Look(), None)


def test_the_name_of_what_is_open_is_offered_and_not_that_of_the_material(
    tab: Any, window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    build(window, qtbot)
    assert "verified" in export(window, qtbot)
    (tmp_path / "felt.lightarc").rename(tmp_path / "felt, second try.lightarc")
    window.new()
    window.open([tmp_path / "felt, second try.lightarc"])
    qtbot.waitUntil(lambda: window.bench.document.project.has_map, timeout=30_000)
    qtbot.waitUntil(lambda: tab.name.text() == "felt, second try.lightarc")
    window.projects.copy_to(tmp_path / "Kimono.lap")
    qtbot.waitUntil(lambda: window.projects.path == tmp_path / "Kimono.lap", timeout=30_000)
    qtbot.waitUntil(lambda: tab.name.text() == "Kimono.lightarc")


def test_the_preview_is_the_scene_even_where_view_was_never_opened(
    tab: Any, window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    rest(window, qtbot)
    qtbot.waitUntil(lambda: tab.image.image is not None, timeout=30_000)
    assert "verified" in export(window, qtbot)
    import zipfile

    from engine.images.png import read_alpha, read_png

    with zipfile.ZipFile(tmp_path / "felt.lightarc") as packed:
        content = packed.read("preview.png")
    stored, opacity = read_png(content, "preview.png").samples, read_alpha(content, "preview.png")
    shown = tab.image.image.levels[0]
    assert stored.shape == (120, 160, 3)
    colour = shown.pixelColor(80, 60)
    assert stored[60, 80].tolist() == [colour.red(), colour.green(), colour.blue()]
    assert stored[60, 80].max() > 40
    assert (opacity[60, 80], opacity[0, 0]) == (255, 0), "what lies behind the model is seen"
    assert shown.pixelColor(0, 0).alpha() == 0


def test_an_outdated_material_says_so_before_it_is_exported(tab: Any, window: MainWindow, qtbot: Any) -> None:
    build(window, qtbot)
    assert not tab.stale.isVisible()
    assert not tab.varied.isVisible()
    window.bench.document.change("Vary", variations=(VariedParameter("alpha", 0.2, 0.6),))
    assert tab.varied.isVisible()
    window.bench.document.change("Mixed", mixed=True)
    assert tab.stale.isVisible()
    window.undo.trigger()
    assert not tab.stale.isVisible()


def test_a_bundle_of_the_same_name_is_announced_and_other_files_are_left_alone(
    tab: Any, window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    assert tab.export.text() == "Export bundle"
    export(window, qtbot)
    assert tab.export.text() == "Replace bundle"
    letter = tmp_path / "letter.lightarc"
    letter.write_text("Dear reader")
    tab.name.setText("letter.lightarc")
    assert "cannot be replaced" in export(window, qtbot)
    assert letter.read_text() == "Dear reader"


@pytest.mark.parametrize(
    ("operation", "code", "said"),
    [
        ("write", errno.ENOSPC, "disk is full"),
        pytest.param("create", errno.EROFS, "read-only", marks=pytest.mark.long),
        pytest.param("fsync", errno.EIO, "error", marks=pytest.mark.long),
    ],
)
def test_a_failing_disk_is_named_and_leaves_the_earlier_bundle(
    tab: Any,
    window: MainWindow,
    qtbot: Any,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    operation: str,
    code: int,
    said: str,
) -> None:
    export(window, qtbot)
    before = open_bundle(tmp_path / "felt.lightarc")
    build(window, qtbot, slices=6)

    def fail(now: str, _path: Path) -> None:
        if now == operation:
            raise OSError(code, os.strerror(code))

    monkeypatch.setattr(atomic, "fault", fail)
    assert said in export(window, qtbot)
    qtbot.waitUntil(lambda: len(window.failures.open_dialogs) == 1, timeout=5000)
    monkeypatch.setattr(atomic, "fault", None)
    assert_same(open_bundle(tmp_path / "felt.lightarc"), before)
    assert [path.name for path in tmp_path.iterdir() if "partial" in path.name] == []
    assert tab.export.isEnabled()
    assert "verified" in export(window, qtbot)


def test_a_folder_that_may_not_be_written_to_is_named_before(tab: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    folder, access = tab.bench.output_folder, os.access  # of the whole process, which also writes the project

    def refuse(path: Any, mode: int, **options: Any) -> bool:
        return path != folder and access(path, mode, **options)

    monkeypatch.setattr("app.export.tab.os.access", refuse)
    tab.bench.output_moved.emit(tab.bench.output_folder)
    assert not tab.export.isEnabled()
    assert "another folder" in tab.export.toolTip()


def test_a_cancelled_export_leaves_nothing_and_can_be_repeated(
    tab: Any, window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    rest(window, qtbot)
    tab.start()
    assert tab.export.toolTip() == "The bundle is being written"
    window.bench.jobs.cancel(tab.exporting)
    rest(window, qtbot)
    assert tab.verdict.text() == "Cancelled. Nothing was written."
    assert list(tmp_path.glob("*.lightarc")) == []
    assert "verified" in export(window, qtbot)


def test_a_material_that_was_undone_meanwhile_does_not_come_back(tab: Any, window: MainWindow, qtbot: Any) -> None:
    rest(window, qtbot)
    document = window.bench.document
    window.bench.build_material()
    while document.undo_stack.canUndo():
        document.undo_stack.undo()
    assert document.project.stack is None
    rest(window, qtbot)
    assert not document.project.has_map
    assert document.undo_stack.canRedo()


def test_any_order_of_undo_and_redo_shows_what_the_project_holds(tab: Any, window: MainWindow, qtbot: Any) -> None:
    build(window, qtbot, exponent_bits=8, mixed=True, error_bound_percent=5.0)
    build(window, qtbot, tileable=True, slices=6)
    window.show_workspace("material")
    stack, steps = window.bench.document.undo_stack, np.random.default_rng(4).integers(0, 2, 60)
    for step in steps:
        (stack.undo if step else stack.redo)()
    while stack.canRedo():
        stack.redo()
    rest(window, qtbot)
    project, material = window.bench.document.project, window.material
    assert material.slices.currentText() == "6"
    assert material.bits.currentData() == 8
    assert project.material.power_law is not None
    height, width = project.material.power_law.scale.shape[:2]
    assert material.resolution.text() == f"{width} × {height} px"
    assert material.image.image is not None
    assert material.image.image.size == (width, height)
    assert not window.failures.open_dialogs


def test_credits_of_the_project_go_before_those_of_photographs(
    tab: Any, window: MainWindow, qtbot: Any, tmp_path: Path
) -> None:
    """What photographs state stands in grey; what is written in its place is one step, and reaches the bundle."""
    document = window.bench.document
    stack = document.project.stack
    assert stack is not None
    said = {"author": "Ada Ng", "licence": "CC0-1.0"}
    document.change("Import", stack=dataclasses.replace(stack, provenance={**stack.provenance, "credits": said}))
    fields = tab.credits.fields
    assert (fields["author"].text(), fields["author"].placeholderText()) == ("", "Ada Ng")
    fields["author"].setText("Zoë")
    fields["author"].editingFinished.emit()
    assert window.export.elsewhere.credits.fields["author"].text() == "Zoë"
    assert document.project.exporting.settings.credits.author == "Zoë"
    export(window, qtbot)
    kept = open_bundle(tab.target).credits
    assert (kept.author, kept.licence) == ("Zoë", "CC0-1.0")
    document.undo_stack.undo()
    assert fields["author"].text() == ""
