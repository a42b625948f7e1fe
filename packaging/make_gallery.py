"""The examples of the start page: projects made by the program's own simulator, and an image of each.

    python packaging/make_gallery.py [woven] [medal] [satin]

writes `NAME.zip` and `NAME.jpg` into resources/gallery (`app.start.examples` opens them). Equal code makes equal
pixels; nothing in them is of a real object or user. The photographs go through JPEG and the ordinary import, as a
user's would. Numbers of the finished maps are rounded to 11 bits, a twentieth of the noise of 8-bit photographs, so
that they compress. Some two minutes, bound by the import of the photographs and the images.
"""

from __future__ import annotations

import dataclasses
import math
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from app.commands.making import mark_stack, material_of
from app.commands.opening import load_environment, load_shape
from app.document.comparison import Comparison
from app.document.document import BRDF, ImportChoices, Look, Project
from app.document.factoring import Factoring, Run
from app.document.scene import DEFAULT_MODEL, scene_of_project
from app.project.factors import Keeping
from app.project.photographs import INSIDE
from app.project.project_file import History, Writer, data_folder
from app.project.thumbnail import SIZE, keep_thumbnail, thumbnail_of
from app.start.examples import FOLDER, PROJECT
from engine.brdf.brdf import brdf_from_text
from engine.brdf.table import HalfDifferenceTable
from engine.capture.lights.sources import find
from engine.core.steps import drain
from engine.factor.factor import factor
from engine.factor.settings import FactorSettings
from engine.geometry.camera import Camera
from engine.geometry.shapes import frame_mesh
from engine.images.encode import encode_png
from engine.light.lamps import LampSettings
from engine.render.direct import radiance
from engine.render.display import Display
from engine.render.display import display as displayed
from engine.scene.material import Material
from engine.simulate.arc import LightArc, dome_azimuths_deg, dome_elevations_deg
from engine.simulate.simulate import simulate
from engine.storage.atomic import write_bytes

#: Quality of the photographs and of the images of the page, and the size of the latter in pixels.
PHOTOGRAPH, IMAGE, IMAGE_SIZE = 90, 90, (960, 640)

#: The least cosine of light and view with the normal in the table: instruments stop 10° above the surface.
GRAZING = math.cos(math.radians(80.0))


@dataclass(frozen=True)
class Made:
    """A project and its camera; `finish` writes what lies beside its file."""

    project: Project
    camera: Camera
    finish: Callable[[Path], None] = lambda _path: None


def woven(data: Path) -> Made:
    """Ten photographs of the woven cloth under an arc, on the draped cloth under one light."""
    elevation = tuple(map(math.radians, range(18, 91, 8)))  # the others predict lower ones badly
    project = capture(LightArc(elevation=elevation, size=256, noise=0.0, misalignment_px=0.0), data, "Woven cloth")
    fill = LampSettings(theta_deg=65.0, phi_deg=80.0, irradiance=0.2)
    look = Look(light_theta_deg=58.0, light_phi_deg=-50.0, irradiance=1.6, repeats=5.0, lamps=(fill,))
    notes = "Ten simulated photographs of a herringbone cloth under a light arc. Press Import in Capture to make the "
    notes += "material again from them."
    camera = Camera((1.75, 1.35, 2.3), (0.03, -0.17, 0.0), fov_deg=33.0)
    return Made(dataclasses.replace(project, look=look, notes=notes), camera)


def medal(data: Path) -> Made:
    """Forty photographs of a bronze medal in a dome, flat and not tiled."""
    azimuth = tuple(math.radians(angle) for angle in dome_azimuths_deg(8))
    elevation = tuple(math.radians(angle) for angle in dome_elevations_deg(5))
    arc = LightArc("medal", elevation, azimuth, size=320, noise=0.0, misalignment_px=0.0)
    project = capture(arc, data, "Bronze medal")
    look = Look(light_theta_deg=50.0, light_phi_deg=-48.0, irradiance=3.0, exposure_ev=0.4)
    project = dataclasses.replace(project, look=look)
    notes = (
        "Forty simulated photographs of a bronze medal in a dome of lamps. Drag the light with Ctrl to read its relief."
    )
    flat = dataclasses.replace(project, **project.lay_flat(project.material), notes=notes)
    assert flat.mesh is not None
    return Made(flat, frame_mesh(flat.mesh, IMAGE_SIZE[0] / IMAGE_SIZE[1]))


def satin(_data: Path) -> Made:
    """A table of a satin as a gonioreflectometer would give it, on a knot, with two factorisations."""
    table = satin_table()
    material = Material(None, None, brdf="ggx:alpha=0.3", name=table.name, measured=table)
    settings = (
        FactorSettings(method="svd", parametrisation="half-diff", side=24, products=5),
        FactorSettings(method="homomorphic", size=32),
    )
    runs = tuple(
        Run(number, number - 1, table.name, "entry:0", choices, table) for number, choices in enumerate(settings, 1)
    )
    key = LampSettings(theta_deg=42.0, phi_deg=-40.0, irradiance=2.6)
    look = Look(rotation_deg=35.0, gain=0.4, directions=64, lamps=(key,))
    project = Project(
        material=material,
        name="Measured satin",
        mesh=drain(load_shape("torus-knot")),
        environment=drain(load_environment("studio")),
        comparison=Comparison().added(table.name, table),
        factoring=Factoring("entry:0", runs=runs, current=1),
        look=look,
        notes="A simulated measurement of a blue satin with one per cent of noise, on a grid of half and difference "
        "angles. Factor shows two factorisations with the error of each number of terms.",
    )

    def finish(path: Path) -> None:
        for run in runs:
            assert run.choices is not None
            Keeping(run, data_folder(path)).keep(drain(factor(table, run.choices)))

    return Made(project, Camera((0.3, 0.9, 5.2), fov_deg=33.0), finish)


def satin_table() -> HalfDifferenceTable:
    """A lobe of the weave, a narrower one of the fibres, a diffuse blue and a Fresnel sheen, with noise of 1 %."""
    counts = (64, 32, 24)
    half = 0.5 * math.pi * ((np.arange(counts[0]) + 0.5) / counts[0]) ** 2
    difference = 0.5 * math.pi * (np.arange(counts[1]) + 0.5) / counts[1]
    about = math.pi * (np.arange(counts[2]) + 0.5) / counts[2]
    theta_h, theta_d, phi_d = np.meshgrid(half, difference, about, indexing="ij")
    light, view = directions_of(theta_h, theta_d, phi_d)
    lobes = (
        ("lambert:albedo=1", (0.02, 0.05, 0.2)),
        ("ggx:kd=0,alpha=0.42,f0=0.05", (1.2, 1.9, 4.0)),
        ("ggx:kd=0,alpha=0.15,f0=0.04", (1.0, 1.1, 1.3)),
    )
    below = np.minimum(light[..., 2], view[..., 2]) < GRAZING  # not measured: filled with what lies nearest
    light, view = raise_error(light), raise_error(view)
    values = np.zeros((*counts, 3))
    for text, colour in lobes:
        values += np.asarray(brdf_from_text(text).f(light, view)) * np.array(colour)
    values *= 1.0 + 0.01 * np.random.default_rng(7).standard_normal(values.shape)
    return HalfDifferenceTable(round_values(values), below, name="Blue satin", kind="simulated measurement")


def raise_error(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (…, 3) whose cosine with the normal is at least `GRAZING`."""
    cosine = np.maximum(directions[..., 2], GRAZING)
    across = directions[..., :2] / np.maximum(np.linalg.norm(directions[..., :2], axis=-1, keepdims=True), 1e-9)
    sine = np.sqrt(1.0 - cosine * cosine)
    return np.concatenate([across * sine[..., None], cosine[..., None]], -1)


def directions_of(
    theta_h: NDArray[Any], theta_d: NDArray[Any], phi_d: NDArray[Any]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(…, 3) light and view for half angles (Rusinkiewicz 1998), with the half vector at azimuth 0."""
    local = np.stack([np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d), np.cos(theta_d)], -1)
    cosine, sine = np.cos(theta_h), np.sin(theta_h)

    def turn(vector: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y, z = np.moveaxis(vector, -1, 0)
        return np.stack([cosine * x + sine * z, y, -sine * x + cosine * z], -1)

    half = turn(np.broadcast_to([0.0, 0.0, 1.0], local.shape))
    light = turn(local)
    return light, 2.0 * (light * half).sum(-1, keepdims=True) * half - light


def capture(arc: LightArc, data: Path, name: str) -> Project:
    """The project of a simulated capture: its photographs as JPEG inside `data`, imported and built as any other.

    The pixels of its stack lie in the cache and not in the archive: they are large, and the window reads them again
    from the photographs, which the project knows by their marks.
    """
    with tempfile.TemporaryDirectory() as folder:
        drain(simulate(arc, Path(folder)))
        inside = data / INSIDE / "0001"
        inside.mkdir(parents=True)
        table = (Path(folder) / "capture.toml").read_text(encoding="utf-8")
        (inside / "capture.toml").write_text(table.replace(".tif", ".jpg"), encoding="utf-8")
        for path in sorted(Path(folder).glob("*.tif")):
            pixels = cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
            Image.fromarray(pixels).save(inside / f"{path.stem}.jpg", quality=PHOTOGRAPH, subsampling=0)
        sources = find([inside])
        stack = drain(mark_stack(sources, ImportChoices(), (data, data), tuple(sources.photographs), None))
        material = drain(material_of(Project(sources=sources, stack=stack, name=name)))
        maps = {
            part: pack(value) for part in ("shading_map", "power_law") if (value := getattr(material, part)) is not None
        }
        settled = dataclasses.replace(material, name=name, brdf=BRDF, **maps)
        project = Project(
            sources=sources,
            stack=stack,
            imported_with=ImportChoices(),
            material=settled,
            provenance=dict(stack.provenance),
            name=name,
        )
        return dataclasses.replace(project, built_from=project.recipe)


def pack(maps: Any) -> Any:
    """The same maps with numbers that compress."""
    arrays = {
        each.name: round_values(value)
        for each in dataclasses.fields(maps)
        if each.init and isinstance(value := getattr(maps, each.name), np.ndarray) and value.dtype == np.float32
    }
    return dataclasses.replace(maps, **arrays)


def round_values(values: NDArray[Any]) -> NDArray[np.float32]:
    """`values` as float32 with the precision of half floats, whatever their range."""
    mantissa, exponent = np.frexp(np.asarray(values, np.float64))
    return np.asarray(np.ldexp(np.round(mantissa * 2048.0) / 2048.0, exponent), np.float32)


def write(name: str, make: Callable[[Path], Made]) -> str:
    """Make an example and write its archive and image; a line on their sizes."""
    begun = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / PROJECT
        data = data_folder(path)
        data.mkdir()
        writer = Writer(path)
        writer.write(History(Project()))  # marks of photographs are kept in a project that is there
        made = make(data)
        project = dataclasses.replace(made.project, camera=made.camera)
        writer.write(History(project))
        writer.close()
        made.finish(path)
        pixels = image_of(project, made.camera)
        drain(keep_thumbnail(path, project))
        write_bytes(thumbnail_of(path), encode_png(thumbnail(pixels)))
        FOLDER.mkdir(exist_ok=True)
        Image.fromarray(pixels).save(FOLDER / f"{name}.jpg", quality=IMAGE, optimize=True)
        with zipfile.ZipFile(FOLDER / f"{name}.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            members = {each.relative_to(data).as_posix(): each for each in data.rglob("*") if each.is_file()}
            for member, file in sorted({**members, PROJECT: path}.items()):
                about = zipfile.ZipInfo(member, (1980, 1, 1, 0, 0, 0))
                about.compress_type = zipfile.ZIP_DEFLATED
                archive.writestr(about, file.read_bytes(), compresslevel=9)
    sizes = [round((FOLDER / f"{name}.{ending}").stat().st_size / 1e3) for ending in ("zip", "jpg")]
    return f"{name}: {sizes[0]} kB, image {sizes[1]} kB, {time.perf_counter() - begun:.0f} s"


def thumbnail(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The middle of an image, small."""
    height, width = pixels.shape[:2]
    side = (width - height * SIZE[0] // SIZE[1]) // 2
    middle = Image.fromarray(pixels).crop((side, 0, width - side, height))
    return np.asarray(middle.resize(SIZE, Image.Resampling.BOX))


def image_of(project: Project, camera: Camera) -> NDArray[np.uint8]:
    """The image of an example, as the View workspace shows it."""
    mesh = project.mesh or drain(load_shape(DEFAULT_MODEL))
    scene = scene_of_project(project, mesh, project.material.reflectance, camera)
    display = Display(project.look.exposure_ev, project.look.tone_map)
    return displayed(drain(radiance(scene, IMAGE_SIZE, samples=1)), display)


EXAMPLES: dict[str, Callable[[Path], Made]] = {"woven": woven, "medal": medal, "satin": satin}

if __name__ == "__main__":
    for chosen in sys.argv[1:] or EXAMPLES:
        print(write(chosen, EXAMPLES[chosen]), flush=True)
