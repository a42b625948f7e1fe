"""What a setting costs on this machine: predicted from half a minute of measuring, before anything is baked.

Every cost is a product of counts that are known (vertices, rays, coefficients, pixels) and of rates that
`engine.effects.calibration` has measured over the range of a knob; between its points a rate is a power law. Bakes:

    visibility(edge) per vertex that is not open, + rows of transport per vertex, + tables that are made once

Gaussians take a fit for each vertex instead of rows. Relighting is bound by the bytes that it reads, and a frame is a
base, a share for each vertex and one for each pixel.
Rays cost what they cost on the mesh: `Load.ray_scale` tells by how much it differs from the mesh of the calibration.
"""

from __future__ import annotations

import math
import platform
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import engine
from engine.effects.setting import Setting
from engine.errors import FileError
from engine.files.atomic import make_folder, write_json
from engine.files.untrusted import read_bytes
from engine.transport.sh_bake import default_edge
from engine.transport.view_directions import VIEWS

#: A table of rates: value of a knob → seconds, in rising order.
Rates = tuple[tuple[float, float], ...]

#: Changes when the rates of a kept model no longer mean what they did.
FORMAT = 2

#: Bytes of a kept model at most.
FILE_LIMIT_BYTES = 1 << 16

#: Bytes of a Gaussian for one view: three heights, its mean and its width, in float32; and where it is drawn from.
LOBE_BYTES, DRAWN_BYTES = 28, 12

#: Order of the matt part beside Gaussians, and how many times as long a bake with light from the model itself takes.
MATT_ORDER, INDIRECT = 8, 3.0

#: How many times as long a path takes that may touch more of the surface: most leave the model before the fourth point.
BOUNCED = 2.0

#: What each table of a model is called; a kept model that lacks one is measured anew.
NAMES = (
    "receivers",
    "visibility",
    "sh-fixed",
    "sh-matrix",
    "sh-vector",
    "bounce-matrix",
    "bounce-vector",
    "wavelet-fixed",
    "wavelet-row",
    "wavelet-coefficients",
    "light-sh",
    "light-wavelet",
    "light-gaussian",
    "relight-sh",
    "relight-wavelet",
    "gaussian-fit",
    "reference",
    *(
        f"{mode}-{part}"
        for mode in ("direct", "sh", "sh-flat", "wavelet", "gaussian")
        for part in ("base", "vertex", "pixel")
    ),
)


@dataclass(frozen=True)
class Cost:
    """What a setting takes: seconds of bake, of a changed light and of a frame.

    A changed light is a map of 1024 × 512 texels that becomes rows which can be drawn; smaller ones take less.

    `memory_bytes` are held while it is drawn, `size_bytes` are the transport file's.
    """

    bake_s: float
    relight_s: float
    frame_s: float
    memory_bytes: int
    size_bytes: int


@dataclass(frozen=True)
class Load:
    """What a setting is used on.

    Attributes
    ----------
    vertices, pixels : of the model and of the picture. faces : of the model, twice the vertices where not given.
    occluded : share of the vertices that do not see their whole hemisphere.
    diffuse, isotropic : of the reflectance. coloured : whether what it reflects on has a colour.
    ray_scale : cost of a ray on this mesh over that of the calibration.
    lamps : directions of suns and lamps, which cost a ray for each vertex when the light changes.
    bounced : whether paths of the reference go on from part to part of the model.
    """

    vertices: int
    pixels: int
    faces: int = 0
    occluded: float = 1.0
    diffuse: bool = False
    isotropic: bool = True
    coloured: bool = True
    ray_scale: float = 1.0
    lamps: int = 0
    bounced: bool = False

    def __post_init__(self) -> None:
        if min(self.vertices, self.pixels) < 1 or not 0.0 <= self.occluded <= 1.0:
            raise ValueError(
                f"{self.vertices} vertices, {self.pixels} pixels and {self.occluded} occluded make no load"
            )

    @property
    def mesh_bytes(self) -> int:
        """Positions in float64, normals, texture coordinates, and corners of the triangles."""
        return self.vertices * (24 + 12 + 8) + 12 * (self.faces or 2 * self.vertices)


@dataclass(frozen=True)
class CostModel:
    """The rates of one machine; `tables` by the names of `NAMES`.

    `renderer` is the name of the graphics device that frames are for, "processor" where there is none.
    """

    machine: str
    renderer: str
    tables: Mapping[str, Rates] = field(hash=False)

    def __post_init__(self) -> None:
        missing = [name for name in NAMES if not self.tables.get(name)]
        if missing:
            raise ValueError(f"the rates of {missing[0]} are missing")
        for name, rates in self.tables.items():
            knobs = [knob for knob, _ in rates]
            fine = all(math.isfinite(x) and x >= 0.0 for pair in rates for x in pair)
            if not fine or knobs != sorted(set(knobs)):
                raise ValueError(f"the rates of {name} are not rising knobs with finite seconds")
        object.__setattr__(self, "tables", MappingProxyType(dict(self.tables)))

    def rate(self, name: str, knob: float) -> float:
        """Seconds at a knob: a power law between the two measured points, and beyond the ends as at the ends."""
        rates = self.tables[name]
        if len(rates) == 1:
            return rates[0][1]
        high = min(max(bisect_left([at for at, _ in rates], knob), 1), len(rates) - 1)
        (x0, y0), (x1, y1) = rates[high - 1], rates[high]
        if min(x0, y0, y1) <= 0.0:
            return max(0.0, y0 + (y1 - y0) * (knob - x0) / (x1 - x0))
        return y0 * (knob / x0) ** (math.log(y1 / y0) / math.log(x1 / x0))

    def predict(self, setting: Setting, vertices: int, pixels: int, *, load: Load | None = None, **more: Any) -> Cost:
        """What `setting` costs on so many vertices and pixels; `load`, or `more` of its fields, tell the rest."""
        load = load or Load(vertices, pixels, **more)
        predictions = {
            "reference": self._reference,
            "direct": self._direct,
            "shading-map": self._direct,
            "sh": self._harmonics,
            "wavelet": self._wavelets,
            "gaussian": self._gaussians,
        }
        if setting.mode not in predictions:
            raise ValueError(f"nothing is known of the cost of {setting.mode}")
        return predictions[setting.mode](setting, load)

    def _frame(self, mode: str, knob: float, load: Load) -> float:
        base, vertex, pixel = (self.rate(f"{mode}-{part}", knob) for part in ("base", "vertex", "pixel"))
        return base + vertex * load.vertices + pixel * load.pixels

    def _rays(self, edge: int, load: Load) -> float:
        """Seconds of visibility over a cube map of all vertices, and of preparing them."""
        seen = self.rate("visibility", edge) * load.occluded * load.ray_scale
        return load.vertices * (seen + self.rate("receivers", 1))

    def _reference(self, setting: Setting, load: Load) -> Cost:
        touched = (BOUNCED if load.bounced else 1.0) * (load.ray_scale or 1.0)  # 0: no vertex of it needs any ray
        frame_s = setting["samples"] * load.pixels * self.rate("reference", 1) * touched
        return Cost(0.0, 0.0, frame_s, load.mesh_bytes + 240 * load.pixels, 0)

    def _direct(self, setting: Setting, load: Load) -> Cost:
        directions = setting["directions"]
        return Cost(0.0, 0.0, self._frame("direct", directions, load), load.mesh_bytes + 24 * directions, 0)

    def _harmonics(self, setting: Setting, load: Load) -> Cost:
        order, bounces = setting["order"], 3 if setting["interreflection"] else 0
        rows = 1 if load.diffuse else order**2
        kind = "vector" if load.diffuse else "matrix"
        bake_s = self.rate("sh-fixed", order) * (0.05 if load.diffuse else 1.0)
        bake_s += self._rays(default_edge(order), load) + load.vertices * self.rate(f"sh-{kind}", order)
        if bounces:
            last = self.rate(f"bounce-{kind}", order)
            each = self.rate("bounce-vector", order)
            bake_s += load.vertices * load.ray_scale * (last + (bounces - 1) * each)
        values = load.vertices * rows * order**2 * (3 if bounces and load.coloured else 1)
        relight_s = self.rate("light-sh", order) + self.rate("relight-sh", 1) * values
        size = 4 * values + load.mesh_bytes
        frame_s = self._frame("sh-flat" if load.diffuse else "sh", order, load)
        return Cost(bake_s, relight_s, frame_s, size + 12 * load.vertices * rows, size)

    def _wavelets(self, setting: Setting, load: Load) -> Cost:
        terms, kept, edge = setting["terms"], setting["coefficients"], setting["cube"]
        kept = min(kept, 6 * edge * edge)
        rows = load.vertices * terms
        cutting = self.rate("wavelet-coefficients", kept) / self.rate("wavelet-coefficients", 96)
        bake_s = self.rate("wavelet-fixed", edge) + self._rays(edge, load)
        bake_s += rows * self.rate("wavelet-row", edge) * cutting
        relight_s = self.rate("light-wavelet", edge) + self.rate("relight-wavelet", kept) * rows
        relight_s += load.lamps * load.vertices * self.rate("receivers", 1)
        size = rows * (6 * kept + 14) + load.mesh_bytes
        return Cost(bake_s, relight_s, self._frame("wavelet", terms, load), size + 12 * rows, size)

    def _gaussians(self, setting: Setting, load: Load) -> Cost:
        """Lobes of all views of a vertex, and vectors of the matt part."""
        lobes, bounces = setting["lobes"], bool(setting["interreflection"])
        fitted_s = self.rate("gaussian-fit", lobes) * (INDIRECT if bounces else 1.0)
        bake_s = load.vertices * (fitted_s + self.rate("sh-vector", MATT_ORDER))
        bake_s += self._rays(default_edge(MATT_ORDER), load)
        matt = load.vertices * MATT_ORDER**2 * (3 if bounces else 1)
        relight_s = self.rate("light-gaussian", 1) + self.rate("light-sh", MATT_ORDER)
        relight_s += self.rate("relight-sh", 1) * matt
        drawn = lobes * (2 if bounces else 1)
        count = load.vertices * VIEWS * drawn
        size = count * LOBE_BYTES + 4 * matt + load.mesh_bytes
        frame_s = self._frame("gaussian", drawn, load)
        return Cost(bake_s, relight_s, frame_s, size + count * DRAWN_BYTES + 12 * load.vertices, size)


def machine_name() -> str:
    """What the rates hold for: this machine, this version of Python and of Lightarc."""
    import os

    words = (platform.node(), platform.machine(), platform.system(), str(os.cpu_count()))
    return " ".join((*words, platform.python_version(), engine.__version__, f"format {FORMAT}"))


def save(model: CostModel, path: Path) -> None:
    """Keep a model in the file `path`; OutputError where that cannot be."""
    make_folder(path.parent)
    write_json(path, {"machine": model.machine, "renderer": model.renderer, "tables": dict(model.tables)})


def load_model(path: Path) -> CostModel | None:
    """The model that was kept for this machine; None where there is none, or it is damaged or another machine's."""
    import json

    try:
        record = json.loads(read_bytes(path, FILE_LIMIT_BYTES))
        tables = {
            str(name): tuple((float(knob), float(rate)) for knob, rate in rates)
            for name, rates in record["tables"].items()
        }
        model = CostModel(str(record["machine"]), str(record["renderer"]), tables)
    except (FileError, ValueError, TypeError, KeyError, AttributeError, RecursionError, OverflowError):
        return None
    return model if model.machine == machine_name() else None
