"""A BRDF model that is not part of the package: in texts, the window, a project and a bundle, without a change here."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import pytest

import lightarc
from app.document.comparison import Entry
from app.document.document import Project
from app.project.project_file import History, Writer, read
from app.view.brdf_panel import BrdfPanel
from engine.brdf.brdf import MODELS, brdf_from_text, brdf_to_text, label_of, register, unregister
from engine.brdf.models.model import Model
from engine.scene.material import Material
from tests.minnaert import Minnaert

TESTS = Path(__file__).resolve().parents[1]


@pytest.fixture
def minnaert() -> Iterator[type[Model]]:
    yield register(Minnaert)
    unregister(Minnaert)


def test_an_installed_package_adds_a_model_to_the_command_line(tmp_path: Path) -> None:
    """A distribution of its own, which declares the model by an entry point."""
    for name in ("minnaert.py", "minnaert.glsl"):
        shutil.copy(TESTS / name, tmp_path / f"moon_{name}")
    info = tmp_path / "moon-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: moon\nVersion: 1.0\n")
    entries = ["[lightarc.brdfs]", "minnaert = moon_minnaert:Minnaert", "bad = moon_nothing:X", ""]
    (info / "entry_points.txt").write_text("\n".join(entries))
    command = "import sys; sys.path.insert(0, sys.argv.pop(1)); from app.__main__ import main; sys.exit(main())"
    arguments = ["brdf", "eval", "minnaert:k=2,albedo=0.5", "--wi-deg", "60,0", "--wo-deg", "0,0", "--json"]
    done = subprocess.run(
        [sys.executable, "-c", command, str(tmp_path), *arguments], capture_output=True, text=True, cwd=TESTS.parent
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["values"][0] == pytest.approx([0.25 / np.pi] * 3)
    assert "The plug-in bad of the package moon cannot be used" in done.stderr


def test_a_model_from_outside_is_named_sampled_and_fitted(minnaert: type[Model]) -> None:
    brdf = brdf_from_text("minnaert:k=1.5")
    assert brdf == Minnaert(k=1.5)
    assert brdf_from_text(brdf_to_text(brdf)) == brdf
    assert label_of("minnaert") == "Minnaert"
    wo = np.tile((0.0, 0.0, 1.0), (4096, 1))
    wi = lightarc.sample_brdf(brdf, wo)
    weight = brdf.f(wi, wo)[:, 0] * wi[:, 2] / lightarc.evaluate_pdf(brdf, wi, wo)
    assert weight.mean() == pytest.approx(0.5 * 2.0 / 2.5, rel=0.02)  # the albedo: 2 a ∫ c^k dc
    assert lightarc.fit_brdf(brdf, "minnaert", samples=256).brdf.k == pytest.approx(1.5, rel=1e-3)


def test_the_window_offers_it_with_its_parameters(minnaert: type[Model], qtbot: Any) -> None:
    project = Project(material=Material(None, None, brdf="minnaert:k=1.5"))
    bench: Any = SimpleNamespace(document=SimpleNamespace(project=project), jobs=None)
    panel = BrdfPanel(bench)
    qtbot.addWidget(panel)
    panel.show_project(project)
    assert panel.choice.currentText() == "Minnaert"
    assert panel.form is not None
    assert panel.form.instance == Minnaert(k=1.5)


def test_a_project_keeps_it_and_a_bundle_too(minnaert: type[Model], tmp_path: Path) -> None:
    from engine.bundle.portable import shader

    brdf = Minnaert(k=1.75)
    project = Project()
    project = replace(project, comparison=replace(project.comparison, entries=(Entry("moon", brdf, 0),)))
    writer = Writer(tmp_path / "moon.lap")
    writer.write(History(project, (), 0))
    writer.close()
    assert read(tmp_path / "moon.lap").current.comparison.entries[0].brdf == brdf
    photographs = np.linspace(0.1, 1.0, 3)[:, None, None, None] * np.ones((3, 8, 8, 3), np.float32)
    material = lightarc.compress_material(lightarc.build_material(photographs, slices=3, brdf=brdf))
    lightarc.save_bundle(tmp_path / "moon.lightarc", material)
    assert lightarc.open_bundle(tmp_path / "moon.lightarc").reflectance == brdf
    assert lightarc.verify_bundle(tmp_path / "moon.lightarc").ok
    assert "pow(wi.z * wo.z" in shader(material)


def test_what_lacks_a_part_is_refused() -> None:
    @dataclass(frozen=True)
    class Nameless(Model):
        label: ClassVar[str] = "Nameless"
        energy_conserving: ClassVar[bool] = True

    @dataclass(frozen=True)
    class Ggx(Model):
        name: ClassVar[str] = "other"
        label: ClassVar[str] = "Other"
        energy_conserving: ClassVar[bool] = True

    before = dict(MODELS)
    for model, words in ((Nameless, "states no name"), (Ggx, "another BRDF model"), (object, "derived from Model")):
        with pytest.raises(ValueError, match=words):
            register(model)  # type: ignore[arg-type]
    assert before == MODELS
