"""A folder of PBR textures that is dropped on the window: the material, its maps, the mode, and the project's file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PySide6.QtWidgets import QWidget

from app.document.modes import mode_named, why_not
from app.window.main_window import MainWindow
from engine.brdf.models.openpbr import OpenPbr
from engine.images.encode import encode_png


@pytest.fixture
def textures(tmp_path: Path) -> Path:
    folder = tmp_path / "rock"
    folder.mkdir()
    for name, value in (("rock_color", 188), ("rock_roughness", 102), ("rock_metallic", 0)):
        (folder / f"{name}.png").write_bytes(encode_png(np.full((8, 8, 3), value, np.uint8)))
    return folder


@pytest.fixture
def filled(window: MainWindow, qtbot: Any, textures: Path, drop: Callable[[QWidget, list[Path]], None]) -> MainWindow:
    with qtbot.waitSignal(window.bench.document.changed, timeout=120_000):
        drop(window, [textures])
    return window


def test_dropped_textures_are_the_material(filled: MainWindow, qtbot: Any) -> None:
    project = filled.bench.document.project
    assert project.name == "rock"
    assert project.material.pbr is not None
    assert why_not(mode_named("shading-map"), project) == ""
    filled.show_workspace("material")
    page = filled.material.maps
    assert filled.material.pages.currentWidget() is page
    assert [page.which.itemText(at) for at in range(page.which.count())][:3] == ["Base colour", "Normals", "Roughness"]
    assert page.mean.text() == "0.503, 0.503, 0.503"
    page.which.setCurrentIndex(2)
    page.which.activated.emit(2)
    assert page.mean.text() == "0.400"
    assert page.resolution.text() == "8 × 8 px"
    assert any("normal flat" in text for text in project.material.health.warnings)


def test_multiple_scattering_is_switched_and_undone(filled: MainWindow) -> None:
    filled.show_workspace("view")
    again, document = filled.view.brdf_panel.again, filled.bench.document
    assert again.isVisibleTo(filled)
    assert again.isChecked()
    again.click()
    material = document.project.material
    assert material.pbr is not None
    assert not material.pbr.multiple_scattering
    assert "multiple_scattering=0" in material.brdf
    document.undo_stack.undo()
    assert again.isChecked()


def test_multiple_scattering_has_one_control(filled: MainWindow) -> None:
    """The box of the maps, to which the BRDF at their mean belongs; without maps the slider of the BRDF."""
    filled.show_workspace("view")
    panel, document = filled.view.brdf_panel, filled.bench.document
    form = panel.form
    assert form is not None
    slider = form.editors["multiple_scattering"]
    assert panel.again.isVisibleTo(filled)
    assert not slider.isVisibleTo(filled)
    document.change("No maps", material=replace(document.project.material, pbr=None))
    assert not panel.again.isVisibleTo(filled)
    assert slider.isVisibleTo(filled)


def test_layers_offer_no_switch_of_multiple_scattering(filled: MainWindow) -> None:
    """OpenPBR always has it: a switch would do nothing."""
    filled.show_workspace("view")
    document = filled.bench.document
    material = document.project.material
    assert material.pbr is not None
    layered = replace(material.pbr, layers=OpenPbr(coat_weight=1.0))
    document.change("Coat", material=replace(material, pbr=layered))
    assert not filled.view.brdf_panel.again.isVisibleTo(filled)
