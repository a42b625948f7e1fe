"""Positions of near lamps from two mirror spheres: each shows a ray to the lamp, and the rays meet in it.

Both spheres lie on the sample, so the centre of one with radius R stands R above it. An orthographic camera along +z
sees the lamp where the sphere's normal n halves the angle between camera and lamp, at the point C + R n, and the lamp
lies from there along l = 2 (n . v) n - v (`engine.capture.lights.mirror_sphere`). Two such rays do not quite meet: the
lamp is taken at the point with the least sum of squared distances to both.
An error of d pixels of a highlight turns its ray by about 2 d / R, so lamps that are farther than a few times R / (2 d)
of the distance between the spheres are as good as infinitely far.

Conventions: pixels, x to the right and y up from the middle of the image, z towards the camera, 0 in the sample.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.mirror_sphere import Circle, light_direction

#: Rays that enclose less than the angle that so many pixels of both highlights make are taken as parallel.
UNCERTAIN_PX = 1.0


def lamp_positions(
    spheres: tuple[Circle, Circle], spots: NDArray[np.float64], height: int, width: int
) -> NDArray[np.float64]:
    """(N, 3) lamps in pixels from the middle of an image of `height` × `width`; infinite for rays that are parallel.

    `spots` (N, 2, 2) are column and row of the highlight on each sphere. Raises UsageError for one outside its sphere.
    """
    positions = np.empty((len(spots), 3))
    limit = UNCERTAIN_PX * sum(2.0 / sphere.radius for sphere in spheres)
    for index, both in enumerate(spots):
        rays = [_ray(sphere, spot, height, width) for sphere, spot in zip(spheres, both, strict=True)]
        (start, one), (other_start, other) = rays
        if np.linalg.norm(np.cross(one, other)) < limit:
            positions[index] = np.inf
            continue
        across = [np.eye(3) - np.outer(ray, ray) for ray in (one, other)]
        positions[index] = np.linalg.solve(across[0] + across[1], across[0] @ start + across[1] @ other_start)
    return positions


def _ray(
    sphere: Circle, spot: NDArray[np.float64], height: int, width: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The point of the sphere that shows the lamp, and the direction from there."""
    direction = light_direction(sphere, float(spot[0]), float(spot[1]))
    normal = direction + np.array([0.0, 0.0, 1.0])
    centre = np.array([sphere.column - width / 2, height / 2 - sphere.row, sphere.radius])
    return centre + sphere.radius * normal / np.linalg.norm(normal), direction
