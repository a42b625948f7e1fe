"""What functions of the library accept for each kind of value: arrays, paths, open files and objects of other packages.

Each function takes whatever stands for its kind and returns the value that the engine works on, or raises a
`LightarcError` that says what would be right.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Literal, Protocol, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import Brdf
from engine.brdf.samples import BrdfSamples
from engine.capture.lights.selection import Azimuth
from engine.capture.lights.sources import Sources, find_packed
from engine.capture.stack import ImageStack, open_stack
from engine.core.colour import luminance, srgb_decode
from engine.core.errors import UsageError
from engine.core.steps import Step, drain
from engine.exchange.readers.read import open_material
from engine.factor.factor_file import open_reflectance
from engine.geometry.camera import Camera, frame, parse
from engine.geometry.mesh import Mesh, mesh_of_arrays
from engine.geometry.shapes import open_mesh
from engine.images.decode import read_image
from engine.images.encode import encode_exr, encode_png, rgb_channels
from engine.light.environment import EnvironmentMap
from engine.light.environment_file import open_environment
from engine.light.lamps import Lamp
from engine.light.near_lamps import NearLamp
from engine.scene.material import Material
from engine.storage.atomic import atomic_file, make_folder, write_bytes

if TYPE_CHECKING:
    from engine.capture.lights.mirror_sphere import Circle
    from engine.capture.lights.selection import Azimuth
    from engine.capture.stack import ImageStack

File = str | os.PathLike[str]
Progress = Callable[[Step], None]

#: A file by its path, or open in binary mode.
FileLike = File | IO[bytes]

#: Whatever stands for a BRDF: its text, a file, a model or its class, or any object with `f`.
BrdfLike = FileLike | Brdf | type[Brdf]


class Triangles(Protocol):
    """A mesh of another package, such as trimesh."""

    @property
    def vertices(self) -> ArrayLike: ...
    @property
    def faces(self) -> ArrayLike: ...


#: Whatever stands for a model: a name, a file, a mesh of this package or of trimesh, or (vertices, faces).
MeshLike = FileLike | Mesh | Triangles | Sequence[ArrayLike]

MaterialLike = FileLike | Material
EnvironmentLike = FileLike | EnvironmentMap | ArrayLike
CameraLike = str | Camera
LightLike = ArrayLike | Lamp | NearLamp | Sequence[Lamp | NearLamp]
ImageLike = FileLike | ArrayLike


def is_path(value: object) -> TypeGuard[File]:
    """Return whether a value names a file."""
    return isinstance(value, str | os.PathLike)


def is_file_object(value: object) -> TypeGuard[IO[bytes]]:
    """Return whether a value is an open file that can be read."""
    return callable(getattr(value, "read", None))


@contextmanager
def on_disk(file: FileLike, suffix: str = "") -> Iterator[Path]:
    """Give the path of a file; of an open one that of a copy, which is removed at the end of the block.

    The decoders of the engine read files by name in a process of their own. The ending is that of the file's `name`,
    or else `suffix`.
    """
    if isinstance(file, str | os.PathLike):
        yield Path(file)
        return
    named = getattr(file, "name", "")
    name = Path(named).name if isinstance(named, str) and named else f"file{suffix}"
    with tempfile.TemporaryDirectory(prefix="lightarc-") as folder:
        path = Path(folder) / name
        content = file.read(1 << 20)
        if not isinstance(content, bytes | bytearray | memoryview):
            raise UsageError("an open file must be opened in binary mode ('rb')")
        with atomic_file(path) as copy:
            while content:
                copy.write(content)
                content = file.read(1 << 20)
        yield path


def numeric(values: object, name: str, *axes: int | None) -> NDArray[np.float64]:
    """Return finite float64 numbers whose axes have these lengths (None: any); `name` is that of the argument."""
    try:
        array = np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise UsageError(f"{name} must be an array of numbers, not {type(values).__name__}") from None
    wanted = " × ".join("N" if axis is None else str(axis) for axis in axes)
    fits = len(axes) == array.ndim and all(
        axis in (None, length) for axis, length in zip(axes, array.shape, strict=True)
    )
    if not fits or array.size == 0:
        raise UsageError(f"{name} must have the shape {wanted}, not {' × '.join(map(str, array.shape)) or 'a number'}")
    if not np.isfinite(array).all():
        raise UsageError(f"{name} must be finite")
    return array


def as_mesh(model: Any) -> Mesh:
    """Return the mesh of a name, a file, a trimesh object, or arrays (vertices, faces) or (vertices, faces, uv)."""
    if isinstance(model, Mesh):
        return model
    if is_path(model):
        return open_mesh(os.fspath(model))
    if is_file_object(model):
        with on_disk(model, ".ply") as path:
            return open_mesh(os.fspath(path))
    if hasattr(model, "to_geometry") or hasattr(model, "dump"):  # a trimesh scene: all its meshes as one
        model = model.to_geometry() if hasattr(model, "to_geometry") else model.dump(concatenate=True)
    if hasattr(model, "vertices") and hasattr(model, "faces"):
        uv = getattr(getattr(model, "visual", None), "uv", None)
        return mesh_of_arrays(model.vertices, model.faces, uv)
    if isinstance(model, tuple | list) and len(model) in (2, 3):
        return mesh_of_arrays(*model)
    raise UsageError(
        "a model is a name, a file, a trimesh object or (vertices, faces), "
        f"not {type(model).__module__}.{type(model).__name__}"
    )


def as_environment(environment: object) -> EnvironmentMap | None:
    """Return the environment map of a name, a file or an array (H, W, 3) of linear radiance; None stays None."""
    if environment is None or isinstance(environment, EnvironmentMap):
        return environment
    if is_path(environment):
        return open_environment(environment)
    if is_file_object(environment):
        with on_disk(environment, ".hdr") as path:
            return open_environment(path)
    array = np.asarray(environment)
    if array.ndim == 2:
        array = np.repeat(array[..., None], 3, axis=2)
    if array.ndim != 3 or array.shape[2] not in (3, 4) or array.shape[1] != 2 * array.shape[0]:
        shape = " × ".join(map(str, array.shape))
        raise UsageError(f"an environment array must be height × width × 3 and twice as wide as high, not {shape}")
    radiance = numeric(array[..., :3], "environment", None, None, 3)
    if radiance.min() < 0.0:
        raise UsageError("the radiance of an environment must not be negative")
    return EnvironmentMap(radiance.astype(np.float32))


def as_brdf(brdf: Any) -> Brdf:
    """Return the BRDF of a text, a file, a model or its class, or any object with `f`."""
    if is_path(brdf):
        return open_reflectance(os.fspath(brdf))
    if is_file_object(brdf):
        with on_disk(brdf, ".csv") as path:
            return open_reflectance(os.fspath(path))
    if isinstance(brdf, type):
        brdf = brdf()
    if not callable(getattr(brdf, "f", None)):
        raise UsageError(
            "a BRDF is a text such as 'ggx:alpha=0.3', a file, a model such as lightarc.Ggx(alpha=0.3) or an object "
            f"with f(wi, wo), not {type(brdf).__name__}"
        )
    missing = [name for name in ("isotropic", "reciprocal", "energy_conserving") if not hasattr(brdf, name)]
    if missing:
        raise UsageError(f"the BRDF {type(brdf).__name__} must state {', '.join(missing)} (True or False)")
    found: Brdf = brdf
    return found


def as_samples(samples: Sequence[Any]) -> BrdfSamples:
    """Return measured values from arrays (wi, wo, values), whose directions broadcast against each other."""
    if len(samples) != 3:
        raise UsageError(f"samples of a BRDF are (wi, wo, values), not {len(samples)} arrays")
    wi, wo, value = (np.asarray(each, np.float64) for each in samples)
    if value.ndim and value.shape[-1] == 1:
        value = np.repeat(value, 3, axis=-1)
    try:
        shape = np.broadcast_shapes(wi.shape, wo.shape, value.shape)
    except ValueError:
        raise UsageError(f"wi, wo and values do not fit together: {wi.shape}, {wo.shape}, {value.shape}") from None
    if shape[-1:] != (3,):
        raise UsageError(f"wi, wo and values must have the shape N × 3, not {shape}")
    wi, wo, value = (np.broadcast_to(each, shape).reshape(-1, 3) for each in (wi, wo, value))
    lengths = [np.linalg.norm(each, axis=1, keepdims=True) for each in (wi, wo)]
    if not all((np.abs(length - 1.0) < 1e-3).all() for length in lengths):
        raise UsageError("wi and wo must be unit vectors in the surface frame, whose normal is (0, 0, 1)")
    return BrdfSamples(wi / lengths[0], wo / lengths[1], value, name="samples")


def as_material(material: object, search: str | os.PathLike[str] | None = None) -> Material | None:
    """Return the material of a bundle, a folder of PBR textures or a glTF, OBJ or MaterialX file; None stays None."""
    if material is None or isinstance(material, Material):
        return material
    if not (is_path(material) or is_file_object(material)):
        raise UsageError(f"a material is a Material or a file, not {type(material).__name__}")
    with on_disk(material, ".lightarc") as path:
        return open_material(path, parts=True, search=search)


def as_camera(camera: object, positions: NDArray[np.float64], size: tuple[int, int]) -> Camera:
    """Return the camera of a text or a Camera; what a text leaves out frames the positions (V, 3)."""
    if isinstance(camera, Camera):
        return camera
    if not isinstance(camera, str):
        raise UsageError(f"a camera is a text such as 'eye=0,0,4 target=0,0,0', not {type(camera).__name__}")
    return parse(camera, frame(positions, size[0] / size[1]))


def as_lamps(light: LightLike | None, irradiance: float) -> tuple[tuple[Lamp, ...], tuple[NearLamp, ...]]:
    """Return the distant lights of a vector (3,), vectors (N, 3), or Lamp objects, and the NearLamp objects."""
    if light is None:
        return (), ()
    each = list(light) if isinstance(light, list | tuple) else [light]
    lamps = tuple(one for one in each if isinstance(one, Lamp))
    near = tuple(one for one in each if isinstance(one, NearLamp))
    if each and len(lamps) + len(near) == len(each):
        return lamps, near
    given = np.asarray(light, np.float64)
    vectors = numeric(np.atleast_2d(given) if given.size else np.zeros((0, 3)), "light", None, 3)
    return tuple(Lamp((float(x), float(y), float(z)), (float(irradiance),) * 3) for x, y, z in vectors), ()


def as_image(image: object) -> tuple[NDArray[np.float32], bool]:
    """Return linear values (H, W, 3 or 4) of an array or a file, and whether they are what a screen shows.

    Arrays of whole numbers of 8 or 16 bits are sRGB-coded, as such files are; arrays of floats are linear radiance.
    """
    if is_path(image) or is_file_object(image):
        with on_disk(image, ".png") as path:
            found = read_image(path)
        return found.pixels, found.container not in ("EXR", "HDR", "PFM")
    array = np.asarray(image)
    if array.ndim == 2:
        array = np.repeat(array[..., None], 3, axis=2)
    if array.ndim != 3 or array.shape[2] not in (3, 4) or array.dtype.kind not in "fiu":
        raise UsageError(f"an image must be height × width × 3 or 4 numbers, not {array.dtype} {array.shape}")
    if array.dtype in (np.uint8, np.uint16):
        return np.asarray(srgb_decode(array / np.iinfo(array.dtype).max), np.float32), True
    return array, False


def images_of(values: Iterable[ArrayLike]) -> NDArray[Any]:
    """Return the images (N, H, W, 3) of an array or of a list of arrays, N at least 2."""
    array = np.asarray(values) if isinstance(values, np.ndarray) else np.stack([np.asarray(each) for each in values])
    if array.ndim == 3:
        array = np.repeat(array[..., None], 3, axis=3)
    if array.ndim != 4 or array.shape[3] != 3 or array.shape[0] < 2 or 0 in array.shape:
        raise UsageError(f"photographs must be an array N × height × width × 3, N from 2, not {array.shape}")
    if array.dtype.kind not in "fu" or (array.dtype.kind == "u" and array.dtype.itemsize > 2):
        raise UsageError(f"photographs must be floats (linear) or 8 or 16 bits (sRGB), not {array.dtype}")
    return array


def is_array(value: object) -> TypeGuard[Iterable[ArrayLike]]:
    """Return whether a value is an array of numbers, or a list of such arrays."""
    if isinstance(value, list | tuple):
        return len(value) > 0 and all(hasattr(each, "__array__") for each in value)
    return hasattr(value, "__array__")


def light_angles(
    count: int, angles_deg: ArrayLike | None, lights: ArrayLike | None
) -> tuple[NDArray[np.float64], NDArray[np.float64] | None] | None:
    """Return elevations and azimuths (or None) in radians of `count` lights; None where neither is given.

    `lights` are vectors (N, 3) towards the lights in the frame of the sample: x to the right of the photographs, y up,
    z towards the camera.
    """
    if angles_deg is not None and lights is not None:
        raise UsageError("give angles_deg or lights, not both")
    if angles_deg is not None:
        elevation = numeric(angles_deg, "angles_deg", count)
        if not ((elevation >= 0.0) & (elevation <= 90.0)).all():
            raise UsageError("angles_deg are elevations from 0 to 90 degrees")
        return np.radians(elevation), None
    if lights is None:
        return None
    vectors = numeric(lights, "lights", count, 3)
    length = np.linalg.norm(vectors, axis=1)
    if not (length > 0.0).all() or (vectors[:, 2] < 0.0).any():
        raise UsageError("lights must be vectors towards the lights, none of them below the sample (z < 0)")
    return np.arcsin(vectors[:, 2] / length), np.arctan2(vectors[:, 1], vectors[:, 0])


def as_stack(stack: object, angles_deg: ArrayLike | None = None, lights: ArrayLike | None = None) -> ImageStack:
    """Return the stack of a folder, of an ImageStack, or of arrays (N, H, W, 3) ordered by rising elevation.

    The elevations of arrays without angles are evenly spaced up to 90 degrees.
    """
    if isinstance(stack, ImageStack):
        return stack
    if is_path(stack):
        return open_stack(stack)
    if not is_array(stack):
        raise UsageError(f"a stack is an ImageStack, a folder or an array N × height × width × 3, not {stack!r:.40}")
    images = images_of(stack)
    count = len(images)
    found = light_angles(count, angles_deg, lights)
    elevation, azimuth = found or (np.radians(90.0 * np.arange(1, count + 1) / count), None)
    order = np.argsort(elevation, kind="stable")
    if images.dtype.kind == "u":
        full = np.iinfo(images.dtype).max
        saturated = (images == full).any(axis=3)
        radiance = np.asarray(srgb_decode(images / full), np.float32)
    else:
        radiance = np.asarray(images, np.float32)
        if not np.isfinite(radiance).all() or radiance.min() < 0.0:
            raise UsageError("photographs must be finite and not negative")
        saturated = np.zeros(radiance.shape[:3], np.bool_)
    radiance = np.ascontiguousarray(radiance[order])
    return ImageStack(
        radiance,
        np.ascontiguousarray(saturated[order]),
        elevation[order],
        None if azimuth is None else azimuth[order],
        luminance(radiance).mean(axis=(1, 2), dtype=np.float64),
        tuple(f"photograph-{index + 1:04d}" for index in order),
        "user" if found else "assumed",
    )


@contextmanager
def capture_of_arrays(
    values: Iterable[ArrayLike], angles_deg: ArrayLike | None, lights: ArrayLike | None
) -> Iterator[Sources]:
    """Give the capture of arrays, whose photographs lie in a folder that is removed at the end of the block.

    An import decodes files: arrays go through the same steps.
    """
    images = images_of(values)
    found = light_angles(len(images), angles_deg, lights)
    if found is None:
        raise UsageError("photographs in arrays need angles_deg, one elevation each, or lights, one vector each")
    elevation, azimuth = found
    with tempfile.TemporaryDirectory(prefix="lightarc-") as name:
        folder = make_folder(Path(name) / "arrays")
        ending = "exr" if images.dtype.kind == "f" else "png"
        names = [f"photograph-{index + 1:04d}.{ending}" for index in range(len(images))]
        for image, path in zip(images, names, strict=True):
            content = encode_exr(rgb_channels(image), half=False) if ending == "exr" else encode_png(image)
            write_bytes(folder / path, content)
        if azimuth is not None:
            cosine, sine = np.cos(elevation), np.sin(elevation)
            vectors = np.column_stack([cosine * np.cos(azimuth), cosine * np.sin(azimuth), sine])
            rows = [f"{path} {x:.12g} {y:.12g} {z:.12g}" for path, (x, y, z) in zip(names, vectors, strict=True)]
            write_bytes(folder / "lights.lp", "\n".join([str(len(rows)), *rows, ""]).encode())
        angles = None if azimuth is not None else [float(each) for each in np.degrees(elevation)]
        yield drain(find_packed([folder], angles))


def as_azimuth(azimuth_deg: float | Sequence[float] | None) -> Azimuth | None:
    """Return the azimuth of an angle in degrees, or of an angle and a tolerance; None stays None."""
    if azimuth_deg is None:
        return None
    angles = [azimuth_deg] if isinstance(azimuth_deg, int | float) else list(azimuth_deg)
    if not 1 <= len(angles) <= 2:
        raise UsageError("azimuth_deg is an angle in degrees, or (angle, tolerance)")
    return Azimuth(*(float(angle) for angle in angles))


def capture_of(
    capture: Any,
    angles_deg: ArrayLike | None,
    lights: ArrayLike | None,
    sphere: Circle | Literal["auto"] | None = None,
) -> AbstractContextManager[Sources]:
    """Return a context that gives the capture of arrays, of paths, or the one that `open_capture` found.

    `sphere` is the outline of a mirror sphere on which lights of files are measured.
    """

    if sphere is not None and (isinstance(capture, Sources) or is_array(capture)):
        raise UsageError("sphere is for photographs in files; open_capture takes it as well")
    if isinstance(capture, Sources):
        return nullcontext(capture)
    if is_array(capture):
        return capture_of_arrays(capture, angles_deg, lights)
    if lights is not None:
        raise UsageError("lights are for arrays; photographs in files have them in an .lp file or capture.toml")
    paths = [capture] if is_path(capture) else list(capture)
    angles = None if angles_deg is None else [float(angle) for angle in np.atleast_1d(angles_deg)]
    return nullcontext(drain(find_packed([Path(path) for path in paths], angles, sphere=sphere)))
