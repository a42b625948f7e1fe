"""Compiled loops of `engine.transport.baking.visibility`: where rays start, and the rays of many vertices.

Each writes or reads its arrays once, some 10 ns a ray, which is little beside the casting.
"""

from __future__ import annotations

import math

import numpy as np

from engine.core.kernels import scalar

#: Faces turned further than this cosine against a normal are the far side of a sheet.
SHEET = -0.95

#: A direction that all faces around a place are turned to by this cosine is good enough, and so is the best in so many
#: tries; nothing is pushed further than so many offsets.
ENOUGH, TRIES, LONGEST = 0.25, 32, 8.0

#: Points in a box, and boxes in a box.
BLOCK = 32


@scalar
def face_normals(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(F, 3) unit normals; zero for faces without area."""
    normals = np.zeros((len(faces), 3))
    ab, ac = np.empty(3), np.empty(3)
    for face in range(len(faces)):
        largest = 0.0
        for axis in range(3):
            ab[axis] = positions[faces[face, 1], axis] - positions[faces[face, 0], axis]
            ac[axis] = positions[faces[face, 2], axis] - positions[faces[face, 0], axis]
            largest = max(largest, abs(ab[axis]), abs(ac[axis]))
        if not 0.0 < largest < np.inf:
            continue
        ab /= largest
        ac /= largest
        normal = normals[face]
        normal[0] = ab[1] * ac[2] - ab[2] * ac[1]
        normal[1] = ab[2] * ac[0] - ab[0] * ac[2]
        normal[2] = ab[0] * ac[1] - ab[1] * ac[0]
        length = math.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
        if length > 0.0:
            normal /= length
    return normals


@scalar
def _min_cosine(direction: np.ndarray, normal: np.ndarray, faces: np.ndarray, flat: np.ndarray) -> tuple[float, int]:
    """Smallest cosine between `direction` and the normal or the faces around; and which face has it, −1 the normal."""
    length = math.sqrt(_dot(direction, direction))
    if length == 0.0:
        return -1.0, -1
    least, worst = _dot(direction, normal) / length, -1
    for face in faces:
        if _dot(flat[face], normal) > SHEET:
            cosine = _dot(flat[face], direction) / length
            if cosine < least and _dot(flat[face], flat[face]) > 0.0:
                least, worst = cosine, face
    return least, worst


@scalar
def _dot(a: np.ndarray, b: np.ndarray) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@scalar
def outward(
    normals: np.ndarray, point: np.ndarray, start: np.ndarray, face: np.ndarray, flat: np.ndarray
) -> np.ndarray:
    """(V, 3) offsets of origins in units of the caster's; `face[start[p]:start[p + 1]]` meet at place p."""
    away = np.empty_like(normals)
    direction = np.empty(3)
    for vertex in range(len(normals)):
        normal, around = normals[vertex], face[start[point[vertex]] : start[point[vertex] + 1]]
        direction[:] = normal
        best, worst = _min_cosine(direction, normal, around, flat)
        away[vertex] = normal
        for _ in range(TRIES):
            if best >= ENOUGH:
                break
            direction += normal if worst < 0 else flat[worst]
            least, worst = _min_cosine(direction, normal, around, flat)
            if least > best:
                best = least
                away[vertex] = direction / math.sqrt(_dot(direction, direction))
        if best > 0.0:
            away[vertex] *= min(1.0 / best, LONGEST)
        else:
            away[vertex] = normal
    return away


@scalar
def _spread(number: int) -> int:
    """The ten lowest bits of a number, three places apart."""
    number = (number | (number << 16)) & 0x030000FF
    number = (number | (number << 8)) & 0x0300F00F
    number = (number | (number << 4)) & 0x030C30C3
    return (number | (number << 2)) & 0x09249249


@scalar
def boxes_of_boxes(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (P, 3) in [−1, 1]³ in Morton order, and the corners (B, 2, 3) of boxes of BLOCK and of BLOCK² points."""
    key = np.empty(len(points), np.int64)
    for index in range(len(points)):
        key[index] = 0
        for axis in range(3):
            cell = min(max(int((points[index, axis] + 1.0) * 512.0), 0), 1023)
            key[index] |= _spread(cell) << axis
    ordered = points[np.argsort(key)]
    inner = _boxes(ordered, BLOCK)
    return ordered, inner, _boxes(ordered, BLOCK * BLOCK)


@scalar
def _boxes(points: np.ndarray, size: int) -> np.ndarray:
    boxes = np.empty(((len(points) + size - 1) // size, 2, 3))
    boxes[:, 0] = np.inf
    boxes[:, 1] = -np.inf
    for index in range(len(points)):
        for axis in range(3):
            boxes[index // size, 0, axis] = min(boxes[index // size, 0, axis], points[index, axis])
            boxes[index // size, 1, axis] = max(boxes[index // size, 1, axis], points[index, axis])
    return boxes


@scalar
def _reaches(box: np.ndarray, normal: np.ndarray, height: float) -> bool:
    """True if some point of a box may lie higher than `height` along the normal."""
    highest = 0.0
    for axis in range(3):
        highest += max(normal[axis] * box[0, axis], normal[axis] * box[1, axis])
    return highest > height


@scalar
def nothing_above(
    places: np.ndarray, normals: np.ndarray, blocks: tuple[np.ndarray, np.ndarray, np.ndarray], rise: float
) -> np.ndarray:
    """(V,) whether no point lies higher than `rise` above the plane through a place across its normal."""
    points, inner, outer = blocks
    free = np.ones(len(places), np.bool_)
    for vertex in range(len(places)):
        normal = normals[vertex]
        height = _dot(normal, places[vertex]) + rise
        for large in range(len(outer)):
            if not free[vertex]:
                break
            if not _reaches(outer[large], normal, height):
                continue
            for small in range(large * BLOCK, min((large + 1) * BLOCK, len(inner))):
                if _reaches(inner[small], normal, height):
                    for point in points[small * BLOCK : (small + 1) * BLOCK]:
                        if _dot(normal, point) > height:
                            free[vertex] = False
                if not free[vertex]:
                    break
    return free


@scalar
def _chance(vertex: int, draw: int) -> float:
    """A number in [0, 1) that only the vertex and the number of the draw decide (the finaliser of SplitMix64)."""
    mixed = np.uint64(3 * vertex + draw + 1) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed = mixed ^ (mixed >> np.uint64(31))
    return np.float64(mixed >> np.uint64(11)) * 2.0**-53


@scalar
def hemisphere_rays(
    vertices: np.ndarray, origins: np.ndarray, normals: np.ndarray, pattern: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Origins (N D, 3) float64 and directions (N D, 3) float32: the pattern (D, 3) rotated about each normal."""
    count = len(pattern)
    origin = np.empty((len(vertices) * count, 3))
    direction = np.empty((len(vertices) * count, 3), np.float32)
    for row in range(len(vertices)):
        vertex = vertices[row]
        x, y, z = normals[vertex, 0], normals[vertex, 1], normals[vertex, 2]
        sign = 1.0 if z >= 0.0 else -1.0
        a = -1.0 / (sign + z)
        b = x * y * a
        angle = 2.0 * math.pi * _chance(vertex, 0)
        cosine, sine = math.cos(angle), math.sin(angle)
        for index in range(count):
            u = cosine * pattern[index, 0] - sine * pattern[index, 1]
            v = sine * pattern[index, 0] + cosine * pattern[index, 1]
            w = pattern[index, 2]
            ray = row * count + index
            direction[ray, 0] = u * (1.0 + sign * x * x * a) + v * b + w * x
            direction[ray, 1] = u * sign * b + v * (sign + y * y * a) + w * y
            direction[ray, 2] = -u * sign * x - v * y + w * z
            for axis in range(3):
                origin[ray, axis] = origins[vertex, axis]
    return origin, direction


@scalar
def _turn(vertex: int, angle: float, rotation: np.ndarray) -> None:
    """Fill the rotation vector (3,) of a vertex: a random axis and a turn by `angle`."""
    height = 2.0 * _chance(vertex, 1) - 1.0
    azimuth = 2.0 * math.pi * _chance(vertex, 2)
    across = math.sqrt(1.0 - height * height)
    rotation[0] = angle * across * math.cos(azimuth)
    rotation[1] = angle * across * math.sin(azimuth)
    rotation[2] = angle * height


@scalar
def _turn_direction(direction: np.ndarray, rotation: np.ndarray, normal: np.ndarray, out: np.ndarray) -> None:
    """Fill `out` with the turned direction, or with the direction itself where the turn takes it below the horizon."""
    out[0] = direction[0] + rotation[1] * direction[2] - rotation[2] * direction[1]
    out[1] = direction[1] + rotation[2] * direction[0] - rotation[0] * direction[2]
    out[2] = direction[2] + rotation[0] * direction[1] - rotation[1] * direction[0]
    if _dot(out, normal) <= 0.0:
        out[:] = direction


@scalar
def cube_rays(
    vertices: np.ndarray,
    free: np.ndarray,
    origins: np.ndarray,
    normals: np.ndarray,
    directions: np.ndarray,
    order: np.ndarray,
    angle: float,
    visible: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays of vertices (N,) towards those directions (T, 3) above their horizons, in that order and rotated by `angle`.

    Fills `visible` (N, T) with whether a direction is above the horizon. Returns, for the vertices that are not free,
    origins (R, 3) float64, directions (R, 3) float32 and the places (R,) of the rays in `visible`.
    """
    count = 0
    for row in range(len(vertices)):
        normal = normals[vertices[row]]
        for index in range(len(directions)):
            visible[row, index] = _dot(normal, directions[index]) > 0.0
            count += visible[row, index] and not free[row]
    origin, direction = np.empty((count, 3)), np.empty((count, 3), np.float32)
    place = np.empty(count, np.int64)
    rotation, turned = np.empty(3), np.empty(3)
    ray = 0
    for row in range(len(vertices)):
        if free[row]:
            continue
        vertex = vertices[row]
        _turn(vertex, angle, rotation)
        for index in order:
            if visible[row, index]:
                _turn_direction(directions[index], rotation, normals[vertex], turned)
                for axis in range(3):
                    origin[ray, axis] = origins[vertex, axis]
                    direction[ray, axis] = turned[axis]
                place[ray] = row * len(directions) + index
                ray += 1
    return origin, direction, place


@scalar
def finer_rays(
    vertices: np.ndarray,
    rows: np.ndarray,
    texels: np.ndarray,
    origins: np.ndarray,
    normals: np.ndarray,
    directions: np.ndarray,
    angle: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays like those of `cube_rays` towards finer directions (T, S, 3), for pairs of a row of `vertices` and a texel.

    Returns origins, directions and for each ray (R,) the number of its pair.
    """
    fine = directions.shape[1]
    most = len(rows) * fine
    origin, direction, pair = np.empty((most, 3)), np.empty((most, 3), np.float32), np.empty(most, np.int64)
    rotation, turned = np.empty(3), np.empty(3)
    ray = 0
    for index in range(len(rows)):
        vertex = vertices[rows[index]]
        _turn(vertex, angle, rotation)
        for sample in range(fine):
            towards = directions[texels[index], sample]
            if _dot(normals[vertex], towards) > 0.0:
                _turn_direction(towards, rotation, normals[vertex], turned)
                for axis in range(3):
                    origin[ray, axis] = origins[vertex, axis]
                    direction[ray, axis] = turned[axis]
                pair[ray] = index
                ray += 1
    return origin[:ray], direction[:ray], pair[:ray]


@scalar
def borders(visible: np.ndarray, neighbours: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows and texels of those of `visible` (N, T) that differ from one of the four beside them."""
    count = 0
    for fill in range(2):
        if fill:
            rows, texels = np.empty(count, np.int64), np.empty(count, np.int64)
            count = 0
        for row in range(visible.shape[0]):
            for texel in range(visible.shape[1]):
                differs = False
                for side in range(4):
                    differs = differs or visible[row, neighbours[texel, side]] != visible[row, texel]
                if differs:
                    if fill:
                        rows[count], texels[count] = row, texel
                    count += 1
    return rows, texels
