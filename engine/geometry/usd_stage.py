"""Meshes of USD files, wherever their stage places them, as their library composes it; runs in the decoder process.

Polygons are cut into triangles; normals, texture coordinates and colours are of a constant, a face, a point or a corner
(UsdGeomPrimvar). Subsets of faces have the materials that are bound to them. Left-handed meshes are turned, holes left
out, and instances placed (native ones and those of a PointInstancer). The world is that of glTF: y up, in metres, of
stages with z up (x, z, −y). What moves is where it is at its first time. Subdivision surfaces are their control meshes,
without stated normals (UsdGeomMesh); implicit shapes and curves are counted and left out.
The texture coordinates are those that the first texture of a material reads, with its UsdTransform2d. A colour of the
vertices is drawn where no material is bound (`displayColor`), or where the material reads it.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pxr import Ar, Sdf, Tf, Usd, UsdGeom, UsdShade

from engine.core.errors import InputError
from engine.geometry.gltf import NO_MATERIAL, place_part
from engine.geometry.polygons import Polygons, triangulate
from engine.storage.untrusted import AGAIN

Array = NDArray[np.float64]

#: Prims of a stage that are looked at, and corners of all faces that are drawn.
MAX_PRIMS, MAX_CORNERS = 200_000, 1 << 29

FIRST = Usd.TimeCode.EarliestTime()

#: Purposes of what is drawn.
_DRAWN = ("default", "render")

#: What is counted, most of it left out.
_COUNTED = (
    "implicit_shapes_dropped",
    "curves_and_points_dropped",
    "nested_instancers_dropped",
    "subdivision_surfaces",
)

#: Types of texture coordinates.
_PAIRS = ("texCoord2f[]", "texCoord2d[]", "texCoord2h[]", "float2[]", "double2[]", "half2[]")

#: Inputs of a surface in the order in which its texture coordinates count: of UsdPreviewSurface, and of MaterialX.
_ORDER = ("diffuseColor", "base_color", "roughness", "specular_roughness", "normal", "geometry_normal")


def prepare() -> None:
    """Compose a stage once, which loads what the library needs."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.XformCache(FIRST).GetLocalToWorldTransform(UsdGeom.Mesh.Define(stage, "/a").GetPrim())
    UsdShade.MaterialBindingAPI(stage.GetPrimAtPath("/a")).ComputeBoundMaterial()


def list_missing(folder: str, file: str, name: str) -> list[str]:
    """Layers that are named and not in the folder, by their names from there; InputError for one outside of it."""
    root = _open_layer(folder, file, name)
    missing, known, waiting = list[str](), {root.identifier}, [root]
    while waiting:
        layer = waiting.pop()
        for asset in layer.GetCompositionAssetDependencies():
            place = place_of(layer, asset)
            within = Ar.SplitPackageRelativePathOuter(place)[0] if Ar.IsPackageRelativePath(place) else place
            relative = os.path.relpath(within, folder)
            if relative.startswith("..") or asset.startswith(("/", "\\")) or "://" in asset:
                raise InputError(name, f"names a layer outside its folder ({asset[:60]!r})", "Export it as .usdz")
            if not Path(within).is_file():
                missing.append(Path(relative).as_posix())
            elif place not in known:
                known.add(place)
                waiting.append(_open_layer(folder, os.path.relpath(place, folder), name))
    return sorted(set(missing))


@contextmanager
def refuse_damaged(name: str, folder: str) -> Iterator[None]:
    """InputError in the place of what the library finds wrong with a file or with values in it, with its words."""
    try:
        yield
    except InputError:
        raise
    except (TypeError, ValueError, IndexError, OverflowError):
        raise InputError(name, "is damaged: a value in it is of another type or length", AGAIN) from None
    except Tf.ErrorException as error:
        try:
            said = str(error).rpartition(" : ")[2].rpartition(f"{folder}/")[2]
        except UnicodeDecodeError:  # the library quotes bytes of the file
            said = "its text is not UTF-8"
        words = " ".join(said.split())[:120]
        raise InputError(name, f"is damaged: the library of USD does not read it ({words})", AGAIN) from None


def _open_layer(folder: str, file: str, name: str) -> Any:
    """A layer among the copies; InputError where it is damaged, with the words of the library."""
    layer = Sdf.Layer.FindOrOpen(f"{folder}/{file}")
    if layer is None:
        raise InputError(name, "is damaged: the library of USD does not read it", AGAIN)
    return layer


def place_of(layer: Any, asset: str) -> str:
    """The path of what a layer calls `asset`, also within its package."""
    path = layer.identifier
    if Ar.IsPackageRelativePath(path):
        package, inner = Ar.SplitPackageRelativePathInner(path)
        folder = os.path.dirname(inner)  # noqa: PTH120 - paths of USD, not of the system
        return str(Ar.JoinPackageRelativePath(package, os.path.normpath(f"{folder}/{asset}".lstrip("/"))))
    if path.endswith(".usdz"):
        return str(Ar.JoinPackageRelativePath(path, os.path.normpath(asset)))
    return os.path.normpath(os.path.join(os.path.dirname(path), asset))  # noqa: PTH118, PTH120


def open_stage(folder: str, file: str, name: str) -> Any:
    """The stage of a file; InputError where it cannot be composed."""
    with refuse_damaged(name, folder):
        return Usd.Stage.Open(f"{folder}/{file}", Usd.Stage.LoadAll)


def read_stage(folder: str, name: str, file: str) -> Any:
    """See `engine.geometry.usd.read_usd`."""
    with refuse_damaged(name, folder):
        if missing := list_missing(folder, file, name):
            return {"missing": missing}
        stage = open_stage(folder, file, name)
        return _Reader(stage, name, name_materials(stage, name)).parts()


def list_materials(stage: Any, name: str) -> dict[str, Any]:
    """The materials of a stage by their keys (`key_of`)."""
    found: dict[str, Any] = {}
    for prim in _walk_all(stage, name):
        if prim.IsA(UsdShade.Material):
            found.setdefault(key_of(prim), UsdShade.Material(prim))
    return found


def name_materials(stage: Any, name: str) -> dict[str, str]:
    """The names of the materials of a stage by their keys, no two alike: those that are shown, where they have such."""
    found: dict[str, str] = {}
    for key, material in list_materials(stage, name).items():
        prim = material.GetPrim()
        short = (prim.GetDisplayName() or prim.GetName())[:60]
        found[key] = str(material.GetPath()) if short in found.values() or short == NO_MATERIAL else short
    return found


def list_used(stage: Any, name: str, names: dict[str, str]) -> list[str]:
    """The names of the materials of faces in the order of the stage; none where no mesh has one, or colours."""
    used, coloured = dict[str, None](), False
    for prim in _walk_all(stage, name):
        if prim.IsA(UsdGeom.Mesh):
            binding = UsdShade.MaterialBindingAPI(prim)
            owners = [*(each.GetPrim() for each in binding.GetMaterialBindSubsets()), prim]
            for owner in owners:
                material = UsdShade.MaterialBindingAPI(owner).ComputeBoundMaterial()[0]
                used[names.get(key_of(material.GetPrim()), NO_MATERIAL) if material else NO_MATERIAL] = None
            primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor")
            coloured = coloured or bool(primvar and primvar.HasValue())
    return list(used) if names or coloured else []


def _walk_all(stage: Any, name: str) -> Iterator[Any]:
    """All prims of a stage, with those of instances; InputError where they are too many."""
    prims = Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate))
    for count, prim in enumerate(prims):
        if count >= MAX_PRIMS:
            raise InputError(name, f"has more than {MAX_PRIMS:,} prims", "Join its parts and export it again")
        yield prim


def key_of(prim: Any) -> str:
    """The path of a prim, of one within instances that in their prototype."""
    return str((prim.GetPrimInPrototype() if prim.IsInstanceProxy() else prim).GetPath())


@dataclass(frozen=True)
class Coordinates:
    """Texture coordinates of a material: the primvar and a matrix (3, 2), by which (u, v, 1) is multiplied.

    `colours` is the primvar that it reads as its colour, '' for none.
    """

    primvar: str = "st"
    matrix: tuple[float, ...] = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)
    colours: str = ""


def list_coordinates(material: Any) -> list[Coordinates]:
    """Texture coordinates that the textures of a material read, in the order of their importance, each once."""
    shader = material.ComputeSurfaceSource()[0]
    found: list[Coordinates] = []
    colours = ""
    if shader:
        given = {each.GetBaseName(): each for each in shader.GetInputs()}
        names = [*(each for each in _ORDER if each in given), *(each for each in given if each not in _ORDER)]
        for each in names:
            source = source_of(given[each])
            if source is None:
                continue
            if each == _ORDER[0] and str(source.GetIdAttr().Get()) == "UsdPrimvarReader_float3":
                colours = str(value_of(source, "varname") or "")
            elif str(source.GetIdAttr().Get()) == "UsdUVTexture":
                found.append(_follow(source))
    unique = list(dict.fromkeys(found)) or [Coordinates()]
    return [Coordinates(each.primvar, each.matrix, colours) for each in unique]


def source_of(given: Any) -> Any:
    """The shader that an input gets its value from, through all graphs; None where it is a value."""
    attributes = given.GetValueProducingAttributes() if given else []
    if not attributes or UsdShade.Utils.GetType(attributes[0].GetName()) != UsdShade.AttributeType.Output:
        return None
    return UsdShade.Shader(attributes[0].GetPrim())


def value_of(shader: Any, name: str) -> Any:
    """The value of an input of a shader, None without one."""
    given = shader.GetInput(name)
    attributes = given.GetValueProducingAttributes() if given else []
    return attributes[0].Get(FIRST) if attributes else None


def _follow(texture: Any) -> Coordinates:
    """The texture coordinates of a UsdUVTexture: (u, v) times scale, turned, plus translation (UsdTransform2d)."""
    matrix = np.eye(3)
    source = source_of(texture.GetInput("st"))
    for _ in range(8):
        if source is None or str(source.GetIdAttr().Get()) != "UsdTransform2d":
            break
        scale, moved = value_of(source, "scale") or (1, 1), value_of(source, "translation") or (0, 0)
        angle = np.radians(float(value_of(source, "rotation") or 0.0))
        c, s = np.cos(angle), np.sin(angle)
        own = np.array([[scale[0] * c, scale[0] * s, 0.0], [-scale[1] * s, scale[1] * c, 0.0], [*moved, 1.0]])
        matrix = own @ matrix
        source = source_of(source.GetInput("in"))
    primvar = "st"
    if source is not None and str(source.GetIdAttr().Get()).startswith("UsdPrimvarReader"):
        primvar = str(value_of(source, "varname") or "st")
    return Coordinates(primvar, tuple(matrix[:, :2].ravel().tolist()))


class _Reader:
    """The parts of one stage."""

    def __init__(self, stage: Any, name: str, names: dict[str, str]) -> None:
        self.stage, self.name, self.names = stage, name, names
        self.cache = UsdGeom.XformCache(FIRST)
        self.left = MAX_CORNERS
        self.counts = dict.fromkeys(_COUNTED, 0)
        self.coordinates: dict[str, Coordinates] = {}
        turned = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.z
        axes = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]] if turned else np.eye(3), np.float64)
        self.world = np.eye(4)
        self.world[:3, :3] = UsdGeom.GetStageMetersPerUnit(stage) * axes

    def parts(self) -> list[dict[str, Any]]:
        """The parts in the world, with counts of what was left out."""
        parts: list[dict[str, Any]] = []
        skipped: list[Any] = []
        for prim in _walk_all(self.stage, self.name):
            if skipped and prim.GetPath().HasPrefix(skipped[-1]):
                continue
            if not prim.IsA(UsdGeom.Imageable) or not self._is_drawn(prim):
                continue
            if prim.IsA(UsdGeom.PointInstancer):
                parts += self._instances(UsdGeom.PointInstancer(prim), self._matrix(prim))
                skipped.append(prim.GetPath())
            else:
                parts += [place_part(each, self.world @ self._matrix(prim)) for each in self._shape(prim)]
        if not self.names and all(each["colours"] is None for each in parts):
            for each in parts:
                each["material"] = None
        if parts:
            parts[0]["counts"] = self.counts
        return parts

    def _is_drawn(self, prim: Any) -> bool:
        seen = UsdGeom.Imageable(prim)
        return seen.ComputePurpose() in _DRAWN and seen.ComputeVisibility(FIRST) != UsdGeom.Tokens.invisible

    def _matrix(self, prim: Any) -> Array:
        return np.array(self.cache.GetLocalToWorldTransform(prim), np.float64).T

    def _instances(self, instancer: Any, world_from_instancer: Array) -> list[dict[str, Any]]:
        """The parts of the prototypes of a PointInstancer, wherever it places them."""
        indices = instancer.GetProtoIndicesAttr().Get(FIRST) or []
        matrices = instancer.ComputeInstanceTransformsAtTime(FIRST, FIRST) or []
        mask = instancer.ComputeMaskAtTime(FIRST) or [True] * len(indices)
        shapes = [self._prototype(path) for path in instancer.GetPrototypesRel().GetForwardedTargets()]
        parts = []
        for index, matrix, shown in zip(indices, matrices, mask, strict=False):
            if not 0 <= index < len(shapes):
                raise InputError(self.name, "is damaged: an instance has a prototype that is not there", AGAIN)
            if shown:
                placed = self.world @ world_from_instancer @ np.array(matrix, np.float64).T
                self._take(sum(len(each["positions"]) for each in shapes[index]))
                parts += [place_part(each, placed) for each in shapes[index]]
        return parts

    def _prototype(self, path: Any) -> list[dict[str, Any]]:
        """The parts below a prototype in its own coordinates."""
        root = self.stage.GetPrimAtPath(path)
        parts = []
        own_from_world = np.linalg.inv(self._matrix(root)) if root else np.eye(4)
        for prim in Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)) if root else ():
            self.counts["nested_instancers_dropped"] += prim.IsA(UsdGeom.PointInstancer)
            if prim.IsA(UsdGeom.Imageable) and self._is_drawn(prim):
                parts += [place_part(each, own_from_world @ self._matrix(prim)) for each in self._shape(prim)]
        return parts

    def _take(self, corners: int) -> None:
        self.left -= corners
        if self.left < 0:
            raise InputError(self.name, f"has faces of more than {MAX_CORNERS:,} corners", "Reduce it")

    def _shape(self, prim: Any) -> list[dict[str, Any]]:
        """The parts of a mesh, one for each material; none for other prims, which are counted."""
        if not prim.IsA(UsdGeom.Mesh):
            self.counts["implicit_shapes_dropped"] += prim.IsA(UsdGeom.Gprim) and not prim.IsA(UsdGeom.PointBased)
            self.counts["curves_and_points_dropped"] += prim.IsA(UsdGeom.PointBased)
            return []
        mesh = UsdGeom.Mesh(prim)
        points = _table(mesh.GetPointsAttr(), 3)
        sizes = np.array(mesh.GetFaceVertexCountsAttr().Get(FIRST) or [], np.int64)
        index = np.array(mesh.GetFaceVertexIndicesAttr().Get(FIRST) or [], np.int64)
        self._take(len(index))
        if sizes.min(initial=0) < 0 or sizes.sum() != len(index):
            raise InputError(self.name, f"is damaged: {prim.GetPath()} has other corners than its faces count", AGAIN)
        if not len(points) or not len(index):
            return []
        inside = (index >= 0) & (index < len(points))
        triangles = triangulate(Polygons(points, index, sizes))
        faces = np.where(np.all(inside[triangles], axis=1, keepdims=True), triangles, -1)
        if mesh.GetOrientationAttr().Get(FIRST) == UsdGeom.Tokens.leftHanded:
            faces = faces[:, ::-1]
        face_of_corner = np.repeat(np.arange(len(sizes)), sizes)
        face = face_of_corner[triangles[:, 0]]
        faces[np.isin(face, np.array(mesh.GetHoleIndicesAttr().Get(FIRST) or [], np.int64))] = -1
        is_smooth = mesh.GetSubdivisionSchemeAttr().Get(FIRST) != UsdGeom.Tokens.none
        self.counts["subdivision_surfaces"] += is_smooth
        spread = _Spread(np.where(inside, index, 0), face_of_corner, len(points))
        normals = None if is_smooth else self._normals(mesh, spread)
        parts: list[dict[str, Any]] = []
        for material, chosen in self._subsets(prim, len(sizes)):
            key = "" if material is None else key_of(material.GetPrim())
            place = self._coordinates(key, material)
            colours = "displayColor" if material is None else place.colours
            tables = {
                "positions": points[spread.point],
                "normals": normals,
                "uv": self._uv(prim, place, spread),
                "colours": self._primvar(prim, colours, 3, spread) if colours else None,
            }
            own = chosen[face_of_corner]  # corners of the part alone, in their order
            number = np.append(np.cumsum(own) - 1, -1)
            kept = {name: None if table is None else table[own] for name, table in tables.items()}
            material_name = self.names.get(key, NO_MATERIAL)
            parts.append({**kept, "faces": number[faces[chosen[face]]], "material": material_name})
        return [each for each in parts if len(each["faces"])]

    def _subsets(self, prim: Any, count: int) -> list[tuple[Any, NDArray[np.bool_]]]:
        """Materials, None for none, with which of so many faces have them."""
        binding = UsdShade.MaterialBindingAPI(prim)
        subsets = binding.GetMaterialBindSubsets()
        left = np.ones(count, np.bool_)
        found = []
        for subset in subsets:
            chosen = np.zeros(count, np.bool_)
            indices = np.array(subset.GetIndicesAttr().Get(FIRST) or [], np.int64)
            chosen[indices[(indices >= 0) & (indices < count)]] = True
            material = UsdShade.MaterialBindingAPI(subset.GetPrim()).ComputeBoundMaterial()[0]
            found.append((material if material else None, chosen & left))
            left &= ~chosen
        material = binding.ComputeBoundMaterial()[0]
        return [*found, (material if material else None, left)]

    def _coordinates(self, key: str, material: Any) -> Coordinates:
        if key not in self.coordinates:
            self.coordinates[key] = Coordinates() if material is None else list_coordinates(material)[0]
        return self.coordinates[key]

    def _normals(self, mesh: Any, spread: _Spread) -> Array | None:
        stated = self._primvar(mesh.GetPrim(), "normals", 3, spread)
        if stated is not None:
            return stated
        table = _table(mesh.GetNormalsAttr(), 3)
        return spread.look_up(table, mesh.GetNormalsInterpolation()) if len(table) else None

    def _uv(self, prim: Any, place: Coordinates, spread: _Spread) -> Array | None:
        primvars = UsdGeom.PrimvarsAPI(prim).FindPrimvarsWithInheritance()
        known = [each.GetPrimvarName() for each in primvars if str(each.GetTypeName()) in _PAIRS]
        name = next((each for each in (place.primvar, "st", "UVMap", *known) if each in known), "")
        uv = self._primvar(prim, name, 2, spread) if name else None
        matrix = np.array(place.matrix).reshape(3, 2)
        return None if uv is None else uv @ matrix[:2] + matrix[2]

    def _primvar(self, prim: Any, name: str, columns: int, spread: _Spread) -> Array | None:
        """A primvar, also one of what the prim lies in, at the corners (C, columns); None where it is none."""
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(name)
        if not primvar or not primvar.HasValue():
            return None
        values: Array = np.array(primvar.ComputeFlattened(FIRST), np.float64)
        if values.size % columns:
            return None
        return spread.look_up(values.reshape(-1, columns), primvar.GetInterpolation())


@dataclass(frozen=True)
class _Spread:
    """The point and the face of each corner (C,) of a mesh with so many points."""

    point: NDArray[np.int64]
    face: NDArray[np.int64]
    points: int

    def look_up(self, table: Array, interpolation: str) -> Array | None:
        """A table of a constant, of faces, points or corners at the corners; None where it has another length."""
        places = {
            "constant": np.zeros_like(self.point),
            "uniform": self.face,
            "faceVarying": np.arange(len(self.point)),
        }
        place = places.get(interpolation, self.point)
        needed = {"constant": 1, "uniform": int(self.face.max()) + 1, "faceVarying": len(self.point)}
        least = needed.get(interpolation, self.points)
        return table[place] if len(table) >= least else None


def _table(attribute: Any, columns: int) -> Array:
    values = np.array(attribute.Get(FIRST) or [], np.float64)
    return values.reshape(-1, columns)
