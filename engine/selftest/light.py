"""Hard cases of SH, wavelets, Gaussians, visibility, environments and drawing, and of what a plan leaves out."""

from __future__ import annotations

import numpy as np

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.diffuse import Lambert
from engine.core.directions import normalize, world_from_tangent
from engine.core.steps import drain
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh
from engine.gl.context import create_context
from engine.gl.direct import DirectRenderer
from engine.light.cube_map import CubeMap, cube_directions, cube_of, cube_solid_angles
from engine.light.environment import EnvironmentMap, texel_directions
from engine.light.gaussian_prefilter import gaussian_integral, prefilter
from engine.light.lamps import lights_of_all
from engine.light.sun_split import split_sun
from engine.planning.effects.estimates import Scenery, self_shadowing
from engine.planning.effects.radiance import radiances
from engine.planning.effects.sample import sample
from engine.scene.scene import Scene
from engine.selftest.case import Found, Question
from engine.transport.baking.visibility import every_ray, miss_rate, receivers, visibility_cube
from engine.transport.gaussian.fitting.lobes import gaussian
from engine.transport.gaussian.fitting.views import nearest_views, view_directions
from engine.transport.sh.bake import BakeSettings, baker_of, prepare
from engine.transport.sh.basis import cosine_zonal, evaluate, turn_zonal, window
from engine.transport.sh.lighting import project
from engine.transport.sh.rotation import rotation
from engine.transport.sh.transfer import matrices, visibility_harmonics
from engine.transport.wavelet.haar import check_edge, cube_coefficients, cube_of_coefficients, strongest
from engine.transport.wavelet.quantise import (
    BOUNDS,
    WaveletLight,
    dequantise,
    encode_light,
    pack,
    quantise,
    unpack,
)
from engine.transport.wavelet.transfer import Vectors16, WaveletTransport, relight_transport

U64, U32 = 2.0**-53, 2.0**-24


def sphere(rows: int = 24) -> Mesh:
    """A closed convex sphere of a few hundred vertices."""
    theta, phi = np.meshgrid(np.pi * np.arange(1, rows) / rows, np.pi * np.arange(2 * rows) / rows, indexing="ij")
    ring = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], axis=-1).reshape(-1, 3)
    points = np.concatenate([ring, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]])
    index = np.arange(len(ring)).reshape(rows - 1, 2 * rows)
    right = np.roll(index, -1, axis=1)
    quads = [
        np.stack(c, -1).reshape(-1, 3)
        for c in ((index[:-1], index[1:], right[1:]), (index[:-1], right[1:], right[:-1]))
    ]
    caps = [
        np.stack([np.full(2 * rows, len(ring)), index[0], right[0]], axis=-1),
        np.stack([np.full(2 * rows, len(ring) + 1), right[-1], index[-1]], axis=-1),
    ]
    uv = np.zeros((len(points), 2), np.float32)
    return Mesh(points, points.astype(np.float32), uv, np.concatenate([*quads, *caps]).astype(np.int32), "ball")


def _gram() -> Found:
    z, share = np.polynomial.legendre.leggauss(16)
    phi = 2.0 * np.pi * np.arange(32) / 32
    across = np.sqrt(1.0 - z * z)[:, None]
    points = np.stack(np.broadcast_arrays(across * np.cos(phi), across * np.sin(phi), z[:, None]), -1).reshape(-1, 3)
    basis = evaluate(15, points)
    weight = np.repeat(share * 2.0 * np.pi / 32, 32)
    return float(np.abs((basis * weight[:, None]).T @ basis - np.eye(225)).max()), 2e-14 * 15


def _poles() -> Found:
    points = np.array([[0, 0, 1.0], [0, 0, -1.0], [1e-300, 0, 1.0], [0, 1e-12, -1.0]])
    return float(np.abs((evaluate(15, points) ** 2).sum(axis=1) - 225 / (4.0 * np.pi)).max()), 4e-14 * 15


def _turn(axis: list[float], angle: float) -> np.ndarray:
    x, y, z = normalize(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    whole: np.ndarray = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    return whole


def _turns_compose() -> Found:
    worst = 0.0
    for angle in (0.0, 1e-12, 1e-6, 1.0, np.pi):
        one, other = _turn([0.3, 1.0, 0.2], angle), _turn([1.0, 0.1, -0.4], 0.7)
        both = rotation(8, one) @ rotation(8, other)
        worst = max(worst, float(np.abs(rotation(8, one @ other) - both).max()))
    return worst, 1e-13


def _no_turn() -> Found:
    return float(np.abs(rotation(8, np.eye(3)) - np.eye(64)).max()), 0.0


def _energy_of_bands() -> Found:
    values = np.random.default_rng(0).normal(size=64)
    turned = rotation(8, _turn([0.2, 0.5, 1.0], 2.0)) @ values
    parts = [slice(band**2, (band + 1) ** 2) for band in range(8)]
    return max(abs(float((turned[p] ** 2).sum() / (values[p] ** 2).sum()) - 1.0) for p in parts), 1e-13


def _windows_keep_the_mean() -> Found:
    return max(abs(float(window(5, kind)[0]) - 1.0) for kind in ("hanning", "lanczos")), 0.0


def _diffuse_under_even_light() -> Found:
    even = project(EnvironmentMap(np.ones((32, 64, 3), np.float32)), 5)
    lit = turn_zonal(cosine_zonal(5), normalize(np.random.default_rng(0).normal(size=(64, 3)))) @ even / np.pi
    return float(np.abs(lit - 1.0).max()), 1e-6


def _open_point() -> Found:
    normal = normalize(np.array([[0.3, -0.8, 0.5]]))
    frames, free = world_from_tangent(normal), np.ones(1, np.bool_)
    seen = visibility_harmonics(np.ones((1, 6 * 32**2), np.uint8), 1, 32, 9)
    found = matrices(seen, frames, free)[0]
    return float(np.abs(found @ found.T - np.eye(25)).max()), 4e-6


def _find_closed_point() -> Found:
    seen = visibility_harmonics(np.zeros((1, 6 * 16**2), np.uint8), 1, 16, 9)
    return float(np.abs(matrices(seen, np.eye(3)[None], np.zeros(1, np.bool_))).max()), 0.0


def _sphere_is_whole() -> Found:
    return max(abs(6.0 * float(cube_solid_angles(n).sum()) / (4.0 * np.pi) - 1.0) for n in (4, 16, 64)), 1e-13


def _haar_is_exact() -> Found:
    images = np.random.default_rng(0).integers(0, 4096, (6, 64, 64, 3)).astype(np.float64)
    return float(np.abs(cube_of_coefficients(cube_coefficients(images)) - images).max()), 0.0


def _haar_keeps_energy() -> Found:
    images = np.random.default_rng(0).normal(size=(6, 32, 32, 3))
    return abs(float((cube_coefficients(images) ** 2).sum() / (images**2).sum()) - 1.0), 4e-15


def _ties_go_first() -> Found:
    kept = strongest(np.ones((6 * 16 * 16, 3)), 96)
    return float(np.abs(kept - np.arange(96)).max()), 0.0


def _codes_never_wrap() -> Found:
    values = np.random.default_rng(0).normal(size=(64, 96, 3))
    words, peaks = quantise(values)
    off = np.abs(dequantise(words, peaks) - values.astype(np.float32)) / peaks[:, None]
    return float((off * 2.0 * np.array(BOUNDS)).max()), 1.0 + 1e-4


def _words_return() -> Found:
    rng = np.random.default_rng(0)
    quantised = np.stack(
        [rng.integers(-1024, 1024, 10_000), rng.integers(-1024, 1024, 10_000), rng.integers(-512, 512, 10_000)], -1
    )
    return float(np.abs(unpack(pack(quantised)) - quantised).max()), 0.0


def _sums_never_overflow() -> Found:
    """96 products of the largest coefficients, against the integers of Python."""
    kept, mesh = 96, sphere(4)
    count = len(mesh.positions)
    words = np.full((count, kept), pack(np.array([1023, 1023, 511])), np.uint32)
    indices = np.tile(np.arange(6, 6 + kept, dtype=np.uint16), (count, 1))
    vectors = Vectors16(indices, words, np.ones((count, 3), np.float32), np.full(count, kept, np.uint16))
    hemisphere_map = HemisphereMap("orthographic", 4)
    flat = np.ones((1, 4, 4, 3), np.float32)
    transport = WaveletTransport(
        mesh, count, SeparableFactors(hemisphere_map, "in-out", flat, flat, True, True), 0.0, 16, vectors
    )
    quantised = np.full((6 * 16 * 16, 3), 32767, np.int16)
    found = relight_transport(transport, WaveletLight(np.zeros((6, 3)), quantised, 1.0, 0.0, 0.0))
    return float(np.abs(found / float(kept * 32767) - 1.0).max()), 1e-12


def _large_edges_are_refused() -> Found:
    try:
        check_edge(128)
    except ValueError:
        return 0.0, 0.0
    return 1.0, 0.0


def _sun_leaves_the_sky() -> Found:
    radiance = np.random.default_rng(0).random((64, 128, 3)).astype(np.float32) + 0.6
    radiance[20, 40] = 1e6
    rest, suns = split_sun(EnvironmentMap(radiance))
    found = encode_light(cube_of(rest, 32).radiance)
    return found.energy_error_rel if suns else 1.0, 0.01


def _flux_is_kept() -> Found:
    radiance = np.random.default_rng(0).random((64, 128, 3)).astype(np.float32)
    radiance[20, 40] = 1e5
    environment = EnvironmentMap(radiance)
    rest, suns = split_sun(environment)
    even = [project(each, 1)[0] for each in (environment, rest)]
    lamp = sum(np.asarray(each.irradiance) / np.cos(each.radius / 2.0) ** 2 for each in suns) / np.sqrt(4.0 * np.pi)
    return float(np.abs((even[1] + lamp) / even[0] - 1.0).max()), 1e-6


def _wide_gaussians() -> Found:
    return float(abs(gaussian_integral(1e8) / (4.0 * np.pi) - 1.0)), 1e-12


def _narrow_gaussians() -> Found:
    mean = normalize(np.array([0.6, 0.0, 0.8], np.float32))
    side = normalize(np.cross(mean, [0.0, 1.0, 0.0]))
    angle, sigma = 2e-3, 1e-3
    near = np.cos(angle) * mean + np.sin(angle) * side
    exact = np.exp(-2.0 * np.sin(angle / 2.0) ** 2 / sigma**2)
    return float(abs(gaussian(near, mean, sigma) / exact - 1.0)), 1e-9


def _views_return() -> Found:
    views = view_directions()
    index, weight = nearest_views(views)
    own = np.take_along_axis(weight, (index == np.arange(92)[:, None]).argmax(axis=1)[:, None], 1)[:, 0]
    return float(np.abs(own - 1.0).max() + np.abs(views.sum(axis=0)).max()), 1e-13


def _check_closed_models_are_tight() -> Found:
    return miss_rate(sphere(), 100_000), 2e-5


def _convex_is_open() -> Found:
    of = receivers(sphere())
    asked, known = (np.concatenate([bits for _, bits in visibility_cube(of, 16, skip=skip)]) for skip in (False, True))
    return float(np.count_nonzero(asked != known)), 0.0


def _scale_is_nothing() -> Found:
    one = sphere(8)
    points = np.concatenate([one.positions, 0.5 * one.positions + (1.3, 0.4, 0.0)])
    normals, uv = np.concatenate([one.normals] * 2), np.concatenate([one.uv] * 2)
    faces = np.concatenate([one.faces, one.faces + np.int32(len(one.positions))])
    found = []
    for scale in (1.0, 2.0**-20):
        of = receivers(Mesh(points * scale, normals, uv, faces, "two balls"))
        found.append(np.concatenate([bits for _, bits in visibility_cube(of, 8)]))
    return float(np.count_nonzero(found[0] != found[1])), 0.0


def _even_light_stays_even() -> Found:
    levels = prefilter(CubeMap(np.full((6, 32, 32, 3), 0.7, np.float32))).levels
    return max(float(np.abs(level / np.float32(0.7) - 1.0).max()) for level in levels), 1e-5


def _filters_keep_energy() -> Found:
    cube = CubeMap(np.random.default_rng(0).random((6, 32, 32, 3)).astype(np.float32))
    found = prefilter(cube)
    rng = np.random.default_rng(1)
    towards = normalize(rng.normal(size=(200_000, 3)))
    sigma = float(found.sigma[len(found.sigma) // 2])
    mean = found.lookup(towards, np.full(len(towards), sigma)).mean(axis=0)
    return float(np.abs(mean / found.mean - 1.0).max()), 3e-3


def _faces_lie_right() -> Found:
    towards = texel_directions(256, 512)
    cube = cube_of(EnvironmentMap(((towards + 1.0) * 0.5).astype(np.float32)), 16)
    return float(np.abs(cube.radiance - (cube_directions(16) + 1.0) * 0.5).max()), 0.02


def _sums_are_linear() -> Found:
    rng = np.random.default_rng(0)
    one, other = (EnvironmentMap(rng.random((32, 64, 3)).astype(np.float32)) for _ in range(2))
    both = EnvironmentMap(one.radiance + other.radiance)
    apart = project(both, 5) - project(one, 5) - project(other, 5)
    return float(np.abs(apart).max()), 64 * U32


def _gl_is_the_cpu() -> Found:
    from engine.render.direct import radiance

    mesh = sphere()
    scene = Scene(mesh, frame(mesh.positions), brdf_from_text("ggx:kd=0.3,alpha=0.3,f0=0.04"))
    wanted = drain(radiance(scene, (64, 64), samples=1))
    with create_context() as context:
        renderer = DirectRenderer(context)
        found = renderer.radiance(scene, (64, 64), samples=1)
        renderer.release()
    inside = np.minimum(wanted[..., 3], found[..., 3]) > 0.5
    return float(np.abs(found - wanted)[inside].max()), 2.0 / 255.0


def _gl_is_finite() -> Found:
    mesh = sphere()
    scene = Scene(mesh, frame(mesh.positions), brdf_from_text("phong:exponent=10000"), light=(0.0, 0.0, 1.0))
    with create_context() as context:
        renderer = DirectRenderer(context)
        found = renderer.radiance(scene, (64, 64), samples=1)
        renderer.release()
    return float(np.count_nonzero(~np.isfinite(found))), 0.0


def _every_ray_agrees() -> Found:
    mesh = sphere()
    work = drain(prepare(mesh, Lambert((0.5, 0.5, 0.5)), BakeSettings(3, 16, 2)))
    of, vertices = receivers(mesh, work.caster), np.arange(len(mesh.positions))
    asked = every_ray(of, 16, 2)
    forced = baker_of(work, asked)
    rows = forced.rows(vertices, forced.visible(vertices)), baker_of(work, of).rows(vertices, None)
    return float(np.abs(rows[0] - rows[1]).max()), 1e-12


def _convex_needs_no_shadows() -> Found:
    mesh, brdf = sphere(), Lambert((0.5, 0.5, 0.5))
    some = sample(mesh, EnvironmentMap(np.ones((16, 32, 3), np.float32)), points=16)
    nothing = np.zeros((*some.views.shape[:2], 3))
    seen = radiances(some, brdf, methods=False)
    return self_shadowing(Scenery(some, brdf, seen, some, seen, (nothing, nothing))).error_rel, 0.0


def _no_sun_no_split() -> Found:
    _, suns = split_sun(EnvironmentMap(np.random.default_rng(0).random((32, 64, 3)).astype(np.float32)))
    return float(len(lights_of_all(suns).direction)), 0.0


QUESTIONS = (
    Question("H1", "deviation of spherical harmonics of order 15 from orthonormal", _gram),
    Question("H2", "error of the addition theorem at the poles, order 15", _poles),
    Question("H5", "error of two rotations after each other, order 8", _turns_compose),
    Question("H6", "deviation of no rotation from the identity", _no_turn),
    Question("H8", "relative change of the energy of a band by rotation", _energy_of_bands),
    Question("H9", "change of even light by windows", _windows_keep_the_mean),
    Question("H10", "error of a diffuse surface under even light", _diffuse_under_even_light),
    Question("H11", "deviation of transfer at an open point from a rotation", _open_point),
    Question("H11", "transfer at a closed point", _find_closed_point),
    Question("H13", "error of the sum of two lights", _sums_are_linear),
    Question("H14", "relative error of the sphere as the sum of texels", _sphere_is_whole),
    Question("Z1", "error of 12-bit images after the transform and back", _haar_is_exact),
    Question("Z2", "relative change of energy by the transform", _haar_keeps_energy),
    Question("Z4", "how far ties are from going to the lowest index", _ties_go_first),
    Question("Z9", "error of quantised coefficients, in halves of a step", _codes_never_wrap),
    Question("Z10", "error of packed coefficients after unpacking", _words_return),
    Question("X4", "relative error of the sum of 96 products of the largest coefficients", _sums_never_overflow),
    Question("X5", "cube edges of 128 that are taken", _large_edges_are_refused),
    Question("X6", "relative error of the sky's energy beside a sun of 1e6", _sun_leaves_the_sky),
    Question("EN6", "relative change of the light by splitting a sun off", _flux_is_kept),
    Question("V1", "rays that leave a closed model unnoticed", _check_closed_models_are_tight),
    Question("V2", "texels that a convex model hides from itself", _convex_is_open),
    Question("V3", "texels that change when a model shrinks a million times", _scale_is_nothing),
    Question("G3", "relative error of a Gaussian of width 1e-3", _narrow_gaussians),
    Question("G4", "relative error of the integral of the widest Gaussian", _wide_gaussians),
    Question("G12", "error of the weight of a view at itself", _views_return),
    Question("EN1", "relative error of even light after filtering", _even_light_stays_even),
    Question("EN3", "relative change of energy by filtering", _filters_keep_energy),
    Question("EN13", "error of faces of a cube map whose colours are directions", _faces_lie_right),
    Question("GL2", "pixels of a narrow highlight that are not finite", _gl_is_finite),
    Question("GL8", "largest difference of drawing with and without the graphics device", _gl_is_the_cpu),
    Question("T1", "change of transport by rays that a convex model does not need", _every_ray_agrees),
    Question("T2", "estimate of the shadows of a convex model on itself", _convex_needs_no_shadows),
    Question("T3", "suns split off a sky without one", _no_sun_no_split),
)
