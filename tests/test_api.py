"""`import lightarc`: the declared names, their examples, and the wheel that installs them."""

from __future__ import annotations

import doctest
import inspect
import io
import re
import subprocess
import sys
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import trimesh

import lightarc
from engine.accuracy import bake_check
from engine.core.steps import Step, Steps
from engine.transport.baking.file import open_transport


def made_up_costs(*, anew: bool = False) -> Steps[object]:
    """The costs of a machine, whose measurement takes longer than all other tests of this module."""
    from engine.planning.costs.cost_model import NAMES, CostModel

    yield Step(float(anew), "the costs of this machine are made up")
    return CostModel("test", "test", dict.fromkeys(NAMES, ((1.0, 1e-6),)))


#: Functions whose examples compile the kernels of every transport method, which takes minutes where they are not kept,
#: or start processes.
SLOW = ("run_batch", "plan", "tradeoff", "draw_figures")


def test_examples_of_all_functions_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the order of `__all__`, in one folder and with the names of those before."""
    monkeypatch.chdir(tmp_path)
    run_examples([name for name in lightarc.__all__ if name not in SLOW])


@pytest.mark.long
def test_slow_examples_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("app.session.machine_profile.cost_model", made_up_costs)
    run_examples(SLOW)


def run_examples(names: Iterable[str]) -> None:
    finder, runner = doctest.DocTestFinder(recurse=False), doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    known: dict[str, object] = {"lightarc": lightarc}
    said: list[str] = []
    for name in names:
        function = getattr(lightarc, name)
        if not inspect.isfunction(function) or not function.__module__.startswith("lightarc."):
            continue
        (example,) = finder.find(function, name, globs={})
        assert example.examples, f"{name} has no example"
        example.globs = known
        runner.run(example, out=said.append, clear_globs=False)
    assert runner.failures == 0, "".join(said)


@pytest.mark.checked_bakes
def test_a_bake_ends_with_its_check_and_warns_of_what_is_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bake_check, "EDGE", 16)
    monkeypatch.setattr(bake_check, "SAMPLES", 4)
    monkeypatch.setattr("engine.transport.baking.check.MAX_MEAN", -1.0)  # no bake is so good
    words = ("plane", "lambert:albedo=0.6", tmp_path / "plane.transport")
    with pytest.warns(UserWarning, match="this bake differs from the reference: under studio"):
        path = lightarc.bake(*words, method="sh", order=3)
    check = open_transport(path).check
    assert check is not None
    assert [each.light for each in check.failed] == list(bake_check.check_lights())
    assert open_transport(lightarc.bake(*words, method="sh", order=3, check=False)).check is None


@pytest.mark.parametrize("size", [(0, 10), (10, -1), (10**6, 10**6), (1.5, 2), (1,), None])
def test_sizes_that_no_image_has_are_refused(size: Any) -> None:
    with pytest.raises(lightarc.UsageError, match="image size must be"):
        lightarc.render("sphere", size=size)


def test_nothing_but_its_own_errors_leaves_the_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong: Any = ("a", 2)
    for act in (
        lambda: lightarc.render("sphere", light_deg=wrong),
        lambda: lightarc.compare(np.zeros((2, 2, 4)), np.zeros((3, 2, 4))),
        lambda: lightarc.evaluate_brdf("ggx:alpha=.1,alpha=.2", [0, 0, 1], [0, 0, 1]),
        lambda: lightarc.evaluate_brdf("lambert", [[0, 0, 1]] * 2, [[0, 0, 1]] * 3),
        lambda: lightarc.open_stack("a\0b"),
        lambda: lightarc.save_image(tmp_path / "no" / "a.png", np.zeros((0, 0, 4), np.float32)),
        lambda: lightarc.open_bundle(tmp_path),
    ):
        with pytest.raises(lightarc.LightarcError):
            act()
    monkeypatch.setattr("engine.render.direct.radiance", lambda *_, **__: (_ for _ in ()).throw(MemoryError))
    with pytest.raises(lightarc.OutOfMemory):
        lightarc.render("sphere", size=(8, 8))


def test_negative_images_warn_of_nothing(recwarn: pytest.WarningsRecorder) -> None:
    lightarc.compare(np.full((8, 8, 3), -1.0, np.float32), np.full((8, 8, 3), -2.0, np.float32))
    assert not [each for each in recwarn if issubclass(each.category, RuntimeWarning)]


@pytest.mark.parametrize("name", [name for name in lightarc.__all__ if name[0].islower()])
def test_docstrings_have_the_sections_of_numpydoc(name: str) -> None:
    function = getattr(lightarc, name)
    if not inspect.isfunction(function) or not function.__module__.startswith("lightarc."):
        return
    text = inspect.getdoc(function) or ""
    wanted = ["Parameters", "Raises", "Examples"]
    if inspect.signature(function).return_annotation != "None":
        wanted.insert(1, "Returns")
    heads = [line for line, under in pairwise(text.splitlines()) if under == "-" * len(line) and line]
    assert [head for head in heads if head != "References"] == wanted
    listed = text[text.index("Parameters") : text.index("Raises")]
    for parameter in inspect.signature(function).parameters:
        assert re.search(rf"(?m)^(\*|\w+, )*\*?{parameter}\b[\w, ]*( :.*)?$", listed), f"{name} leaves {parameter} out"


def test_every_name_exists_and_is_typed() -> None:
    for name in lightarc.__all__:
        assert getattr(lightarc, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Gxg'"):
        _ = lightarc.Gxg


def test_earlier_names_are_deprecated_aliases() -> None:
    with pytest.warns(DeprecationWarning, match="lightarc.save_picture is now lightarc.save_image"):
        assert lightarc.save_picture is lightarc.save_image
    image = np.ones((2, 2, 4), np.float32)
    with pytest.warns(DeprecationWarning, match="picture of compare is called image"):
        assert lightarc.compare(picture=image, reference=image).rmse_rel == 0.0  # type: ignore[call-arg]


def test_importing_the_library_loads_neither_numpy_nor_qt() -> None:
    code = "import sys, lightarc; print([name for name in ('numpy', 'PySide6', 'cv2', 'scipy') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


VECTORS = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])


class Grey:
    """The BRDF of a user: no class of the library."""

    isotropic = reciprocal = energy_conserving = True

    def f(self, wi: Any, wo: Any) -> np.ndarray:
        return np.full(np.broadcast_shapes(np.shape(wi), np.shape(wo)), 0.1)


def test_meshes_come_as_trimesh_arrays_and_open_files(tmp_path: Path) -> None:
    sphere = trimesh.creation.icosphere(2)
    path = tmp_path / "ball.ply"
    sphere.export(path)
    with path.open("rb") as file:
        models: list[Any] = [sphere, (sphere.vertices, sphere.faces), trimesh.Scene(sphere), path, file]
        images = [lightarc.render(model, brdf=lightarc.Ggx(alpha=0.3), size=(24, 18), samples=1) for model in models]
    assert images[0][9, 12, 3] == 1.0
    assert all(np.allclose(image, images[0], atol=1e-3) for image in images[1:])


def test_lights_come_as_vectors_arrays_and_environments() -> None:
    def light_up(**light: Any) -> lightarc.Image:
        return lightarc.render("sphere", brdf="lambert", size=(24, 18), samples=1, **light)

    assert np.allclose(light_up(light=(0, 2, 0)), light_up(light_deg=(0, 0)), atol=1e-6)
    both = light_up(light=np.array([[0, 1, 0], [1, 0, 0]]))
    assert np.allclose(both[..., :3], (light_up(light=(0, 1, 0)) + light_up(light=[1, 0, 0]))[..., :3], atol=1e-6)
    furnace = light_up(environment=np.full((16, 32, 3), 2.0, np.float32))
    assert furnace[9, 12, 0] == pytest.approx(2.0 * 0.5, rel=0.03)  # radiance of the furnace times the albedo


def test_photographs_come_as_arrays_with_angles_or_vectors(tmp_path: Path) -> None:
    chance = np.random.default_rng(0)
    texture = chance.uniform(0.2, 0.8, (24, 24, 1))
    elevation = np.radians([90.0, 20.0, 55.0])
    photographs = (texture * np.sin(elevation)[:, None, None, None] * np.ones(3)).astype(np.float32)
    stack = lightarc.import_capture(photographs, tmp_path / "stack", angles_deg=[90, 20, 55], motion="none")
    assert stack.elevation_deg.tolist() == [20.0, 55.0, 90.0]
    assert np.array_equal(stack.radiance[:], photographs[[1, 2, 0]])
    vectors = np.column_stack([np.cos(elevation), np.zeros(3), np.sin(elevation)])
    again = lightarc.import_capture(photographs, tmp_path / "again", lights=vectors, motion="none")
    assert again.azimuth is not None
    assert np.allclose(again.elevation_deg, [20.0, 55.0, 90.0])
    material = lightarc.build_material(photographs, angles_deg=[90, 20, 55], slices=3)
    assert np.allclose(material.shading_map.slices, lightarc.build_material(stack, slices=3).shading_map.slices)  # type: ignore[union-attr]


def test_brdfs_come_as_classes_objects_and_samples() -> None:
    wi, wo = np.array([0.0, 0.0, 1.0]), VECTORS
    model = lightarc.Ggx(alpha=0.3)
    assert np.array_equal(model.eval(wi, wo), model.f(wi, wo))
    assert np.array_equal(lightarc.evaluate_brdf(lightarc.Ggx, wi, wo), lightarc.Ggx().f(wi, wo))
    u = np.random.default_rng(1).random((2, 3))
    assert np.array_equal(lightarc.sample_brdf(model, wo, u=u), model.sample(wo, u))
    assert np.array_equal(lightarc.evaluate_pdf(model, wi, wo), model.pdf(wi, wo))
    assert lightarc.fit_brdf((wi, wo, np.full(3, 0.2 / np.pi)), "lambert").brdf.albedo[0] == pytest.approx(
        0.2, rel=1e-3
    )
    assert lightarc.render("sphere", brdf=Grey(), size=(8, 8), samples=1).max() > 0
    with pytest.raises(lightarc.UsageError, match="must state isotropic, reciprocal, energy_conserving"):
        lightarc.render("sphere", brdf=SimpleNamespace(f=Grey().f))


def test_images_come_as_arrays_paths_and_open_files(tmp_path: Path) -> None:
    image = lightarc.render("sphere", brdf="lambert", size=(24, 18), samples=1)
    lightarc.save_image(tmp_path / "a.exr", image)
    held = io.BytesIO()
    lightarc.save_image(held, image)
    assert held.getvalue().startswith(b"\x89PNG")
    assert lightarc.compare(tmp_path / "a.exr", image).rmse_rel < 1e-3
    held.seek(0)
    lightarc.save_image(tmp_path / "a.png", image)
    assert lightarc.compare(held, tmp_path / "a.png").rmse_rel == 0.0
    codes = np.asarray(np.random.default_rng(0).integers(0, 256, (8, 8, 3)), np.uint8)
    assert lightarc.compare(codes, codes).rmse_rel == 0.0


@pytest.mark.parametrize(
    "call",
    [
        lambda: lightarc.render((np.zeros((3, 2)), np.zeros((1, 3), int))),
        lambda: lightarc.render((np.eye(3), np.array([[0, 1, 3]]))),
        lambda: lightarc.render((np.full((3, 3), np.nan), np.array([[0, 1, 2]]))),
        lambda: lightarc.render(np.float64(3)),  # type: ignore[arg-type]
        lambda: lightarc.render("sphere", light=(0, 0, 0)),
        lambda: lightarc.render("sphere", light=(0, 1)),
        lambda: lightarc.render("sphere", light=[]),
        lambda: lightarc.render("sphere", environment=np.ones((4, 4, 3))),
        lambda: lightarc.render("sphere", environment=-np.ones((4, 8, 3))),
        lambda: lightarc.render("sphere", brdf=object()),  # type: ignore[arg-type]
        lambda: lightarc.render("sphere", material=np.ones(3)),  # type: ignore[arg-type]
        lambda: lightarc.build_material(np.ones((1, 4, 4, 3))),
        lambda: lightarc.build_material(np.full((3, 4, 4, 3), np.inf)),
        lambda: lightarc.build_material(np.ones((3, 4, 4, 3)), angles_deg=[1, 2]),
        lambda: lightarc.import_capture(np.ones((3, 4, 4, 3)), "never"),
        lambda: lightarc.recover_normals(np.ones((3, 4, 4, 3))),
        lambda: lightarc.fit_brdf((VECTORS, VECTORS)),  # type: ignore[arg-type]
        lambda: lightarc.fit_brdf((2 * VECTORS, VECTORS, VECTORS)),
        lambda: lightarc.sample_brdf("lambert", [[0, 0, -1.0]]),
        lambda: lightarc.evaluate_pdf("lambert", "a", [[0, 0, 1.0]]),
        lambda: lightarc.compare(np.ones((2, 2)), "nothing.png"),
        lambda: lightarc.open_bundle(io.StringIO("text")),  # type: ignore[arg-type]
        lambda: lightarc.Ggx(alpha=2.0),
        lambda: lightarc.Ggx(alpha="wide"),  # type: ignore[arg-type]
    ],
)
def test_values_that_fit_no_kind_end_in_one_sentence(call: Any) -> None:
    with pytest.raises(lightarc.LightarcError) as found:
        call()
    assert "\n" not in str(found.value)


def test_values_say_in_one_line_what_they_are_and_show_themselves_in_notebooks() -> None:
    photographs = np.linspace(0.1, 1.0, 3)[:, None, None, None] * np.ones((3, 8, 8, 3), np.float32)
    material: Any = lightarc.build_material(photographs, slices=3, name="<grey>")
    scene = lightarc.make_scene("plane", material=material, environment=np.ones((4, 8, 3)))
    values: tuple[Any, ...] = (material, material.shading_map, scene.mesh, scene.environment)
    for value in values:
        assert "\n" not in repr(value)
        assert len(repr(value)) < 300
        assert "array(" not in repr(value)
        assert "<grey>" not in value._repr_html_()
    image = lightarc.render(scene, size=(8, 6), samples=1)
    assert repr(image) == "Image(8 × 6 pixels, 4 channels, float32)"
    assert image._repr_png_()[:4] == b"\x89PNG"  # type: ignore[index]
    assert scene.environment._repr_png_()[:4] == b"\x89PNG"  # type: ignore[union-attr]
