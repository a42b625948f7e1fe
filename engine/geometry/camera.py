"""A pinhole camera in the coordinates of the mesh as it lies on disk.

Pixel centres are at half-integers, row 0 is on top, the field of view is vertical. Matrices act on columns and name
the destination first; clip space is OpenGL's (−1 … 1 in all three).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.core.directions import Vectors, dot, normalize, world_direction
from engine.core.errors import UsageError
from engine.core.suggestion import suggest

Vector = tuple[float, float, float]

#: From where an object is looked at unless something else is asked for: a little above and to the right.
FRAMING_DIRECTION = world_direction(np.radians(72.0), np.radians(20.0))

#: Radii of an object beyond which an eye does not go: from there it covers 2e-9 rad, less than a pixel of any image,
#: and the near and far planes still differ in double precision and fit into single precision.
FARTHEST = 1e9

_SETTINGS = ("eye", "target", "up", "fov_deg")

#: Largest coordinate of `eye`, `target` and `up`: products of three of them are finite.
LARGEST = 1e100


@dataclass(frozen=True)
class Camera:
    """`eye` looks at `target`; `up` need not be perpendicular; `fov_deg` is the vertical field of view in degrees."""

    eye: Vector
    target: Vector = (0.0, 0.0, 0.0)
    up: Vector = (0.0, 1.0, 0.0)
    fov_deg: float = 35.0

    def __post_init__(self) -> None:
        for name in ("eye", "target", "up"):
            value = tuple(float(number) for number in getattr(self, name))
            if len(value) != 3 or not np.isfinite(value).all():
                raise UsageError(f"{name} needs three finite numbers, got {getattr(self, name)!r}")
            if max(map(abs, value)) > LARGEST:
                raise UsageError(f"{name} has coordinates beyond ±{LARGEST:g}, got {getattr(self, name)!r}")
            object.__setattr__(self, name, value)
        if not 0.01 <= self.fov_deg <= 179.0:
            raise UsageError(f"fov_deg = {self.fov_deg:g} is outside [0.01, 179] °")
        if self.eye == self.target:
            raise UsageError("eye and target are the same point")
        if np.linalg.norm(np.cross(self.forward, normalize(self.up))) < 1e-6:
            raise UsageError("up is parallel to the direction of view")

    @property
    def forward(self) -> Vectors:
        return normalize(np.subtract(self.target, self.eye))

    @property
    def camera_from_world(self) -> Vectors:
        """(3, 3) rotation: rows are right, up and backward in world coordinates."""
        right = normalize(np.cross(self.forward, self.up))
        return np.stack([right, np.cross(right, self.forward), -self.forward])

    def clip_from_model(self, origin: ArrayLike, radius: float, aspect: float) -> NDArray[np.float64]:
        """(4, 4) matrix for positions relative to `origin`, with near and far planes around a sphere of `radius`.

        `aspect` is width over height. Taking positions relative to the centre of the mesh keeps float32 exact for a
        mesh that lies far from the origin of its file. An eye beyond `FARTHEST` radii is taken for one at them.
        """
        rotation = self.camera_from_world
        offset = rotation @ (np.asarray(origin, np.float64) - self.eye)
        offset *= min(1.0, FARTHEST * radius / max(float(np.abs(offset).max()), np.finfo(np.float64).tiny))
        far = max(-offset[2] + 1.01 * radius, 1e-3 * radius)
        near = max(-offset[2] - 1.01 * radius, 1e-3 * far)
        focal = 1.0 / np.tan(np.radians(self.fov_deg) / 2.0)
        projection = np.array(
            [
                [focal / aspect, 0.0, 0.0, 0.0],
                [0.0, focal, 0.0, 0.0],
                [0.0, 0.0, -(far + near) / (far - near), -2.0 * far * near / (far - near)],
                [0.0, 0.0, -1.0, 0.0],
            ]
        )
        camera_from_model = np.eye(4)
        camera_from_model[:3, :3] = rotation
        camera_from_model[:3, 3] = offset
        return projection @ camera_from_model

    def rays(self, column: ArrayLike, row: ArrayLike, width: int, height: int) -> Vectors:
        """Unit world directions (..., 3) from the eye through image positions in pixels, (0, 0) the top left corner."""
        extent = np.tan(np.radians(self.fov_deg) / 2.0)
        x = (2.0 * np.asarray(column, np.float64) / width - 1.0) * extent * width / height
        y = (1.0 - 2.0 * np.asarray(row, np.float64) / height) * extent
        x, y = np.broadcast_arrays(x, y)
        return normalize(np.stack([x, y, -np.ones_like(x)], axis=-1) @ self.camera_from_world)


def frame(
    positions: ArrayLike, aspect: float = 1.0, fov_deg: float = 35.0, direction: ArrayLike = FRAMING_DIRECTION
) -> Camera:
    """The camera that sees all of `positions` (V, 3) from the world direction `direction`, as large as they fit.

    A point at (x, y, z) in the camera's axes is inside a pyramid of slope s with its tip at (x0, y0, D) where
    |x - x0| <= s (D - z); over all points this gives the smallest D and the x0 and y0 that centre the image.

    Parameters
    ----------
    aspect : width over height of the image.
    """
    columns = np.ascontiguousarray(np.asarray(positions, np.float64).T)  # ten times faster to search by component
    least, most = columns.min(axis=1), columns.max(axis=1)
    centre = (least + most) / 2.0
    direction = normalize(direction)
    up = (0.0, 1.0, 0.0) if abs(direction[1]) < 0.999 else (0.0, 0.0, -1.0)
    size = max(float(np.linalg.norm(most - least)), 1e-30)
    rotation = Camera(tuple(centre + size * direction), tuple(centre), up, fov_deg).camera_from_world
    x_y, z = rotation[:2] @ (columns - centre[:, None]), rotation[2] @ (columns - centre[:, None])
    slope = np.tan(np.radians(fov_deg) / 2.0) / 1.06 * np.array([aspect, 1.0])
    high = np.max(x_y + slope[:, None] * z, axis=1)
    low = np.min(x_y - slope[:, None] * z, axis=1)
    distance = max(float(np.max((high - low) / (2.0 * slope))), 1e-6 * size)
    centre = centre + (high + low) / 2.0 @ rotation[:2]
    return Camera(tuple(centre + distance * direction), tuple(centre), up, fov_deg)


def parse(text: str, default: Camera) -> Camera:
    """A camera from `eye=0,0,4 target=0,0,0 up=0,1,0 fov_deg=35`; what is left out is taken from `default`.

    Raises UsageError, saying what is known, for an unknown name or a bad number.
    """
    values: dict[str, tuple[float, ...] | float] = {}
    for item in text.split():
        name, equals, numbers = item.partition("=")
        if not equals or name not in _SETTINGS:
            meant = suggest(name, _SETTINGS)
            raise UsageError(f"unknown camera setting {item[:40]!r}{meant}; choose from {', '.join(_SETTINGS)}")
        try:
            parsed = tuple(float(number) for number in numbers.split(","))
        except ValueError:
            raise UsageError(f"{item[:40]!r} is not made of numbers") from None
        if len(parsed) != (1 if name == "fov_deg" else 3):
            raise UsageError(f"{item[:40]!r} needs {'one number' if name == 'fov_deg' else 'three numbers'}")
        values[name] = parsed[0] if name == "fov_deg" else parsed
    return dataclasses.replace(default, **values)  # type: ignore[arg-type]


def unparse(camera: Camera) -> str:
    """The text that `parse` turns back into `camera`."""
    vectors = (f"{name}={','.join(repr(x) for x in getattr(camera, name))}" for name in ("eye", "target", "up"))
    return f"{' '.join(vectors)} fov_deg={camera.fov_deg!r}"


def orbit(camera: Camera, azimuth: float, elevation: float) -> Camera:
    """Turntable: turn the eye around the target by `azimuth` about +Y and by `elevation` upwards, radians, no roll."""
    arm = np.subtract(camera.eye, camera.target)
    distance = float(np.sqrt(dot(arm, arm)))
    theta = float(np.arccos(np.clip(arm[1] / distance, -1.0, 1.0)))
    phi = float(np.arctan2(arm[0], arm[2])) + azimuth
    theta = float(np.clip(theta - elevation, 1e-3, np.pi - 1e-3))
    eye = np.asarray(camera.target) + distance * world_direction(theta, phi)
    return dataclasses.replace(camera, eye=tuple(eye), up=(0.0, 1.0, 0.0))


def pan(camera: Camera, right: float, up: float) -> Camera:
    """Move eye and target together by fractions of the height of the image at the target."""
    distance = float(np.linalg.norm(np.subtract(camera.eye, camera.target)))
    height = 2.0 * distance * np.tan(np.radians(camera.fov_deg) / 2.0)
    shift = height * (right * camera.camera_from_world[0] + up * camera.camera_from_world[1])
    return dataclasses.replace(camera, eye=tuple(camera.eye + shift), target=tuple(camera.target + shift))


def zoom(camera: Camera, factor: float) -> Camera:
    """Move the eye so that its distance to the target is multiplied by `factor` > 0."""
    arm = np.subtract(camera.eye, camera.target)
    return dataclasses.replace(camera, eye=tuple(np.asarray(camera.target) + factor * arm))
