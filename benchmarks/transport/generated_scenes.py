"""Scenes drawn by seed, to hold predictions against: models, BRDFs, environments and rotations that nobody chose.

Models are dented balls, balls that cut each other, tori and crumpled sheets of some thousand vertices, and those of a
folder of files where one is given. BRDFs are the analytic models between matt and mirror, published fits, brushed
metal, interference films and retro-reflecting tapes, and measured files of the folder. Environments are the built-in
ones, and skies with softboxes and suns of 1e2 … 1e5 times their radiance.

`generate_varied` draws from another family beside it, of which predictions learn: solids that are added to and cut out
of each other, subdivided polyhedra, brushed and retro-reflecting models, and environments of few or of many lights.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from engine.brdf.brdf import brdf_from_text
from engine.brdf.models.presets import PRESETS
from engine.core.directions import Vectors, dot, normalize
from engine.core.errors import FileError
from engine.factor.factor_file import open_reflectance
from engine.geometry.camera import frame
from engine.geometry.mesh import Mesh, read_mesh
from engine.geometry.shapes import grid_mesh
from engine.light.environment import EnvironmentMap, texel_directions
from engine.light.environment_file import open_environment
from engine.scene.scene import Scene

Array = NDArray[np.float64]

#: Rows of the grids that models are made of, and rows of environments.
ROWS, MAP_ROWS = 32, 64

#: Vertices of a model of the folder, at least and at most: fewer are no shape, more take minutes.
VERTICES = (100, 12_000)

#: Endings of models and of measured BRDFs that are taken from a folder.
MODELS, MEASURED = (".obj", ".ply", ".stl"), (".bsdf", ".binary", ".bin")

#: Built-in environments, one of which is every fifth light.
BUILT_IN = ("studio", "noon", "evening", "sunset", "overcast", "softboxes", "ring-light", "window")

#: Least and most exponent of ten of a sun's radiance over its sky.
SUNS = (2.0, 5.0)


@dataclass(frozen=True)
class Film:
    """A metal under an interference film: its colour turns with the half vector's angle to the light."""

    alpha: float
    optical_path: float
    isotropic: bool = True
    reciprocal: bool = True
    energy_conserving: bool = True

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        cosine = np.clip(dot(wi, normalize(wi + wo, (0.0, 0.0, 1.0))), 0.0, 1.0)[..., None]
        phase = 2.0 * math.pi * self.optical_path * cosine / np.array([0.65, 0.54, 0.45])
        metal = brdf_from_text(f"ggx:kd=0,alpha={self.alpha:.4g},f0=1")
        return np.asarray(metal.f(wi, wo) * (0.1 + 0.8 * np.cos(phase) ** 2))


@dataclass(frozen=True)
class Tape:
    """Grey cloth with beads that send light back towards where it comes from, as dense as a power of the cosine."""

    exponent: float
    isotropic: bool = True
    reciprocal: bool = True
    energy_conserving: bool = True

    def f(self, wi: ArrayLike, wo: ArrayLike) -> Vectors:
        wi, wo = np.broadcast_arrays(np.asarray(wi, np.float64), np.asarray(wo, np.float64))
        lit = (wi[..., 2] > 0.0) & (wo[..., 2] > 0.0)
        back = np.clip(dot(wi, wo), 0.0, 1.0) ** self.exponent * (self.exponent + 1.0) / (2.0 * math.pi)
        return np.asarray(np.where(lit, 0.1 / math.pi + 0.4 * back, 0.0)[..., None] * np.ones(3))


def generate(seed: int, data: Path | None = None) -> tuple[str, Scene]:
    """The scene of `seed` with its name; files of the folder `data` join the models and the BRDFs."""
    rng = np.random.default_rng((17, seed))
    model, mesh = _model(rng, data)
    reflectance, brdf = _brdf(rng, data)
    light, environment = _environment(rng)
    turn = float(rng.uniform(0.0, 2.0 * math.pi))
    scene = Scene(mesh, frame(mesh.positions), brdf, environment=environment, environment_rotation=turn)
    return f"{model}, {reflectance}, {light}, turned by {math.degrees(turn):.0f}°", scene


#: Cells along a side of the grid that solids are cut on, and about the most vertices of a varied model.
CELLS, VARIED_VERTICES = 18, 3_000


def generate_varied(seed: int) -> tuple[str, Scene]:
    """The scene of `seed` in the varied family, with its name; one in three is of the family of `generate`."""
    rng = np.random.default_rng((19, seed))
    if seed % 3 == 0:
        return generate(10_000 + seed)
    model, mesh = (_carve_solid, _subdivide_hull)[rng.integers(2)](rng)
    reflectance, brdf = _draw_brdf(rng)
    light, environment = (_few_lights, _many_lights)[rng.integers(2)](rng)
    turn = float(rng.uniform(0.0, 2.0 * math.pi))
    scene = Scene(mesh, frame(mesh.positions), brdf, environment=environment, environment_rotation=turn)
    return f"{model}, {reflectance}, {light}, turned by {math.degrees(turn):.0f}°", scene


def _carve_solid(rng: np.random.Generator) -> tuple[str, Mesh]:
    """A ball or a box to which some are added, and out of which others are cut."""
    parts = [(rng.integers(2), np.zeros(3), 0.75, True)]
    for _ in range(rng.integers(1, 5)):
        parts.append((rng.integers(2), normalize(rng.normal(size=3)) * 0.6, rng.uniform(0.2, 0.5), rng.random() < 0.4))

    def outside(points: Array) -> Array:
        """Negative inside the solid."""
        found = np.full(points.shape[:-1], np.inf)
        for kind, middle, size, added in parts:
            local = np.abs(points - middle) if kind else np.linalg.norm(points - middle, axis=-1, keepdims=True)
            distance = local.max(axis=-1) - (0.7 * size if kind else size)
            found = np.minimum(found, distance) if added else np.maximum(found, -distance)
        return found

    return "carved solid", isosurface(outside, CELLS)


def isosurface(outside: Any, cells: int) -> Mesh:
    """The surface on which `outside` changes its sign within [−1.3, 1.3]³: marching tetrahedra on so many cells³."""
    axis = np.linspace(-1.3, 1.3, cells + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1)
    value = outside(points).ravel()
    points = points.reshape(-1, 3)
    step = np.array([(cells + 1) ** 2, cells + 1, 1])
    first = (np.stack(np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"), -1).reshape(-1, 3) @ step)[:, None]
    ways = [(0, 1, 2), (1, 2, 0), (2, 0, 1), (0, 2, 1), (2, 1, 0), (1, 0, 2)]
    paths = np.array([np.cumsum([0, *step[list(way)]]) for way in ways])
    solids = (first[:, None] + paths[None]).reshape(-1, 4)
    inside = value[solids] < 0.0
    triangles = []
    for kind in range(1, 15):
        within = [corner for corner in range(4) if kind >> corner & 1]
        without = [corner for corner in range(4) if corner not in within]
        cut = solids[(inside == [(kind >> corner & 1) == 1 for corner in range(4)]).all(axis=1)]
        edges = [(one, other) for one in within for other in without]
        ends = np.stack([cut[:, list(edge)] for edge in edges], 1) if len(cut) else np.zeros((0, len(edges), 2), int)
        corners = [(0, 1, 2)] if len(edges) == 3 else [(0, 1, 3), (0, 3, 2)]
        triangles += [ends[:, list(three)] for three in corners]
    pairs, faces = np.unique(np.sort(np.concatenate(triangles).reshape(-1, 2), axis=1), axis=0, return_inverse=True)
    one, other = value[pairs[:, 0]], value[pairs[:, 1]]
    share = (one / (one - other))[:, None]
    positions = points[pairs[:, 0]] * (1.0 - share) + points[pairs[:, 1]] * share
    small = 1e-3 * np.eye(3)
    normals = normalize(np.stack([outside(positions + each) - outside(positions - each) for each in small], -1))
    faces = faces.reshape(-1, 3)
    across = np.cross(positions[faces[:, 1]] - positions[faces[:, 0]], positions[faces[:, 2]] - positions[faces[:, 0]])
    wrong = dot(across, normals[faces].mean(axis=1)) < 0.0
    faces[wrong] = faces[wrong][:, ::-1]
    kept = np.linalg.norm(across, axis=1) > 1e-9
    return Mesh(positions, normals.astype(np.float32), _around(positions), faces[kept].astype(np.int32), "solid")


def _subdivide_hull(rng: np.random.Generator) -> tuple[str, Mesh]:
    """The hull of some points, subdivided after Loop until it is smooth."""
    hull = trimesh.convex.convex_hull(rng.normal(size=(rng.integers(6, 14), 3)))
    hull.vertices[rng.random(len(hull.vertices)) < 0.4] *= rng.uniform(0.3, 0.8)
    while 4 * len(hull.vertices) < VARIED_VERTICES:
        hull = hull.subdivide_loop(1)
    positions = np.asarray(hull.vertices - hull.vertices.mean(axis=0))
    positions /= np.abs(positions).max()
    normals = np.asarray(hull.vertex_normals, np.float32)
    return "subdivided hull", Mesh(positions, normals, _around(positions), np.asarray(hull.faces, np.int32), "hull")


def _around(positions: Array) -> NDArray[np.float32]:
    """Texture coordinates by longitude and height, so that tangents go round the axis."""
    turn = np.arctan2(positions[:, 0], positions[:, 2]) / (2.0 * math.pi) + 0.5
    return np.stack([turn, positions[:, 1]], -1).astype(np.float32)


def _draw_brdf(rng: np.random.Generator) -> tuple[str, Any]:
    alpha, other = 10.0 ** rng.uniform(-1.0, -0.2), 10.0 ** rng.uniform(-1.0, -0.2)
    colour = rng.uniform(0.05, 0.9)
    if (kind := rng.integers(7)) == 0:
        return "tape", Tape(float(rng.uniform(5.0, 60.0)))
    texts = (
        f"ggx-anisotropic:kd={0.5 * colour:.3f},alpha_x={alpha:.3f},alpha_y={other:.3f},f0=0.04",
        f"ggx-anisotropic:kd=0,alpha_x={alpha:.3f},alpha_y={other:.3f},f0=0.9",
        f"ggx:kd={0.6 * colour:.3f},alpha={alpha:.3f},f0=0.04",
        f"cook-torrance:kd={0.4 * colour:.3f},m={0.6 * alpha:.3f},f0=0.1",
        f"oren-nayar:sigma_deg={rng.uniform(5.0, 40.0):.1f}",
        f"ashikhmin-shirley:nu={10.0 ** rng.uniform(0.7, 2.3):.1f},nv={10.0 ** rng.uniform(0.7, 2.3):.1f}",
    )
    return texts[kind - 1], brdf_from_text(texts[kind - 1])


def _few_lights(rng: np.random.Generator) -> tuple[str, EnvironmentMap]:
    """One to four discs of some degrees before a faint sky."""
    count = int(rng.integers(1, 5))
    return f"{count} lights", _discs(rng, count, (2.0, 12.0), (1.0, 3.0), rng.uniform(0.01, 0.3))


def _many_lights(rng: np.random.Generator) -> tuple[str, EnvironmentMap]:
    """Tens of discs and soft lights."""
    count = int(rng.integers(15, 60))
    return f"{count} lights", _discs(rng, count, (3.0, 20.0), (0.0, 2.0), rng.uniform(0.05, 0.5))


def _discs(
    rng: np.random.Generator, count: int, degrees: tuple[float, float], levels: tuple[float, float], sky: float
) -> EnvironmentMap:
    towards = texel_directions(MAP_ROWS, 2 * MAP_ROWS)
    radiance = np.full(towards.shape, sky) * rng.uniform(0.6, 1.0, 3)
    for _ in range(count):
        inside = towards @ _upward(rng) > math.cos(math.radians(rng.uniform(*degrees)))
        radiance = radiance + 10.0 ** rng.uniform(*levels) * inside[..., None] * rng.uniform(0.5, 1.0, 3)
    return EnvironmentMap(radiance.astype(np.float32), "lights")


def _model(rng: np.random.Generator, data: Path | None) -> tuple[str, Mesh]:
    files = _files(data, MODELS)
    if files and rng.random() < 0.5:
        path = files[rng.integers(len(files))]
        mesh = _read(path)
        if mesh is not None:
            return path.stem, mesh
    kind = ("dented ball", "balls", "torus", "sheet")[rng.integers(4)]
    u, v = np.meshgrid(np.linspace(0.0, 1.0, 2 * ROWS), np.linspace(0.0, 1.0, ROWS))
    if kind == "sheet":
        height = sum(_wave(rng, u, v) for _ in range(4))
        points = np.stack([2.0 * u - 1.0, 2.0 * v - 1.0, 0.15 * height], -1)
    elif kind == "torus":
        thick, turn, around = rng.uniform(0.2, 0.45), 2.0 * math.pi * u, 2.0 * math.pi * v
        ring = 1.0 - thick + thick * np.cos(around)
        points = np.stack([ring * np.cos(turn), ring * np.sin(turn), thick * np.sin(around)], -1)
    else:
        towards = _sphere(u, v)
        depth = rng.uniform(0.0, 0.25) if kind == "dented ball" else 0.0
        phases = rng.uniform(2.0, 6.0, 3)
        points = towards * (1.0 + depth * np.prod(np.cos(phases * towards + phases), axis=-1))[..., None]
    mesh = _close(kind, points, u, v)
    return (kind, mesh) if kind != "balls" else (kind, _beside(mesh, rng))


def _wave(rng: np.random.Generator, u: Array, v: Array) -> Array:
    along, across, phase = rng.uniform(-9.0, 9.0, 3)
    return np.asarray(np.sin(along * u + across * v + phase))


def _sphere(u: Array, v: Array) -> Array:
    theta, phi = math.pi * (1e-3 + (1.0 - 2e-3) * (1.0 - v)), 2.0 * math.pi * u
    return np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)], -1)


def _close(name: str, points: Array, u: Array, v: Array) -> Mesh:
    """The grid as a mesh, its normals turned outwards, those along a seam from both of its sides."""
    along, upwards = np.gradient(points, axis=1), np.gradient(points, axis=0)
    if name != "sheet":
        along[:, 0] = along[:, -1] = points[:, 1] - points[:, -2]
    if name == "torus":
        upwards[0] = upwards[-1] = points[1] - points[-2]
    return grid_mesh(name, points, normalize(np.cross(along, upwards)), np.stack([2.0 * u, v], -1))


def _beside(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    """Some copies of a ball, larger and smaller, that cut each other."""
    places = [(np.zeros(3), 1.0)]
    places += [(normalize(rng.normal(size=3)) * rng.uniform(0.8, 1.3), rng.uniform(0.3, 0.7)) for _ in range(2)]
    count = len(mesh.positions)
    positions = np.concatenate([size * mesh.positions + place for place, size in places])
    faces = np.concatenate([mesh.faces + np.int32(number * count) for number in range(len(places))])
    normals, uv = np.concatenate([mesh.normals] * len(places)), np.concatenate([mesh.uv] * len(places))
    return Mesh(positions, normals, uv, faces, "balls")


def _brdf(rng: np.random.Generator, data: Path | None) -> tuple[str, Any]:
    files = _files(data, MEASURED)
    if files and rng.random() < 0.1:
        path = files[rng.integers(len(files))]
        measured = _open(path)
        if measured is not None:
            return path.stem, measured
    alpha = 10.0 ** rng.uniform(-1.0, -0.2)
    if (kind := rng.integers(10)) == 0:
        return "film", Film(alpha, float(rng.uniform(0.4, 2.0)))
    if kind == 1:
        return "tape", Tape(float(rng.uniform(5.0, 60.0)))
    texts = (
        f"lambert:albedo={rng.uniform(0.1, 0.9):.3f}",
        f"oren-nayar:sigma_deg={rng.uniform(5.0, 40.0):.1f}",
        f"phong:kd={rng.uniform(0.0, 0.4):.3f},ks=0.4,exponent={10.0 ** rng.uniform(0.7, 2.2):.1f}",
        f"ggx:kd={rng.uniform(0.1, 0.6):.3f},alpha={alpha:.3f},f0=0.04",
        f"ggx:kd=0,alpha={alpha:.3f},f0={rng.uniform(0.5, 1.0):.2f}",
        f"ward:alpha_x={alpha:.3f},alpha_y={min(1.0, alpha * rng.uniform(1.5, 4.0)):.3f}",
        f"ashikhmin-shirley:nu={10.0 ** rng.uniform(0.7, 2.0):.1f},nv={10.0 ** rng.uniform(0.7, 2.0):.1f}",
        PRESETS[rng.integers(len(PRESETS))].text,
    )
    text = texts[kind - 2]
    return text, brdf_from_text(text)


def _environment(rng: np.random.Generator) -> tuple[str, EnvironmentMap]:
    if rng.random() < 0.2:
        name = BUILT_IN[rng.integers(len(BUILT_IN))]
        return name, open_environment(name)
    towards = texel_directions(MAP_ROWS, 2 * MAP_ROWS)
    above, below = rng.uniform(0.1, 1.0, 3), rng.uniform(0.0, 0.4, 3)
    radiance = below + (above - below) * (0.5 + 0.5 * towards[..., 1:2])
    for _ in range(rng.integers(3)):
        middle, width, level = _upward(rng), rng.uniform(0.1, 0.6), 10.0 ** rng.uniform(0.0, 1.5)
        radiance = radiance + level * np.exp(-(1.0 - towards @ middle) / width**2 * 2.0)[..., None]
    name = "sky"
    if rng.random() < 0.6:
        level = 10.0 ** rng.uniform(*SUNS)
        inside = towards @ _upward(rng) > math.cos(math.radians(rng.uniform(1.5, 2.5)))
        radiance = radiance + level * inside[..., None] * rng.uniform(0.6, 1.0, 3)
        name = f"sky with a sun of {level:.0f}"
    return name, EnvironmentMap(radiance.astype(np.float32), name)


def _upward(rng: np.random.Generator) -> Array:
    """A direction, more often from above than from below."""
    direction = normalize(rng.normal(size=3))
    direction[1] = abs(direction[1]) if rng.random() < 0.8 else direction[1]
    return direction


@cache
def _files(data: Path | None, endings: tuple[str, ...]) -> tuple[Path, ...]:
    """Files of a folder with these endings, in the order of their names."""
    return () if data is None else tuple(sorted(each for each in data.rglob("*") if each.suffix in endings))


@cache
def _read(path: Path) -> Mesh | None:
    """The model of a file; None where it cannot be read, or is too small or too large."""
    try:
        mesh = read_mesh(path)
    except FileError:
        return None
    return mesh if VERTICES[0] <= len(mesh.positions) <= VERTICES[1] else None


@cache
def _open(path: Path) -> Any:
    """The BRDF of a file; None where it cannot be read."""
    try:
        return open_reflectance(str(path))
    except FileError:
        return None
