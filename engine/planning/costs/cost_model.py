"""Cost of a setting on this machine, predicted from some seconds of measuring before anything is baked.

Every cost is a product of counts that are known (`engine.planning.costs.load`) and of rates that
`engine.planning.costs.machine_profile` has measured at some values of a parameter; between and beyond its points a rate
is a power law. Bakes:

    visibility per vertex that is not open + rows of transport per vertex + the file + what does not grow with the mesh

Gaussians take a table and a fit for each vertex instead of rows, and again for light from the model itself. A turned
light is its map, by its texels, and then the bytes of the rows. A frame is a base, a share for each vertex, for each
pixel and for each pixel that shows the model, where shares grow with lights, terms, lobes or squared order. A path of
the reference costs what its rays cost on the mesh and what is shaded at each point; it meets another point as often
as hemispheres are closed.
"""

from __future__ import annotations

import json
import math
import os
import platform
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import engine
from engine.core.errors import FileError
from engine.planning.costs.load import Load as Load
from engine.planning.costs.load import Rates as Rates
from engine.planning.costs.setting import Setting, shows_of_sharp
from engine.planning.costs.sizes import DIFFUSE_ORDER as DIFFUSE_ORDER
from engine.render.reference import BYTES_PER_PIXEL
from engine.scene.mode import is_traced
from engine.storage.atomic import make_folder, write_json
from engine.storage.untrusted import read_bytes
from engine.transport import method as transport
from engine.transport.sh.bake import default_edge
from engine.transport.wavelet.haar import FACES

#: Changes when the rates of a kept model no longer mean what they did.
FORMAT = 8

#: Bytes of a kept model at most.
FILE_LIMIT_BYTES = 1 << 16

#: Seconds that a profile holds: drivers, governors and other programs change. Share of the CPUs that other programs may
#: have had while every part was measured.
HOLDS_S, BUSY = 30 * 86_400.0, 0.2

#: Factor within which times of an idle machine are of predicted ones: where every part was measured, as 110 of 117
#: bakes and frames were, and where rates of another machine were scaled.
WITHIN, SCALED_WITHIN = 1.5, 2.0

#: A bake, or a frame, that teaches takes at least so many seconds; the last so many count; no correction is more than
#: this.
TEACHES_S, FRAME_TEACHES_S, REMEMBERED, MAX_CORRECTED = 0.5, 2e-3, 8, 4.0

#: Parameters and seconds of a rate are below this, parameters above its inverse, and nothing grows faster than the
#: products of three spherical harmonics do.
LARGEST, STEEPEST = 1e9, 8.0

#: Renderer of a machine without OpenGL.
ON_CPU = "processor"

#: Kinds of frames, and the parts of each: what it takes at least, for each vertex and each pixel that shows the model,
#: and what both take more for each light, term, lobe, or coefficient of spherical harmonics.
FRAMES = ("direct", *(kind for method in transport.METHODS for kind in method.frames))
PARTS = ("base", "vertex", "vertex-each", "pixel", "pixel-each")

#: Name of each table of a model; a kept model that lacks one is measured anew.
NAMES = (
    "receivers",
    "visibility",
    "ray",
    "sh-products",
    "sh-basis",
    "sh-seen",
    "sh-matrix",
    "sh-vector",
    "bounce-rays",
    "bounce-matrix",
    "bounce-vector",
    "file-byte",
    "wavelet-fixed",
    "wavelet-row",
    "wavelet-coefficients",
    "light-sh",
    "light-sh-texel",
    "light-wavelet",
    "light-wavelet-texel",
    "relight-sh",
    "relight-wavelet",
    "gaussian-table",
    "gaussian-fit",
    "gaussian-indirect",
    "gaussian-indirect-fit",
    "reference-picture",
    "reference-miss",
    "reference-shading",
    "reference-rays",
    "reference-point",
    "frame-pixel",
    *(f"{mode}-{part}" for mode in FRAMES for part in PARTS),
)


#: The mean logarithm of measured over predicted seconds of each mode, and how many were measured.
Seen = Mapping[str, tuple[float, int]]


@dataclass(frozen=True)
class Cost:
    """Cost of a setting: seconds of bake, of a rotated environment and of a frame.

    A bake begins when the BRDF is tabulated or factored. `memory_bytes` are held by the process while it is
    drawn, mesh and light in its rows included; `size_bytes` are the transport file's. `another_s` is a bake of another
    BRDF on the same model, whose visibility is kept; None where that takes no bake.
    """

    bake_s: float
    relight_s: float
    frame_s: float
    memory_bytes: int
    size_bytes: int
    another_s: float | None = None


@dataclass(frozen=True)
class CostModel:
    """The rates of one machine; `tables` by the names of `NAMES`.

    `renderer` is the name of the graphics device that frames are for, "processor" where there is none.
    `calibrated` is whether each rate was measured here; else those of another machine were scaled (`quick_profile`).
    `measured_at_s` is when that was, in seconds of POSIX. `bakes` has, for each method that was baked since, the mean
    logarithm of the seconds of its last bakes over those that the rates predict, and their number; `frames` has the
    same for the frames of each mode.
    """

    machine: str
    renderer: str
    tables: Mapping[str, Rates] = field(hash=False)
    calibrated: bool = True
    measured_at_s: float = 0.0
    bakes: Seen = field(default_factory=lambda: MappingProxyType({}), hash=False)
    frames: Seen = field(default_factory=lambda: MappingProxyType({}), hash=False)

    def __post_init__(self) -> None:
        for mode, (mean, count) in (*self.bakes.items(), *self.frames.items()):
            if not (abs(mean) <= math.log(MAX_CORRECTED) and 1 <= count <= REMEMBERED):
                raise ValueError(f"{mode} cannot have taken e^{mean} of the predicted time {count} times")
        missing = [name for name in NAMES if not self.tables.get(name)]
        if missing:
            raise ValueError(f"the rates of {missing[0]} are missing")
        for name, rates in self.tables.items():
            parameters = [parameter for parameter, _ in rates]
            fine = all(1.0 / LARGEST < parameter < LARGEST and 0.0 <= rate < LARGEST for parameter, rate in rates)
            if not fine or parameters != sorted(set(parameters)):
                raise ValueError(f"the rates of {name} are not rising parameters with finite seconds")
        object.__setattr__(self, "tables", MappingProxyType(dict(self.tables)))
        object.__setattr__(self, "bakes", MappingProxyType(dict(self.bakes)))
        object.__setattr__(self, "frames", MappingProxyType(dict(self.frames)))

    @property
    def within(self) -> float:
        """The factor that times are within of predicted ones in some 95 of 100 cases."""
        return WITHIN if self.calibrated else SCALED_WITHIN

    def is_expired(self, now_s: float) -> bool:
        """True where it is too old."""
        return not 0.0 <= now_s - self.measured_at_s <= HOLDS_S

    def learn(self, method: str, predicted_s: float, bake_s: float) -> CostModel:
        """The model that has seen a bake of `method` take `bake_s` where it predicted `predicted_s`."""
        if min(predicted_s, bake_s) < TEACHES_S:
            return self
        return replace(self, bakes=_with(self.bakes, method, bake_s / predicted_s))

    def learn_frame(self, mode: str, predicted_s: float, frame_s: float) -> CostModel:
        """The model that has seen a frame of `mode` take `frame_s` where it predicted `predicted_s`."""
        if min(predicted_s, frame_s) < FRAME_TEACHES_S:
            return self
        return replace(self, frames=_with(self.frames, mode, frame_s / predicted_s))

    def rate(self, name: str, parameter: float = 1.0) -> float:
        """Seconds at a parameter: a power law between the two measured points, and beyond the ends as at the ends."""
        return rate_at(self.tables[name], parameter)

    def predict(self, setting: Setting, vertices: int, pixels: int, *, load: Load | None = None, **more: Any) -> Cost:
        """Cost of `setting` for so many vertices and pixels; `load`, or `more` of its fields, give the rest."""
        load = load or Load(vertices, pixels, **more)
        found: Cost
        if setting.mode in transport.names():
            found = transport.method_of(setting.mode).planning.cost(self, setting, load)
            if load.texel_lights:  # with texels and without, beside the bake (`engine.render.shadowed`)
                found = replace(found, frame_s=found.frame_s + 2.0 * self.frame_s("direct", load.texel_lights, load))
        else:
            found = self._reference(setting, load) if is_traced(setting.mode) else self._direct(setting, load)
        bake, frame = (math.exp(seen.get(setting.mode, (0.0, 0))[0]) for seen in (self.bakes, self.frames))
        another_s = None if found.another_s is None else found.another_s * bake
        return replace(found, bake_s=found.bake_s * bake, frame_s=found.frame_s * frame, another_s=another_s)

    def frame_s(self, mode: str, each: float, load: Load) -> float:
        """Seconds of a frame of one of `FRAMES`, with so many terms, lobes or coefficients."""
        base, vertex, vertex_each, pixel, pixel_each = (self.rate(f"{mode}-{part}") for part in PARTS)
        shown = load.fragments * (pixel + each * pixel_each)
        return base + load.vertices * (vertex + each * vertex_each) + shown + self.rate("frame-pixel") * load.pixels

    def rays_s(self, edge: int, load: Load) -> float:
        """Seconds of visibility over a cube map of all vertices, and of preparing them."""
        return self.visibility_s(edge, load) + load.vertices * self.rate("receivers")

    def visibility_s(self, edge: int, load: Load) -> float:
        """Seconds of visibility over a cube map of all vertices, once they are prepared."""
        return load.vertices * self.rate("visibility", edge) * load.map_scale * load.occluded

    def _reference(self, setting: Setting, load: Load) -> Cost:
        """Paths that miss, paths that meet the model, and the points that these meet afterwards."""
        scale = load.ray_scale
        first = self.rate("reference-shading") + self.rate("reference-rays") * scale
        further = sum(load.closed**point for point in range(1, load.depth))
        path_s = self.rate("reference-miss") + load.covered * (first + further * self.rate("reference-point"))
        frame_s = self.rate("reference-picture") + setting["samples"] * load.pixels * path_s
        return Cost(0.0, 0.0, frame_s, load.mesh_bytes + BYTES_PER_PIXEL * load.pixels, 0)

    def _direct(self, setting: Setting, load: Load) -> Cost:
        """Lights that are summed; sharp ones beside them take a ray for each pixel, or a depth map in OpenGL."""
        lights = setting["directions"] + (load.shadows if shows_of_sharp(setting.mode, "self-shadowing") else 0)
        frame_s, relight_s = self.frame_s("direct", lights, load), 0.0
        shadows = lights - setting["directions"]
        if self.renderer == ON_CPU:
            frame_s += load.fragments * shadows * self.rate("ray") * load.ray_scale
        elif shadows:
            relight_s = shadows * (self.rate("direct-base") + load.vertices * self.rate("direct-vertex"))
        return Cost(0.0, relight_s, frame_s, load.mesh_bytes + 48 * lights, 0)

    def vector_s(self, order: int) -> float:
        """Seconds of the vector of a vertex that is diffuse, its visibility being known."""
        return FACES * default_edge(order) ** 2 * self.rate("sh-vector", order)

    def bounce_s(self, kind: str, order: int, load: Load) -> float:
        """Seconds of a bounce at a vertex: its rays, and what is gathered from those that meet something."""
        return self.rate("bounce-rays") * load.ray_scale + self.rate(f"bounce-{kind}", order)

    def measure_turning_s(self, name: str, parameter: float, load: Load) -> float:
        """Seconds that a map takes until rows can be made of it."""
        return self.rate(name, parameter) + self.rate(f"{name}-texel", parameter) * load.texels


def _with(seen: Seen, mode: str, ratio: float) -> Seen:
    """`seen` with one more measured time, `ratio` times the one that was predicted with what had been seen."""
    before, count = seen.get(mode, (0.0, 0))
    now = before + math.log(ratio)  # over what the rates alone predict
    count, most = min(count + 1, REMEMBERED), math.log(MAX_CORRECTED)
    return {**seen, mode: (min(max(before + (now - before) / count, -most), most), count)}


def rate_at(rates: Rates, parameter: float) -> float:
    """Rate of a table at `parameter`, as `CostModel.rate` returns it."""
    if len(rates) == 1:
        return rates[0][1]
    high = min(max(bisect_left([at for at, _ in rates], parameter), 1), len(rates) - 1)
    (x0, y0), (x1, y1) = rates[high - 1], rates[high]
    if min(x0, y0, y1) <= 0.0:
        return max(0.0, y0 + (y1 - y0) * (parameter - x0) / (x1 - x0))
    power = math.log(y1 / y0) / math.log(x1 / x0)
    return y0 * (parameter / x0) ** min(max(power, -STEEPEST), STEEPEST)


def basis_values(edge: int, order: int) -> float:
    """Values of the basis that integrals of spherical harmonics of `order` over the texels of a cube map take."""
    nodes = max(2, math.ceil(3 * order / edge) + 1)
    return float(FACES * (edge * nodes * order) ** 2)


def machine_name() -> str:
    """Identity of the machine that the rates hold for, with the versions of Python and of Lightarc."""
    words = (platform.node(), platform.machine(), platform.system(), str(os.cpu_count()))
    return " ".join((*words, platform.python_version(), engine.__version__, f"format {FORMAT}"))


def save(model: CostModel, path: Path) -> None:
    """Keep a model in the file `path`; OutputError where that cannot be."""
    make_folder(path.parent)
    record = {name: getattr(model, name) for name in ("machine", "renderer", "calibrated", "measured_at_s")}
    write_json(path, {**record, "bakes": dict(model.bakes), "frames": dict(model.frames), "tables": dict(model.tables)})


def load_model(path: Path) -> CostModel | None:
    """The model that was kept for this machine; None where there is none, or it is damaged or another machine's."""
    try:
        record = json.loads(read_bytes(path, FILE_LIMIT_BYTES))
        tables = {
            str(name): tuple((float(parameter), float(rate)) for parameter, rate in rates)
            for name, rates in record["tables"].items()
        }
        seen = (
            {str(mode): (float(mean), int(count)) for mode, (mean, count) in record[kind].items()}
            for kind in ("bakes", "frames")
        )
        calibrated, at_s = bool(record["calibrated"]), float(record["measured_at_s"])
        model = CostModel(str(record["machine"]), str(record["renderer"]), tables, calibrated, at_s, *seen)
    except (FileError, ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError):
        return None
    return model if model.machine == machine_name() else None
