"""The reference against closed forms, laws and the sums of the other renderer; Mitsuba has a file of its own."""

from __future__ import annotations

import dataclasses
import itertools
import threading
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from engine.accuracy.compare import ErrorEstimate, error_against_parts
from engine.brdf.brdf import Brdf, brdf_from_text
from engine.core.directions import Vectors, normalize, surface_direction, world_direction
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.ray_caster import RayCaster
from engine.geometry.shapes import shape
from engine.light.environment import EnvironmentMap, all_lights
from engine.light.lamps import Lamp
from engine.render.direct import Shader, radiance
from engine.render.path import power_weight
from engine.render.reference import ReferenceImage, pass_lengths, reference
from engine.scene.scene import Scene
from tests.engine.scenes import head_on, scene, weave

Floats = NDArray[np.float64]


def find(what: Scene, size: tuple[int, int] = (16, 16), samples: int = 64, **options: Any) -> ReferenceImage:
    return drain(reference(what, size, samples=samples, **options))


def constant(*colour: float) -> EnvironmentMap:
    return EnvironmentMap(np.full((2, 4, 3), colour or 1.0, np.float32))


def smooth_room(rows: int = 64) -> EnvironmentMap:
    """Light from all around that changes little over a texel."""
    y, x = (np.mgrid[:rows, : 2 * rows] + 0.5) * np.pi / rows
    wave = 1.5 + np.sin(x + 0.4) * np.sin(y) + 0.4 * np.cos(y)
    return EnvironmentMap((wave[..., None] * (1.0, 0.7, 0.4)).astype(np.float32))


def measure_coverage(image: ReferenceImage) -> NDArray[np.bool_]:
    return image.image[..., 3] == 1.0


def build(positions: ArrayLike, faces: ArrayLike) -> Mesh:
    """A mesh of separate flat triangles."""
    corners = np.asarray(positions, np.float64)[np.asarray(faces)]
    normal = normalize(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    count = 3 * len(corners)
    return Mesh(
        corners.reshape(-1, 3),
        np.repeat(normal, 3, axis=0).astype(np.float32),
        np.zeros((count, 2), np.float32),
        np.arange(count, dtype=np.int32).reshape(-1, 3),
        "built",
    )


# Closed forms


def test_a_diffuse_sphere_in_even_light_is_even() -> None:
    what = scene("sphere", brdf="lambert:albedo=0.6", environment=constant(1.0, 0.5, 0.25))
    image = find(what, samples=256)
    inside = image.image[measure_coverage(image), :3] / (0.6, 0.3, 0.15)
    assert inside.mean() == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_allclose(inside, 1.0, atol=0.05)


def test_a_directional_light_is_free_of_noise() -> None:
    light = tuple(world_direction(np.radians(70.0), np.radians(20.0)))
    what = dataclasses.replace(head_on(irradiance=2.0), light=light)
    image = find(what, (8, 8), samples=4)
    np.testing.assert_allclose(image.image[..., :3], 0.5 / np.pi * 2.0 * light[2], rtol=1e-6)
    assert image.variance is not None
    assert image.variance.max() < 1e-20


@pytest.mark.parametrize("radius", [0.01, 0.3])
def test_a_disc_lamp_lights_a_plane_by_its_irradiance(radius: float) -> None:
    direction = tuple(world_direction(np.radians(60.0), np.radians(10.0)))
    lamp = Lamp(direction, (1.0, 2.0, 3.0), radius)
    image = find(dataclasses.replace(head_on(irradiance=0.0), lamps=(lamp,)), (8, 8), samples=1024)
    truth = 0.5 / np.pi * np.array(lamp.irradiance) * direction[2]
    np.testing.assert_allclose(image.image[..., :3].mean(axis=(0, 1)), truth, rtol=2e-4)
    np.testing.assert_allclose(image.image[..., :3], np.broadcast_to(truth, (8, 8, 3)), rtol=5e-3)


def test_V10_a_long_wall_hides_its_form_factor_of_the_sky() -> None:
    """From the floor at the distance d, a wall of height h, infinitely long, hides (1 − cos atan(h / d)) / 2."""
    far, height, distance = 200.0, 1.0, 0.5
    floor = [(-far, 0, 0), (far, 0, 0), (far, 0, 9), (-far, 0, 9)]
    wall = [(-far, 0, 0), (far, 0, 0), (far, height, 0), (-far, height, 0)]
    mesh = build(floor + wall, [(0, 2, 1), (0, 3, 2), (4, 5, 6), (4, 6, 7)])
    camera = Camera((0.0, 3.0, distance), (0.0, 0.0, distance), (0.0, 0.0, -1.0), 0.05)
    what = Scene(mesh, camera, brdf_from_text("lambert:albedo=0.8"), environment=constant())
    open_share = 1.0 - (1.0 - np.cos(np.arctan(height / distance))) / 2.0
    image = find(what, (8, 8), samples=1024)
    assert image.image[..., :3].mean() == pytest.approx(0.8 * open_share, rel=2e-3)
    # one bounce more: what the wall reflects is not known in closed form here, but it is between 0 and its share
    more = find(what, (8, 8), samples=256, max_depth=2).image[..., :3].mean() - 0.8 * open_share
    assert 0.0 < more < 0.8 * (1.0 - open_share) * 0.8


def bowl(rows: int = 48) -> Scene:
    """The lower half of a sphere, seen from above."""
    sphere = shape("sphere")
    kept = (sphere.positions[sphere.faces, 1] <= 1e-9).all(axis=1)
    mesh = dataclasses.replace(sphere, faces=sphere.faces[kept])
    camera = Camera((0.0, 4.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), 15.0)
    return Scene(mesh, camera, brdf_from_text("lambert:albedo=0.8"), environment=constant())


@pytest.mark.parametrize("max_depth", [1, 2, 3, 40])
def test_light_in_a_bowl_is_a_geometric_series(max_depth: int) -> None:
    """On a sphere all form factors are alike: half of what a hemispherical bowl sends comes back to it."""
    share, albedo = 0.5, 0.8
    series = albedo * (1.0 - share) * sum((albedo * share) ** k for k in range(max_depth))
    image = find(bowl(), (12, 12), samples=256, max_depth=max_depth)
    assert measure_coverage(image).all()
    assert image.variance is not None
    error = image.image[..., :3].mean() - series
    assert abs(error) < 1e-3 * series + 4.5 * np.sqrt(image.variance[..., 0].sum()) / 144
    if max_depth == 40:
        assert series == pytest.approx(albedo * (1.0 - share) / (1.0 - albedo * share))


# Laws


def test_furnace_diffuse_knot_of_albedo_1_vanishes_in_even_light() -> None:
    """Of flat triangles: an interpolated normal takes from a surface what it points behind it."""
    knot = shape("torus-knot")
    what = scene("torus-knot", brdf="lambert:albedo=1", environment=constant())
    what = dataclasses.replace(what, mesh=build(knot.positions, knot.faces))
    image = find(what, (24, 24), samples=768, max_depth=200)
    inside = image.image[measure_coverage(image), :3]
    assert inside.mean() == pytest.approx(1.0, abs=1e-3)


FURNACE = ("ggx:kd=0,alpha=0.4,f0=1", "ashikhmin-shirley:kd=0.5,ks=0.05,nu=10,nv=100", "ward:kd=0.2,ks=0.4")


@pytest.mark.parametrize(
    ("text", "theta_deg"),
    [
        *zip(FURNACE, (80.0, 60.0, 0.0), strict=True),
        *(pytest.param(FURNACE[0], theta, marks=pytest.mark.long) for theta in (0.0, 60.0)),
        *(pytest.param(FURNACE[1], theta, marks=pytest.mark.long) for theta in (0.0, 80.0)),
        *(pytest.param(FURNACE[2], theta, marks=pytest.mark.long) for theta in (60.0, 80.0)),
    ],
)
def test_furnace_shows_the_albedo(text: str, theta_deg: float) -> None:
    """A plane in even light shows the integral of f cos, here over a grid of directions."""
    brdf, theta = brdf_from_text(text), np.radians(theta_deg)
    camera = Camera((1e3 * np.sin(theta), 0.0, 1e3 * np.cos(theta)), fov_deg=0.01)
    what = Scene(shape("plane"), camera, brdf, environment=constant())
    image = find(what, (8, 8), samples=4096 if theta_deg < 70 else 8192)
    assert image.image[..., :3].mean() == pytest.approx(albedo_of(brdf, theta), abs=1e-3)


def albedo_of(brdf: Brdf, theta: float, rows: int = 1200) -> float:
    edges = np.linspace(0.0, 0.5 * np.pi, rows + 1)
    middle, step = 0.5 * (edges[1:] + edges[:-1]), edges[1] - edges[0]
    phi = (np.arange(2 * rows) + 0.5) * np.pi / rows
    wi = surface_direction(middle[:, None], phi[None, :])
    f = brdf.f(wi, surface_direction(theta))[..., 0]
    return float(np.sum(f.mean(axis=1) * 2.0 * np.pi * np.cos(middle) * np.sin(middle)) * step)


@pytest.mark.parametrize("text", ["lambert:albedo=0.5", "phong:exponent=20", "ggx:alpha_x=0.1,alpha_y=0.4"])
def test_V2_a_convex_model_shows_what_the_sums_without_shadows_show(text: str) -> None:
    """Single pixels within their own uncertainty, tangents and interpolated normals and all."""
    what = scene("sphere", brdf=text, environment=smooth_room(32), environment_rotation=0.6)
    size, parts = (16, 12), 3
    assert what.environment is not None
    lights = all_lights(what.environment).rotate(0.6)
    row, column = np.mgrid[: parts * size[1], : parts * size[0]].reshape(2, -1)
    blocks = Shader(what, (parts * size[0], parts * size[1]))(row, column, lights)
    truth = blocks.reshape(size[1], parts, size[0], parts, 4).mean(axis=(1, 3))
    for max_depth in (1, 3):
        image = find(what, size, samples=256, max_depth=max_depth)
        inside = measure_coverage(image) & (truth[..., 3] == 1.0)
        assert image.variance is not None
        error = (image.image - truth)[inside][:, :3]
        deviation = np.sqrt(image.variance[inside] + (2e-3 * truth[inside][:, :3]) ** 2)
        assert (np.abs(error) < 5.5 * deviation).all()
        assert np.abs(error.mean(axis=0) / truth[inside][:, :3].mean(axis=0)).max() < 3e-3


@pytest.mark.parametrize("factor", [2.0**-20, 1e-6, 1e6])
def test_V3_the_size_of_the_model_does_not_matter(factor: float) -> None:
    options = {"environment": smooth_room(), "ground": Ground()}
    what = scene("torus-knot", brdf="lambert:albedo=0.5", **cast(Any, options))
    large = dataclasses.replace(what.mesh, positions=what.mesh.positions * factor)
    camera = dataclasses.replace(
        what.camera,
        eye=tuple(factor * np.asarray(what.camera.eye)),
        target=tuple(factor * np.asarray(what.camera.target)),
    )
    other = dataclasses.replace(what, mesh=large, camera=camera)
    one, two = (find(each, samples=16, max_depth=2).image for each in (what, other))
    np.testing.assert_allclose(one.mean(axis=(0, 1)), two.mean(axis=(0, 1)), rtol=2e-3)
    assert np.mean(np.abs(one - two) > 1e-3) < (1e-9 if factor == 2.0**-20 else 0.02)


def test_directional_light_from_behind_or_below_a_triangle_does_not_leak() -> None:
    """Normals that lean towards the light do not let it through a surface that turns its back to it."""
    plane = shape("plane")
    leaning = np.broadcast_to(np.float32(normalize((0.0, 0.6, 0.8))), plane.normals.shape)
    mesh = dataclasses.replace(plane, normals=leaning)
    what = dataclasses.replace(head_on(), mesh=mesh, light=tuple(normalize((0.0, 1.0, -0.1))))
    assert drain(radiance(what, (8, 8)))[..., :3].min() > 0.0  # without shadows it is lit
    assert find(what, (8, 8), samples=4, max_depth=3).image[..., :3].max() == 0.0


def test_a_triangle_does_not_light_itself() -> None:
    plane = shape("plane")
    leaning = np.broadcast_to(np.float32(normalize((0.0, 0.6, 0.8))), plane.normals.shape)
    mesh = dataclasses.replace(plane, normals=leaning)
    what = dataclasses.replace(head_on(brdf="lambert:albedo=1", environment=constant()), mesh=mesh)
    once, often = (find(what, (8, 8), 256, max_depth=max_depth).image for max_depth in (1, 4))
    np.testing.assert_allclose(once, often, rtol=1e-6)
    # seen is the sky above the plane alone: (1 + cos) / 2 of what the normals face
    assert once[..., :3].mean() == pytest.approx((1.0 + 0.8) / 2.0, abs=0.005)


# Materials


@pytest.mark.parametrize("source", ["slices", "power-law"])
@pytest.mark.parametrize("lookup", ["radiance", "texture", "angle"])
def test_a_material_is_looked_up_as_in_the_sums(source: Any, lookup: Any) -> None:
    """Large texels, so that neither filtering nor the edges of texels tell the two apart."""
    options = {"environment": smooth_room(24), "source": source, "lookup": lookup, "repeats": 0.5}
    what = head_on(weave(16, threads=1), "phong:exponent=20", **options)
    assert what.environment is not None
    row, column = np.mgrid[:32, :32].reshape(2, -1)
    blocks = Shader(what, (32, 32))(row, column, all_lights(what.environment))
    truth = blocks.reshape(8, 4, 8, 4, 4).mean(axis=(1, 3))[..., :3]
    image = find(what, (8, 8), samples=256)
    assert image.variance is not None
    deviation = np.sqrt(image.variance + (2e-3 * truth) ** 2)
    assert (np.abs(image.image[..., :3] - truth) < 5.5 * deviation).all()
    assert image.image[..., :3].mean() == pytest.approx(truth.mean(), rel=5e-3)


def test_a_lookup_outside_the_sum_has_no_reference() -> None:
    with pytest.raises(ValueError, match="all light at once"):
        find(head_on(weave(8), lookup="outgoing"))


# Uncertainty


def test_the_stated_uncertainty_is_that_of_the_image() -> None:
    what = scene("torus-knot", brdf="ggx:alpha=0.3", environment=smooth_room(32), ground=Ground())
    images = [find(what, samples=32, seed=seed, max_depth=2) for seed in range(8)]
    truth = cast(Any, np.mean([each.image for each in images], axis=0, dtype=np.float64))[..., :3]
    error = np.mean([(each.image[..., :3] - truth) ** 2 for each in images]) * 8 / 7
    stated = np.mean([each.variance for each in images])
    assert error / stated == pytest.approx(1.0, abs=0.15)
    reported = images[0].uncertainty_rmse_rel
    assert reported is not None
    assert reported == pytest.approx(np.sqrt(error / np.mean(truth**2)), rel=0.3)


def test_more_samples_are_surer() -> None:
    what = scene("sphere", brdf="lambert:albedo=0.5", environment=smooth_room(16))
    noise = [find(what, samples=samples).uncertainty_rmse_rel for samples in (16, 256)]
    assert noise[1] < 0.25 * noise[0] * 1.1  # type: ignore[operator]


@pytest.mark.parametrize("samples", [1, 2, 5, 16, 31, 100, 513])
def test_passes_hold_all_samples(samples: int) -> None:
    lengths = list(pass_lengths(samples))
    assert sum(lengths) == samples
    assert len(lengths) >= min(16, samples)
    image = find(head_on(), (4, 4), samples=samples)
    assert image.samples == samples
    assert image.passes == len(lengths)
    assert (image.variance is None) == (samples == 1)


def test_passes_without_end_begin_small_and_double() -> None:
    assert list(itertools.islice(pass_lengths(None, 2), 10)) == [1, 1, 1, 1, 2, 2, 4, 4, 8, 8]


def test_without_end_all_parts_have_as_many_samples_and_tell_the_error_of_any_image(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of an image that is 10 % too bright the error is found at every round, without bias; the interval covers it."""
    monkeypatch.setattr("engine.render.reference.SHOWN_EVERY", 0.0)
    what = scene("sphere", brdf="ggx:alpha=0.3", environment=smooth_room(32))
    truth = find(what, (32, 32), samples=1024, seed=9)
    inside = truth.image[..., 3] == 1.0
    errors: dict[int, list[ErrorEstimate]] = {}
    for seed in range(6):
        steps = reference(what, (32, 32), samples=None, seed=seed)
        seen: list[int] = []
        for step in steps:
            parts = step.partial.parts if step.partial is not None else None
            if parts is not None and id(parts) not in seen:
                seen.append(id(parts))
                errors.setdefault(len(seen), []).append(error_against_parts(1.1 * truth.image, parts, inside))
                assert len(parts) == 8
                assert step.partial.variance is not None
            if len(seen) == 4:
                break
        steps.close()
    for each in errors.values():
        assert np.mean([one.rmse_rel for one in each]) == pytest.approx(0.1, abs=0.005)
    every = [one for each in errors.values() for one in each]
    assert sum(abs(one.rmse_rel - 0.1) <= one.uncertainty for one in every) >= 0.85 * len(every)


# Repeatability and steps


def test_images_depend_on_the_seed_and_not_on_the_threads() -> None:
    what = scene("torus-knot", brdf="ggx:alpha=0.3", environment=smooth_room(16), ground=Ground())
    size = (140, 130)  # several batches a sweep
    one, two, three = (find(what, size, samples=3, max_depth=3, threads=threads) for threads in (1, 2, 3))
    for other in (two, three):
        np.testing.assert_array_equal(one.image, other.image)
        np.testing.assert_array_equal(one.variance, other.variance)
    assert one.rays == two.rays
    other = find(what, size, samples=3, max_depth=3, seed=10**30)
    assert (one.image != other.image).any()
    assert one.image.mean() == pytest.approx(other.image.mean(), rel=0.02)


def test_without_end_images_become_better_until_they_are_closed() -> None:
    before = threading.active_count()
    steps = reference(scene("sphere", environment=smooth_room(16)), (48, 48), samples=None)
    shown: list[ReferenceImage] = []
    while len(shown) < 3 or shown[-1].variance is None:
        step = next(steps)
        if step.partial is not None:
            shown.append(step.partial)
    steps.close()
    assert threading.active_count() == before
    assert [each.samples for each in shown] == sorted(each.samples for each in shown)
    assert np.isfinite(shown[-1].image).all()
    noise = shown[-1].uncertainty_rmse_rel
    assert noise is not None
    assert 0.0 < noise < 0.5


def test_GL7_any_size() -> None:
    for size in ((0, 0), (1, 1), (1, 40), (40, 1), (0, 5)):
        assert find(head_on(), size, samples=2).image.shape == (size[1], size[0], 4)


@pytest.mark.parametrize("wrong", [{"samples": 0}, {"max_depth": 0}, {"seed": -1}])
def test_numbers_that_make_no_sense_are_refused(wrong: dict[str, int]) -> None:
    with pytest.raises(ValueError, match="must"):
        drain(reference(head_on(), (4, 4), **wrong))


# Hard cases


def test_EN6_a_sun_of_a_million_is_neither_lost_nor_cut() -> None:
    """One texel, almost a directional light of the same irradiance."""
    radiance = np.zeros((128, 256, 3), np.float32)
    radiance[32, 128] = 1e6
    what = scene("torus-knot", brdf="phong:exponent=20", environment=EnvironmentMap(radiance))
    assert what.environment is not None
    sun = all_lights(what.environment)
    bright = int(np.argmax(sun.irradiance[:, 0]))
    light, irradiance = tuple(sun.direction[bright]), float(sun.irradiance[bright, 0])
    image = find(what, (24, 18), samples=256)
    small = find(dataclasses.replace(what, environment=None, light=light, irradiance=irradiance), (24, 18), samples=256)
    assert image.image.mean() == pytest.approx(small.image.mean(), rel=0.01)
    noise = image.uncertainty_rmse_rel
    assert noise is not None
    assert noise < 0.05


@pytest.mark.parametrize("options", [{"environment": constant(0, 0, 0)}, {"irradiance": 0.0}])
def test_without_light_the_model_is_black(options: dict[str, Any]) -> None:
    image = find(scene("sphere", **options), samples=2, max_depth=3)
    assert image.image[..., :3].max() == 0.0
    assert image.image[..., 3].max() == 1.0
    assert image.uncertainty_rmse_rel == 0.0


def test_nothing_in_view_is_transparent() -> None:
    what = dataclasses.replace(scene("sphere", environment=constant()), camera=Camera((0, 0, 9), (0, 0, 20)))
    assert find(what, samples=2).image.max() == 0.0


def test_a_camera_inside_a_closed_model_sees_no_light() -> None:
    what = dataclasses.replace(scene("sphere", environment=constant()), camera=Camera((0, 0, 0.2), (0, 1, 0.3)))
    image = find(what, samples=16, max_depth=4)
    assert measure_coverage(image).all()
    assert image.image[..., :3].max() == 0.0


@dataclass(frozen=True)
class Broken:
    """Not a number at every third direction."""

    isotropic, reciprocal, energy_conserving = True, True, False

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        wi, _ = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        value = np.full(wi.shape, 0.2)
        value[np.sin(1e3 * wi[..., 0]) > 0.5] = np.nan
        return value


def test_GL1_samples_that_are_not_finite_are_counted_and_black() -> None:
    what = dataclasses.replace(scene("sphere", environment=constant()), brdf=Broken())
    image = find(what, samples=16, max_depth=2)
    assert np.isfinite(image.image).all()
    assert image.variance is not None
    assert np.isfinite(image.variance).all()
    assert image.rejected > 0


def test_a_ground_receives_a_shadow_and_keeps_its_albedo() -> None:
    what = scene("sphere", brdf="lambert:albedo=0", light=(0.0, 1.0, 0.0), ground=Ground(albedo=0.7))
    eye = np.array((0.0, 30.0, 0.1))
    what = dataclasses.replace(what, camera=Camera(tuple(eye), fov_deg=12.0))
    image = find(what, (32, 32), samples=4).image[..., 0]
    assert image[2, 2] == pytest.approx(0.7 / np.pi, rel=1e-6)
    assert image[16, 16] == 0.0  # the black model hides its own shadow from above
    slanted = dataclasses.replace(what, light=tuple(normalize((1.0, 1.0, 0.0))))
    shaded = find(slanted, (32, 32), samples=4).image[..., 0]
    lit = 0.7 / np.pi * np.sqrt(0.5)
    assert shaded[2, 2] == pytest.approx(lit, rel=1e-6)
    assert (shaded[:, :16] < 0.1 * lit).sum() > (shaded[:, 16:] < 0.1 * lit).sum() + 20


def test_lamps_and_environment_add_up() -> None:
    lamp = Lamp((0.3, 0.8, 0.5), (1.0, 2.0, 3.0), 0.2)
    sun = Lamp((-0.3, 0.8, 0.5), (2.0, 1.0, 0.5))
    parts: list[dict[str, Any]] = [
        {"environment": smooth_room(16)},
        {"irradiance": 0.0, "lamps": (lamp,)},
        {"irradiance": 0.0, "lamps": (sun,)},
    ]
    whole = find(scene("torus-knot", environment=smooth_room(16), lamps=(lamp, sun)), samples=64)
    single = [find(scene("torus-knot", **options), samples=64) for options in parts]
    summed = np.sum([each.image[..., :3].mean(axis=(0, 1), dtype=np.float64) for each in single], axis=0)
    np.testing.assert_allclose(whole.image[..., :3].mean(axis=(0, 1)), summed, rtol=5e-3)


def test_what_is_lifted_stays_close_to_the_triangle() -> None:
    """The caster of a coarse sphere sees no shadow from points between its vertices."""
    coarse = scene("sphere", brdf="lambert:albedo=1", environment=constant())
    step = np.linspace(0, 2 * np.pi, 13)[:-1]
    rings = [surface_direction(theta, step) for theta in np.linspace(0.0, np.pi, 9)]
    positions = np.concatenate(rings)
    faces = []
    for row in range(8):
        for column in range(12):
            a, b = row * 12 + column, row * 12 + (column + 1) % 12
            faces += [(a, a + 12, b + 12), (a, b + 12, b)]
    kept = [face for face in faces if len(np.unique(positions[list(face)].round(9), axis=0)) == 3]
    mesh = Mesh(
        positions,
        positions.astype(np.float32),
        np.zeros((len(positions), 2), np.float32),
        np.array(kept, np.int32),
        "coarse",
    )
    assert RayCaster(mesh.positions, mesh.faces).extent == pytest.approx(1.0)
    image = find(dataclasses.replace(coarse, mesh=mesh, camera=frame(mesh.positions)), samples=256)
    inside = image.image[measure_coverage(image), :3]
    assert inside.mean() == pytest.approx(1.0, abs=0.002)  # 0.995 from the triangles themselves
    assert inside.min() > 0.9


def test_shares_of_two_ways_to_a_light_sum_to_1_however_different_their_densities() -> None:
    one, two = np.meshgrid([0.0, 5e-324, 1e-200, 1e-3, 1.0, 1e15, 1e300], [0.0, 1e-300, 1.0, 2.0, 1e300])
    shares = power_weight(one, two) + power_weight(two, one)
    np.testing.assert_allclose(shares, np.where((one > 0.0) | (two > 0.0), 1.0, 0.0))
    assert power_weight(np.array([2.0]), np.array([1.0])) == pytest.approx(0.8)


def test_polished_models_are_finite_and_lose_no_light() -> None:
    """Mirrors but for a ten-thousandth: an even room is mirrored as it is."""
    what = scene("sphere", brdf="ggx:kd=0,alpha=0.0001,f0=1", environment=constant())
    image = find(what, samples=64)
    assert image.rejected == find(what, samples=4, max_depth=4).rejected == 0
    assert image.image[measure_coverage(image), :3].mean() == pytest.approx(1.0, abs=1e-3)
