"""Bundles as the window opens them: the material, and the view that it was exported with.

Model and environment are kept by reference: the name of a built-in one, or a file as seen from the bundle, with its
size and its hash. A file is opened only where it is the one that was exported, so that a bundle of somebody else
leads to no other.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import isfinite, nan
from pathlib import Path
from typing import Any, get_args

from app.commands.making import prepare_to_draw
from app.commands.opening import load_environment, load_shape
from app.document.document import Comparing, Look, Project
from app.document.modes import modes
from app.document.scene import DEFAULT_MODEL
from app.project.made import hash_of
from engine.bundle.manifest import MAPS_PROCESS, describe_bundle
from engine.core.colour import Operator
from engine.core.errors import FileError, UsageError
from engine.core.params import parameters
from engine.core.steps import Step, Steps, part
from engine.geometry import usd
from engine.geometry.brushing import Brushing, parse_brushing
from engine.geometry.camera import Camera
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import FLAT, SHAPES, flat_image, shape
from engine.light.lamps import LampSettings
from engine.light.near_lamps import NearLampSettings
from engine.light.sky import SKIES
from engine.scene.material import Material
from engine.scene.scene import Lookup, Source
from engine.shading.lookup import Above
from engine.shading.power_law import Scale
from engine.storage.readers import radiance_suffixes, suffixes

#: Under which name the provenance of a bundle says how k_s was chosen.
SCALE_NOTE = "power_law_scale"

#: Numbers of `Look`, flags, whole numbers with their ranges, and choices.
NUMBERS = (
    *("light_theta_deg", "light_phi_deg", "irradiance", "rotation_deg", "gain"),
    *("repeats", "exposure_ev", "ground_albedo"),
)
FLAGS = ("has_ground", "only_lamps")
WHOLE = {"directions": range(1, 4097), "bounces": range(65)}
CHOICES = {
    "tone_map": get_args(Operator),
    "source": get_args(Source),
    "lookup": get_args(Lookup),
    "above": get_args(Above),
    "comparing": get_args(Comparing),
}
MODES = ("mode", "against")

#: Lamps of a look, and their settings.
LAMPS: dict[str, type[Any]] = {"lamps": LampSettings, "near_lamps": NearLampSettings}

#: Lamps that are read, and bytes of a file that a reference leads to.
MAX_LAMPS, MAX_BYTES = 64, 2**32

#: Endings of models that may bring a material.
MODELS_WITH_MATERIALS = (".glb", ".gltf", ".obj", ".ply", *usd.SUFFIXES)


@dataclass(frozen=True, eq=False)
class Referred:
    """Parts of a project that a view refers to (`mesh`, `environment`, `camera`, `came_from`), and sentences about
    those that are not there."""

    parts: Mapping[str, Any] = field(default_factory=dict)
    missing: tuple[str, ...] = ()


def view_of(project: Project, bundle: Path) -> dict[str, Any]:
    """The view of `project` as the provenance of `bundle` keeps it. Files of models and lights are hashed."""
    look, camera, files = project.look, project.camera, project.came_from
    said: dict[str, Any] = {name: getattr(look, name) for name in (*NUMBERS, *FLAGS, *WHOLE, *CHOICES, *MODES)}
    for kind in LAMPS:
        said[kind] = [{**dataclasses.asdict(lamp), "colour": list(lamp.colour)} for lamp in getattr(look, kind)]
    said["camera"] = None if camera is None else {name: _as_list(each) for name, each in vars(camera).items()}
    name = DEFAULT_MODEL if project.mesh is None else project.mesh.name
    said["model"] = _reference(name, files.get(name), bundle)
    if project.mesh is not None and project.mesh.health.figures.get("flipped"):
        said["model"]["flipped"] = True
    if project.mesh is not None and project.mesh.brushing != Brushing():
        said["model"]["brushing"] = str(project.mesh.brushing)
    light = project.environment
    said["environment"] = None if light is None else _reference(light.name, files.get(light.name), bundle)
    return said


def _as_list(value: object) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _reference(name: str, file: Path | None, bundle: Path) -> dict[str, Any]:
    """A name, and where it is one of a file that can be read, the file as seen from the folder of the bundle."""
    if file is None:
        return {"name": name}
    try:
        size, content = file.stat().st_size, hash_of(file)
    except OSError:
        return {"name": name}
    try:
        place = Path(os.path.relpath(file, bundle.absolute().parent)).as_posix()
    except ValueError:  # another drive
        place = file.as_posix()
    return {"name": name, "file": place, "bytes": size, "hash": content}


def with_view(look: Look, provenance: Mapping[str, Any]) -> Look:
    """`look` with the view that a bundle was exported with; values that none can have leave it as it is."""
    view = provenance.get("view")
    if not isinstance(view, Mapping):
        return look
    found: dict[str, Any] = {name: view[name] for name in NUMBERS if isinstance(view.get(name), float)}
    found |= {name: view[name] for name in FLAGS if isinstance(view.get(name), bool)}
    found |= {name: view[name] for name, known in WHOLE.items() if type(view.get(name)) is int and view[name] in known}
    choices = {**CHOICES, **dict.fromkeys(MODES, tuple(mode.value for mode in modes()))}
    found |= {name: view[name] for name, known in choices.items() if view.get(name) in known}
    try:
        for kind, settings in LAMPS.items():
            if isinstance(view.get(kind), list):
                found[kind] = tuple(_lamp(said, settings) for said in view[kind][:MAX_LAMPS])
        return dataclasses.replace(look, **found)
    except (UsageError, KeyError, TypeError, ValueError):
        return look


def _lamp(said: Mapping[str, Any], settings: type[Any]) -> Any:
    """The settings of a lamp; what bundles of earlier versions do not say has its default."""
    red, green, blue = (float(channel) for channel in said["colour"])
    others = {
        each.name: said[each.name] if each.kind == "choice" else float(said[each.name])
        for each in parameters(settings)
        if each.name != "colour" and each.name in said
    }
    return settings(**others, colour=(red, green, blue))


def find_referred(provenance: Mapping[str, Any], bundle: Path, size: tuple[int, int]) -> Steps[Referred]:
    """Model, camera and environment of the view that `bundle` was exported with; none where it says none.

    `size` are rows and columns of its material, which a flat image has the proportions of.
    """
    yield Step(0.0, "looking for the model and the light")
    view = provenance.get("view")
    if not isinstance(view, Mapping):
        return Referred()
    parts: dict[str, Any] = {}
    missing, files = list[str](), dict[str, Path]()
    name, source = _source(view.get("model"), bundle, (*SHAPES, FLAT), suffixes("mesh"))
    if name and source:
        try:
            is_own = name == DEFAULT_MODEL and source == name
            if source == FLAT:
                mesh: Mesh | None = flat_image(size[1], size[0])
            else:
                mesh = None if is_own else (yield from part(load_shape(source), 0.0, 0.7))
            if mesh is not None and view["model"].get("flipped") is True:
                mesh = mesh.flipped()
            if (brushing := _brushing(view["model"].get("brushing"))) is not None:
                mesh = (mesh or shape(DEFAULT_MODEL)).brush(brushing)
            parts |= {"mesh": mesh, "camera": _camera(view.get("camera"))}
            files |= {mesh.name: Path(source)} if mesh is not None and source not in (*SHAPES, FLAT) else {}
        except FileError as error:
            missing.append(str(error))
    elif name:
        missing.append(f"The model {name} is not where it was; the material is shown on another")
    name, source = _source(view.get("environment"), bundle, (*SKIES,), radiance_suffixes())
    if "environment" in view and not name:
        parts["environment"] = None
    elif name and source:
        try:
            parts["environment"] = yield from part(load_environment(source), 0.7, 1.0)
            files |= {parts["environment"].name: Path(source)} if source not in SKIES else {}
        except FileError as error:
            missing.append(str(error))
    elif name:
        missing.append(f"The light {name} is not where it was")
    parts["came_from"] = files
    return Referred(parts, tuple(missing))


def _brushing(said: object) -> Brushing | None:
    """The direction of brushing that a view says; None where it says none that there can be."""
    try:
        return parse_brushing(said) if isinstance(said, str) else None
    except UsageError:
        return None


def _source(said: object, bundle: Path, built_in: tuple[str, ...], endings: tuple[str, ...]) -> tuple[str, str]:
    """The name of a reference, and a built-in of that name or the path of its file; each empty where there is none."""
    if not isinstance(said, Mapping) or not isinstance(said.get("name"), str):
        return "", ""
    name = said["name"][:120]
    if "file" not in said:
        return name, name if name in built_in else ""
    is_it = (
        path for path in _places(said["file"], bundle, endings) if _is_file(path, said.get("bytes"), said.get("hash"))
    )
    return name, str(next(is_it, ""))


def _places(said: object, bundle: Path, endings: tuple[str, ...]) -> Iterator[Path]:
    """Places where a file may lie: as seen from the bundle, and beside it. Network names are left alone."""
    if not isinstance(said, str) or "\0" in said or said.startswith(("//", "\\")):
        return
    folder = bundle.absolute().parent
    for path in (Path(os.path.normpath(folder / said)), folder / Path(said).name):
        if path.suffix.lower() in endings:
            yield path


def _is_file(path: Path, size: object, content: object) -> bool:
    """True for a regular file of this size and hash; of another size it is not even read."""
    try:
        is_it = path.is_file() and path.stat().st_size == size and path.stat().st_size <= MAX_BYTES
        return is_it and hash_of(path) == content
    except (OSError, ValueError):
        return False


def _camera(said: object) -> Camera | None:
    """The camera of a view; None where it framed the model, or cannot be."""
    if not isinstance(said, Mapping):
        return None
    try:
        eye, target, up = (tuple(map(float, said[name])) for name in ("eye", "target", "up"))
        found = Camera(eye, target, up, float(said["fov_deg"]))  # type: ignore[arg-type]
    except (UsageError, KeyError, TypeError, ValueError, OverflowError):
        return None
    return found if isfinite(found.fov_deg) else None


@dataclass(frozen=True, eq=False)
class OpenedBundle:
    """A bundle: its name as a file, its material, where that came from, and what its view refers to."""

    name: str
    material: Material
    provenance: dict[str, Any]
    referred: Referred


def load_bundle(path: Path) -> Steps[OpenedBundle]:
    """Read a bundle, and what the view that it was exported with refers to."""
    yield Step(0.0, "opening the bundle")
    from engine.bundle.bundle import open_bundle

    material, provenance = prepare_to_draw(open_bundle(path)), describe_bundle(path, MAPS_PROCESS)["provenance"]
    found = yield from part(find_referred(provenance, path, material.size if material.has_map else (1, 1)), 0.5, 1.0)
    return OpenedBundle(path.name.removesuffix(".lightarc"), material, provenance, found)


def load_pbr_maps(path: Path, *others: Path) -> Steps[OpenedBundle]:
    """The PBR maps of another program at `path`, or in several images, as a material without a view of its own."""
    yield Step(0.0, "opening the material")
    from engine.exchange.readers.read import read_material, read_textures

    reading = read_textures((path, *others)) if others else read_material(path, parts=True)
    material = yield from part(reading, 0.0, 1.0)
    return OpenedBundle(material.name, material, {"source": path.name}, Referred())


def load_model_material(path: Path) -> Steps[OpenedBundle | None]:
    """The materials of the parts of a model, each once over its texture coordinates; None where it brings none."""
    yield Step(0.0, "looking for materials")
    from engine.exchange.readers.read import find_doubt_of_parts

    if find_doubt_of_parts(path) is not None:
        return None
    opened = yield from load_pbr_maps(path)
    own = {**opened.provenance, "view": {"repeats": 1.0}}
    return dataclasses.replace(opened, name=path.stem, provenance=own)


def settings_of_bundle(material: Material, provenance: dict[str, Any]) -> dict[str, Any]:
    """The parts of a project that say how `material` was made, as far as it shows."""
    settings: dict[str, Any] = {"mixed": False, "tileable": False, "exponent_bits": 32}
    settings["representation"] = "auto" if material.directional is None else "directional"
    shading_map, power_law = material.shading_map, material.power_law
    if shading_map is not None:
        settings["slices"] = len(shading_map.slices)
    made = shading_map.health if shading_map is not None else material.health
    if shading_map is not None or material.directional is not None:
        settings["tileable"] = "seam_error" in made.figures
        settings["evened"] = "unevenness" in made.figures or not settings["tileable"]
    if power_law is not None:
        settings["exponent_bits"] = power_law.storage.exponent_bits
        bound = power_law.health.figures.get("error_bound", nan)
        if isfinite(bound):
            settings |= {"mixed": True, "error_bound_percent": 100.0 * bound / power_law.r_max}
    if provenance.get(SCALE_NOTE) in get_args(Scale):
        settings["scale"] = provenance[SCALE_NOTE]
    return settings
