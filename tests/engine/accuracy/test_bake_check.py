"""The check of a bake: figures of images that are known, and a bake that is made too dark."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.accuracy.bake_check import ENVIRONMENTS, check_bake, check_file, check_lights, compare_views
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.shapes import open_mesh
from engine.light.environment import EnvironmentMap
from engine.render.reference import ReferenceImage
from engine.transport.baking.check import LAMP, BakeCheck
from engine.transport.baking.file import open_transport
from engine.transport.baking.spatially_varying import variation_from_text
from engine.transport.method import Subject, method_of
from engine.transport.sh.transfer import ShTransport
from tests.engine.planning.brute_force import sphere

pytestmark = pytest.mark.checked_bakes


def image(values: NDArray[np.float64]) -> NDArray[np.float32]:
    """A covered image of grey radiance."""
    return np.concatenate([np.repeat(values[..., None], 3, axis=2), np.ones((*values.shape, 1))], 2).astype(np.float32)


def truth(values: NDArray[np.float64], deviation: float = 0.0) -> ReferenceImage:
    return ReferenceImage(image(values), np.full((*values.shape, 3), deviation**2), 32, 16, 0, 0)


def test_equal_images_have_no_error() -> None:
    values = np.random.default_rng(1).uniform(0.5, 2.0, (8, 8))
    found = compare_views([image(values)], [truth(values)], "studio")
    assert (found.mean_rel, found.rmse_rel, found.dark, found.bright) == (0.0, 0.0, 0.0, 0.0)
    assert found.pixels == 64
    assert found.passes


def test_the_mean_is_that_of_the_worst_view() -> None:
    values = np.ones((8, 8))
    found = compare_views([image(1.01 * values), image(0.9 * values)], [truth(values)] * 2, "studio")
    assert found.mean_rel == pytest.approx(-0.1, abs=1e-6)
    assert found.rmse_rel == pytest.approx(np.sqrt((0.01**2 + 0.1**2) / 2), abs=1e-6)


def test_stains_and_bright_spots_are_counted() -> None:
    values, exact = np.ones((10, 10)), np.ones((10, 10))
    values[0, 0] = 0.09
    values[1, :2] = 10.1
    found = compare_views([image(values)], [truth(exact)], "studio")
    assert (found.dark, found.bright) == (0.01, 0.02)


def test_noise_of_the_reference_is_no_error() -> None:
    """Noise of 0.2 about 1 makes a pixel that reads 0.09 of the truth no stain, and adds nothing to the error."""
    rng = np.random.default_rng(5)
    exact = rng.normal(1.0, 0.1, (40, 40))
    found = compare_views([image(np.ones((40, 40)))], [truth(exact, 0.1)], "studio")
    assert found.rmse_rel < 0.03
    assert abs(found.mean_rel) < found.mean_uncertainty
    dark = compare_views([image(np.full((4, 4), 0.09))], [truth(np.ones((4, 4)), 0.2)], "studio")
    assert dark.dark == 0.0


def test_pixels_that_are_dark_in_the_reference_too_do_not_count() -> None:
    exact = np.ones((10, 10))
    exact[0] = 0.01
    values = exact.copy()
    values[0] = 0.0
    assert compare_views([image(values)], [truth(exact)], "studio").dark == 0.0


def test_lights_are_those_of_the_program_and_of_the_scene() -> None:
    own = EnvironmentMap(np.ones((4, 8, 3), np.float32), "mine")
    assert list(check_lights([own])) == ["mine", *ENVIRONMENTS, LAMP]


def bake_sphere(folder: Path) -> tuple[Subject, ShTransport, Path]:
    subject, method = Subject(sphere(24), brdf_from_text("lambert:albedo=0.5")), method_of("sh")
    path = folder / "sphere.transport"
    work = drain(method.baking.prepare(subject, method.settings(order=6)))
    return subject, drain(method.baking.bake(path, work)).transport, path


def test_a_bake_that_is_too_dark_is_reported(tmp_path: Path) -> None:
    """A diffuse sphere in spherical harmonics is right under soft light, and 20 % too dark with 80 % of its rows."""
    method = method_of("sh")
    subject, transport, path = bake_sphere(tmp_path)
    good = drain(check_file(path, transport, method, subject, method.settings(order=6)))
    assert isinstance(good, BakeCheck)
    assert open_transport(path).check == good
    studio = good.under("studio")[0]
    assert studio.passes
    assert abs(studio.mean_rel) < 0.01
    darker = replace(transport, rows=0.8 * transport.rows)
    found = drain(check_bake(darker, method, subject, method.settings(order=6)))
    assert found is not None
    assert found.under("studio")[0].mean_rel == pytest.approx(0.8 * (1.0 + studio.mean_rel) - 1.0, abs=0.004)
    assert not found.under("studio")[0].passes


def test_a_bake_that_varies_is_not_checked(tmp_path: Path) -> None:
    """The reference has no parameters that vary over the model."""
    method = method_of("sh")
    subject, transport, _ = bake_sphere(tmp_path)
    varied = replace(subject, variations=(variation_from_text("albedo=0.1:0.9:y"),))
    assert drain(check_bake(transport, method, varied, method.settings())) is None


def test_backs_of_open_surfaces_do_not_count(tmp_path: Path) -> None:
    """Bakes draw them black, and the reference lights them: a sheet is seen from behind by one of the views."""
    method = method_of("sh")
    subject = Subject(open_mesh("plane"), brdf_from_text("lambert:albedo=0.5"))
    work = drain(method.baking.prepare(subject, method.settings(order=6)))
    transport = drain(method.baking.bake(tmp_path / "plane.transport", work)).transport
    found = drain(check_bake(transport, method, subject, method.settings(order=6)))
    assert found is not None
    studio = found.under("studio")[0]
    assert studio.passes
    assert 0 < studio.pixels < found.edge**2
