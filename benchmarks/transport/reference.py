"""The reference renderer beside Mitsuba 3 at equal error, and beside its own rays."""

from __future__ import annotations

import importlib
import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Measure, best_of
from engine.brdf.brdf import brdf_from_text
from engine.core.errors import MissingCapability
from engine.core.steps import drain
from engine.geometry.camera import frame
from engine.geometry.ground import Ground
from engine.geometry.ray_caster import RayCaster
from engine.geometry.shapes import shape
from engine.light.environment_file import open_environment
from engine.render.reference import ReferenceImage, reference
from engine.scene.scene import Scene

Floats = NDArray[np.float64]

#: Side of the images, samples of each pixel in one, and images of each renderer.
SIZE, SAMPLES, IMAGES = 192, 64, 5

#: LLVM that Mitsuba's compiled variants need: older ones end the program at an instruction that they do not know.
MIN_LLVM = 16


def reference_direct() -> Measure:
    """The time in which our image of direct light gets the error that Mitsuba's has, against Mitsuba's time.

    The error of either comes from how its own images differ. More samples are taken to lower the error by their
    root, as they do without stratification, which is to our disadvantage.
    """
    mitsuba, variant = _mitsuba()
    scene = _scene()
    theirs = _translate(mitsuba, scene)

    def ours(seed: int) -> Floats:
        return _render(scene, 1, seed).image[..., :3].astype(np.float64)

    def other(seed: int) -> Floats:
        return np.array(mitsuba.render(theirs, spp=SAMPLES, seed=seed), np.float64)[..., :3]

    (our_s, our_error, our_mean), (their_s, their_error, their_mean) = (_time(render) for render in (ours, other))
    more = {
        "mitsuba_variant": variant,
        "rmse_rel": our_error,
        "mitsuba_rmse_rel": their_error,
        "same_samples_s": our_s,
        "means_differ_by_rel": float(np.sqrt(np.mean((our_mean - their_mean) ** 2) / np.mean(their_mean**2))),
    }
    equal_s = our_s * (our_error / their_error) ** 2
    return Measure("reference-direct", equal_s, their_s, f"Mitsuba {variant} at the same error", more)


def reference_paths() -> Measure:
    """Paths of up to four points, against as many rays of the ray caster alone, in random directions."""
    scene = _scene(ground=Ground())
    image: list[ReferenceImage] = []
    time_s = best_of(lambda: image.append(_render(scene, 4, 0)), 3)
    rays = image[-1].rays
    more = {"samples_per_s": SIZE * SIZE * SAMPLES / time_s, "rays_per_s": rays / time_s}
    return Measure("reference-paths", time_s, _ray_s(scene) * rays, "its rays alone", more)


def _scene(ground: Ground | None = None) -> Scene:
    mesh = shape("torus-knot")
    return Scene(
        mesh,
        frame(mesh.positions),
        brdf_from_text("lambert:albedo=0.5"),
        environment=open_environment("sky"),
        ground=ground,
    )


def _render(scene: Scene, max_depth: int, seed: int) -> ReferenceImage:
    return drain(reference(scene, (SIZE, SIZE), samples=SAMPLES, max_depth=max_depth, seed=seed))


def _time(render: Any) -> tuple[float, float, Floats]:
    """The shortest time of an image, its relative error, and the mean of several."""
    render(IMAGES)
    images, times = [], []
    for seed in range(IMAGES):
        start = time.perf_counter()
        images.append(render(seed))
        times.append(time.perf_counter() - start)
    mean = np.mean(images, axis=0)
    variance = np.var(images, axis=0, ddof=1).mean()
    return min(times), float(np.sqrt(variance / np.mean(mean**2))), mean


def _ray_s(scene: Scene, count: int = 1 << 19) -> float:
    """Seconds that a ray takes, from random points of the surface upwards."""
    surface, random = scene.surface, np.random.default_rng(0)
    caster = RayCaster(surface.positions, surface.faces)
    face = random.integers(0, len(surface.faces), count)
    origin = surface.positions[surface.faces[face, 0]] + 1e-3 * surface.normals[surface.faces[face, 0]]
    direction = random.normal(size=(count, 3))
    direction *= np.sign(np.einsum("ni,ni->n", direction, surface.normals[surface.faces[face, 0]]))[:, None]
    return best_of(lambda: caster.occluded(origin, direction), 3) / count


def _mitsuba() -> tuple[Any, str]:
    """Mitsuba in its compiled variant, or in the one that needs no compiler."""
    try:
        mitsuba, drjit = importlib.import_module("mitsuba"), importlib.import_module("drjit")
    except (ImportError, NameError) as error:  # NameError: what its own package makes of a library that is missing
        raise MissingCapability(f"Mitsuba 3 cannot be loaded ({error})", "Install the test extra") from None
    variant = "llvm_ad_rgb" if _llvm_version(drjit) >= MIN_LLVM else "scalar_rgb"
    mitsuba.set_variant(variant)
    return mitsuba, variant


def _llvm_version(drjit: Any) -> int:
    """Of the LLVM that Mitsuba finds, 0 where it finds none."""
    try:
        return int(drjit.detail.llvm_version()[0])
    except (AttributeError, IndexError, RuntimeError):
        return 0


def _translate(mitsuba: Any, scene: Scene) -> Any:
    """`scene` without its ground as Mitsuba's."""
    assert scene.environment is not None
    camera, mesh = scene.camera, scene.mesh
    properties = mitsuba.Properties()
    properties["bsdf"] = mitsuba.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}})
    counts = {"vertex_count": len(mesh.positions), "face_count": len(mesh.faces)}
    model = mitsuba.Mesh("model", **counts, has_vertex_normals=True, props=properties)
    values = mitsuba.traverse(model)
    values["vertex_positions"] = mesh.positions.astype(np.float32).ravel()
    values["vertex_normals"] = mesh.normals.ravel().copy()
    values["faces"] = mesh.faces.astype(np.uint32).ravel()
    values.update()
    film = {"type": "hdrfilm", "width": SIZE, "height": SIZE, "rfilter": {"type": "box"}, "pixel_format": "rgb"}
    look_at = mitsuba.ScalarTransform4f().look_at(list(camera.eye), list(camera.target), list(camera.up))
    return mitsuba.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "direct", "hide_emitters": True},
            "sensor": {"type": "perspective", "fov": camera.fov_deg, "to_world": look_at, "film": film},
            "model": model,
            "environment": {"type": "envmap", "bitmap": mitsuba.Bitmap(scene.environment.radiance.copy())},
        }
    )
