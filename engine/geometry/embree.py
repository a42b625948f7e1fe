"""embree's own functions, called from compiled loops with packets of sixteen rays.

The wheel of embreex carries embree 4, but its Python class casts one ray at a time. Where embree's functions can be
found through the modules that embreex has loaded, they are bound here (Embree 4.4 API, `rtcore_ray.h` and
`rtcore_scene.h`), at two to three times the speed of the class; `embree_scene` takes the class where they cannot.
Both see the triangles in float32 and in robust mode (no ray slips through between neighbours), and both release the
interpreter lock. Bound by embree's traversal, some 0.5 µs a ray on a core.
"""

from __future__ import annotations

import ctypes
import weakref
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import psutil
from numpy.typing import NDArray

from engine.core.kernels import intrinsic, scalar

if TYPE_CHECKING:
    from llvmlite.ir import IRBuilder, Value
    from numba.core.base import BaseContext
    from numba.core.types import Type
    from numba.core.typing import Context, Signature

Floats = NDArray[np.floating]

#: Rays in a packet, and the fields of four bytes of its struct: 12 of the ray, 8 of the hit, and room to spare.
LANES, FIELDS = 16, 24

#: Each component of a unit direction is moved by up to so much, at random: some roundings of float32, well below what
#: offsets of origins clear. Of rays aimed exactly at a vertex, one in 200 slips through where its edges meet, since
#: their tests round differently; of rays moved so, one in 100,000.
NUDGE = 8e-7

#: Rows of the fields in the struct RTCRayHit16.
_DIRECTION, _FAR, _MASK, _PRIMITIVE, _GEOMETRY, _INSTANCE = 4, 8, 9, 17, 18, 19

#: RTC_SCENE_FLAG_ROBUST, RTC_GEOMETRY_TYPE_TRIANGLE, RTC_BUFFER_TYPE_INDEX and _VERTEX, RTC_FORMAT_UINT3 and _FLOAT3.
_ROBUST, _TRIANGLE, _INDEX, _VERTEX, _UINT3, _FLOAT3 = 4, 0, 0, 1, 0x5003, 0x9003

#: RTC_RAY_QUERY_FLAG_COHERENT, RTC_DEVICE_PROPERTY_VERSION_MAJOR.
_COHERENT, _MAJOR = 1 << 16, 1


class Scene(Protocol):
    """Triangles that rays can be cast at.

    Both functions take origins and directions (N, 3), float64 or float32, move the origins by −`centre`, scale them by
    `scale`, and fill (N,) arrays; rays that are not finite or have no direction meet nothing. `coherent` says that rays
    that follow each other are alike, and only changes the speed.
    """

    def occluded(
        self,
        origin: Floats,
        direction: Floats,
        centre: Floats,
        scale: float,
        found: NDArray[np.bool_],
        coherent: bool = False,
    ) -> None: ...

    def intersect(
        self,
        origin: Floats,
        direction: Floats,
        centre: Floats,
        scale: float,
        found: NDArray[np.int32],
        coherent: bool = False,
    ) -> None: ...


def embree_scene(positions: NDArray[np.float32], faces: NDArray[np.int32]) -> Scene:
    """A scene of the triangles (F, 3), which it copies. MemoryError where embree finds no room for its tree."""
    functions = embree_functions()
    return ClassScene(positions, faces) if functions is None else PacketScene(functions, positions, faces)


class PacketScene:
    """A scene of embree's own, which lives as long as this object."""

    def __init__(self, embree: SimpleNamespace, positions: NDArray[np.float32], faces: NDArray[np.int32]) -> None:
        self._embree = embree
        device = _device()
        scene = embree.rtcNewScene(device)
        if not scene:
            raise MemoryError("embree could not make a scene")
        self._handle = scene
        weakref.finalize(self, embree.rtcReleaseScene, scene)
        embree.rtcSetSceneFlags(scene, _ROBUST)
        if len(faces):
            geometry = embree.rtcNewGeometry(device, _TRIANGLE)
            try:
                self._fill(geometry, _VERTEX, _FLOAT3, np.asarray(positions, np.float32))
                self._fill(geometry, _INDEX, _UINT3, np.asarray(faces, np.int32))
                embree.rtcCommitGeometry(geometry)
                embree.rtcAttachGeometry(scene, geometry)
            finally:
                embree.rtcReleaseGeometry(geometry)
        embree.rtcCommitScene(scene)
        if embree.rtcGetDeviceError(device):
            raise MemoryError(f"embree could not build its tree over {len(faces)} faces")

    def _fill(self, geometry: int, kind: int, form: int, rows: NDArray[Any]) -> None:
        """Copy (N, 3) rows into a buffer of embree's, which pads it as its loads need."""
        memory = self._embree.rtcSetNewGeometryBuffer(geometry, kind, 0, form, 12, len(rows))
        if not memory:
            raise MemoryError(f"embree has no room for {len(rows)} rows of a mesh")
        ctypes.memmove(memory, np.ascontiguousarray(rows).ctypes.data, 12 * len(rows))

    def occluded(
        self,
        origin: Floats,
        direction: Floats,
        centre: Floats,
        scale: float,
        found: NDArray[np.bool_],
        coherent: bool = False,
    ) -> None:
        _call_occluded(
            self._embree.occluded,
            self._handle,
            _arguments(coherent),
            _packet(),
            origin,
            direction,
            centre,
            scale,
            found,
        )

    def intersect(
        self,
        origin: Floats,
        direction: Floats,
        centre: Floats,
        scale: float,
        found: NDArray[np.int32],
        coherent: bool = False,
    ) -> None:
        _intersect(
            self._embree.intersect,
            self._handle,
            _arguments(coherent),
            _packet(),
            origin,
            direction,
            centre,
            scale,
            found,
        )


class ClassScene:
    """embreex's class: one ray after the other."""

    def __init__(self, positions: NDArray[np.float32], faces: NDArray[np.int32]) -> None:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene

        self._scene = EmbreeScene(robust=True)
        if len(faces):
            TriangleMesh(self._scene, positions, faces)
        self._empty = len(faces) == 0

    def occluded(
        self,
        origin: Floats,
        direction: Floats,
        centre: Floats,
        scale: float,
        found: NDArray[np.bool_],
        coherent: bool = False,
    ) -> None:
        found[:] = self._ask(origin, direction, centre, scale, "OCCLUDED") >= 0

    def intersect(
        self,
        origin: Floats,
        direction: Floats,
        centre: Floats,
        scale: float,
        found: NDArray[np.int32],
        coherent: bool = False,
    ) -> None:
        found[:] = self._ask(origin, direction, centre, scale, "INTERSECT")

    def _ask(self, origin: Floats, direction: Floats, centre: Floats, scale: float, query: str) -> NDArray[np.int32]:
        packet = np.empty((len(origin), 6), np.float32)
        usable = _move(origin, direction, centre, scale, packet)
        found = np.full(len(origin), -1, np.int32)
        if usable.any() and not self._empty:
            start, towards = (np.ascontiguousarray(packet[usable, part]) for part in (slice(0, 3), slice(3, 6)))
            found[usable] = self._scene.run(start, towards, query=query)
        return found


@lru_cache(maxsize=1)
def embree_functions() -> SimpleNamespace | None:
    """The functions of the embree that embreex has loaded, ready to be called; None where they cannot be found."""
    for library in _libraries():
        if all(hasattr(library, name) for name in _SIGNATURES):
            for name, (result, *arguments) in _SIGNATURES.items():
                getattr(library, name).restype, getattr(library, name).argtypes = result, arguments
            functions = {name: getattr(library, name) for name in _SIGNATURES}
            packets = {
                name: ctypes.cast(functions[symbol], ctypes.c_void_p).value
                for name, symbol in (("occluded", "rtcOccluded16"), ("intersect", "rtcIntersect16"))
            }
            if functions["rtcGetDeviceProperty"](functions["rtcNewDevice"](None), _MAJOR) == 4:
                return SimpleNamespace(**functions, **packets)
    return None


_POINTER, _COUNT, _NUMBER = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_uint

#: Result and arguments of the functions that are used.
_SIGNATURES: dict[str, tuple[Any, ...]] = {
    "rtcNewDevice": (_POINTER, ctypes.c_char_p),
    "rtcGetDeviceProperty": (ctypes.c_ssize_t, _POINTER, ctypes.c_int),
    "rtcGetDeviceError": (ctypes.c_int, _POINTER),
    "rtcNewScene": (_POINTER, _POINTER),
    "rtcSetSceneFlags": (None, _POINTER, ctypes.c_int),
    "rtcReleaseScene": (None, _POINTER),
    "rtcCommitScene": (None, _POINTER),
    "rtcNewGeometry": (_POINTER, _POINTER, ctypes.c_int),
    "rtcSetNewGeometryBuffer": (_POINTER, _POINTER, ctypes.c_int, _NUMBER, ctypes.c_int, _COUNT, _COUNT),
    "rtcCommitGeometry": (None, _POINTER),
    "rtcAttachGeometry": (_NUMBER, _POINTER, _POINTER),
    "rtcReleaseGeometry": (None, _POINTER),
    "rtcOccluded16": (None, _POINTER, _POINTER, _POINTER, _POINTER),
    "rtcIntersect16": (None, _POINTER, _POINTER, _POINTER, _POINTER),
}


def _libraries() -> Iterator[ctypes.CDLL]:
    """embreex's module, through which most systems find what it depends on; and libraries of that name in memory."""
    from embreex import rtcore

    yield ctypes.CDLL(rtcore.__file__)
    try:
        maps = {entry.path for entry in psutil.Process().memory_maps()}
    except (AttributeError, psutil.Error):  # macOS has no such list
        return
    yield from (ctypes.CDLL(path) for path in sorted(maps) if "embree4" in path.replace("\\", "/").split("/")[-1])


@lru_cache(maxsize=1)
def _device() -> int:
    """One device for the whole process; its threads only build trees."""
    functions = embree_functions()
    device = functions.rtcNewDevice(None) if functions else None
    if not device:
        raise MemoryError("embree could not be started")
    return int(device)


@lru_cache(maxsize=2)
def _arguments(coherent: bool) -> NDArray[np.uint64]:
    """The struct RTCOccludedArguments, of which RTCIntersectArguments has the same fields: flags, all features."""
    return np.array([(0xFFFFFFFF << 32) | (_COHERENT if coherent else 0), *[0] * 7], np.uint64)


def _packet() -> NDArray[np.float32]:
    """Room (FIELDS + 1, LANES) for a packet and, in its last row, for which of its rays there are, at 64 bytes."""
    memory = np.zeros((FIELDS + 2) * LANES, np.float32)
    first = (-memory.ctypes.data % 64) // 4
    return memory[first : first + (FIELDS + 1) * LANES].reshape(FIELDS + 1, LANES)


@intrinsic
def _call(
    typing: Context, function: Type, valid: Type, scene: Type, rays: Type, arguments: Type
) -> tuple[Signature, Callable[..., Value]]:
    """Call the C function at an address with four pointers."""
    from llvmlite import ir
    from numba.core import cgutils, types

    def generate(context: BaseContext, builder: IRBuilder, signature: Signature, values: Sequence[Value]) -> Value:
        pointer = cgutils.voidptr_t
        kind = ir.FunctionType(ir.VoidType(), [pointer] * 4)
        called = builder.inttoptr(values[0], kind.as_pointer())
        builder.call(called, [builder.inttoptr(value, pointer) for value in values[1:]])
        return context.get_dummy_value()

    return types.void(*[types.intp] * 5), generate


@scalar
def _put(
    packet: NDArray[np.float32], lane: int, origin: Floats, direction: Floats, centre: Floats, scale: float
) -> bool:
    """Write one ray into a packet as it is seen by embree; False where it is not one.

    `NUDGE` is taken from digits of the ray itself, so that it does not depend on the ray's place among others.
    """
    length = 0.0
    for axis in range(3):
        length += np.float64(direction[axis]) * np.float64(direction[axis])
    usable = length > 0.0 and length < np.inf
    shrink = 1.0 / np.sqrt(length) if usable else 0.0
    for axis in range(3):
        start = (np.float64(origin[axis]) - centre[axis]) * scale
        usable = usable and abs(start) < 1e30
        packet[axis, lane] = start
        towards = np.float64(direction[axis]) * shrink
        mixed = 1e5 * (0.7549 * towards + 0.5698 * np.float64(direction[(axis + 1) % 3]) * shrink + 0.3247 * start)
        packet[_DIRECTION + axis, lane] = towards + 2.0 * NUDGE * (mixed - np.floor(mixed) - 0.5)
    return usable


@scalar
def _begin(
    packet: NDArray[np.float32],
    words: NDArray[np.int32],
    first: int,
    origin: Floats,
    direction: Floats,
    centre: Floats,
    scale: float,
) -> int:
    """Fill a packet with the rays from `first` on; the number of its lanes."""
    lanes = min(LANES, len(origin) - first)
    for lane in range(lanes):
        usable = _put(packet, lane, origin[first + lane], direction[first + lane], centre, scale)
        words[FIELDS, lane] = -1 if usable else 0
        packet[_FAR, lane] = np.inf
    for lane in range(lanes, LANES):
        words[FIELDS, lane] = 0
    return lanes


@scalar
def _call_occluded(
    function: int,
    scene: int,
    arguments: NDArray[np.uint64],
    packet: NDArray[np.float32],
    origin: Floats,
    direction: Floats,
    centre: Floats,
    scale: float,
    found: NDArray[np.bool_],
) -> None:
    words = packet.view(np.int32)
    words[_MASK] = -1
    for first in range(0, len(origin), LANES):
        lanes = _begin(packet, words, first, origin, direction, centre, scale)
        _call(function, words[FIELDS].ctypes.data, scene, packet.ctypes.data, arguments.ctypes.data)
        for lane in range(lanes):
            found[first + lane] = words[FIELDS, lane] != 0 and packet[_FAR, lane] < 0.0


@scalar
def _intersect(
    function: int,
    scene: int,
    arguments: NDArray[np.uint64],
    packet: NDArray[np.float32],
    origin: Floats,
    direction: Floats,
    centre: Floats,
    scale: float,
    found: NDArray[np.int32],
) -> None:
    words = packet.view(np.int32)
    words[_MASK] = -1
    for first in range(0, len(origin), LANES):
        lanes = _begin(packet, words, first, origin, direction, centre, scale)
        words[_GEOMETRY] = -1
        words[_INSTANCE] = -1
        _call(function, words[FIELDS].ctypes.data, scene, packet.ctypes.data, arguments.ctypes.data)
        for lane in range(lanes):
            met = words[FIELDS, lane] != 0 and words[_GEOMETRY, lane] != -1
            found[first + lane] = words[_PRIMITIVE, lane] if met else -1


@scalar
def _move(
    origin: Floats, direction: Floats, centre: Floats, scale: float, rays: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """Write origins and directions (N, 6) as embree sees them; which of the rays can be cast (N,)."""
    packet = np.zeros((7, 1), np.float32)
    usable = np.zeros(len(origin), np.bool_)
    for index in range(len(origin)):
        usable[index] = _put(packet, 0, origin[index], direction[index], centre, scale)
        rays[index, :3] = packet[:3, 0]
        rays[index, 3:] = packet[_DIRECTION:, 0]
    return usable
