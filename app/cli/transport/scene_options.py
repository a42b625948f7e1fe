"""The scene that options name: model, ground, environment and camera, or a project that brings them all."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from app.arguments.quantities import Degrees, share
from app.arguments.results import Input
from app.cli.transport import project_input
from app.cli.transport.options import brushing_argument
from engine.bundle.manifest import MANIFEST
from engine.core.errors import UsageError
from engine.exchange.readers.read import find_doubt_of_parts, holds_material, open_material
from engine.factor.factor_file import open_reflectance
from engine.geometry.camera import frame, parse
from engine.geometry.orientation import ORIENTATIONS
from engine.geometry.shapes import open_mesh
from engine.geometry.usd import is_usd
from engine.light.environment_file import open_environment
from engine.scene.scene import Scene, make_scene
from engine.scene.settings import DEFAULTS as scene_defaults

if TYPE_CHECKING:
    from app.project.setup import Setup
    from engine.geometry.mesh import Mesh
    from engine.scene.material import Material

MESH_HELP = (
    "a file, a built-in (sphere, plane, torus-knot, cloth, blob), a project (.lap), which brings its scene, or a "
    "bundle or a material of another program, which is shown on a sphere, a .glb, .obj or .usdz on its own model"
)
MATERIAL_HELP = (
    "a bundle, a folder or zip of PBR textures, a MaterialX document (.mtlx), a glTF, OBJ or USD file (.glb, .gltf, "
    ".obj, .mtl, .usd, .usda, .usdc, .usdz; of several materials the one named in FILE#NAME) or an RTI file (.ptm, "
    ".rti, a folder with info.json)"
)

#: Model that a material without one is shown on.
SHOWN_ON = "sphere"


def add_mesh(parser: argparse.ArgumentParser) -> None:
    """The model, or the project in its place."""
    parser.add_argument("mesh", type=Input(reach="file"), metavar="MESH", help=MESH_HELP)
    parser.add_argument(
        "--orient",
        choices=ORIENTATIONS,
        help="faces that are turned against each other or inside out: mend them (auto, the default), keep them as the "
        "file has them, or keep them and turn the whole model to its other side (flip)",
    )


def add_ground(parser: argparse.ArgumentParser) -> None:
    """The ground below the model."""
    parser.add_argument(
        "--ground",
        nargs="?",
        type=share,
        const=0.5,
        metavar="ALBEDO",
        help="put the model on a diffuse ground, which receives its shadow (albedo 0.5)",
    )


def add_brushing(parser: argparse.ArgumentParser) -> None:
    """The direction along which an anisotropic BRDF runs."""
    parser.add_argument(
        "--brushing",
        type=brushing_argument,
        metavar="DIRECTION",
        help="direction of an anisotropic BRDF: u along the texture, x, y, z or a vector as 1,0,0 projected into the "
        "surface, each with an angle in degrees behind a colon: y:30 (u, or the project's)",
    )


def add_surroundings(parser: argparse.ArgumentParser) -> None:
    """Environment, ground and camera, as `scene_of` reads them."""
    parser.add_argument(
        "--env", type=Input(reach="file"), metavar="FILE", help="an environment, as for lightarc render"
    )
    turn = Degrees(1, "90")
    parser.add_argument("--env-rotation-deg", type=turn, metavar="A", help="rotation of the environment about +Y (0)")
    add_ground(parser)
    add_brushing(parser)
    parser.add_argument(
        "--camera", type=str, metavar="TEXT", help="as for lightarc render; otherwise the model is framed"
    )


def defaults_of_options() -> dict[str, float]:
    """The defaults of options that a project replaces, by the name of the option."""
    return {
        "env_rotation_deg": scene_defaults.environment_rotation_deg,
        "intensity": scene_defaults.irradiance,
        "tile": scene_defaults.repeats,
    }


def take_own_material(arguments: argparse.Namespace) -> list[str]:
    """Take the material in the place of the model, and the model that it has or `SHOWN_ON`; doubts as sentences.

    Nothing changes where a project, a model without materials, or another material or BRDF is given.
    """
    if project_input.is_given(arguments) or arguments.material is not None or arguments.brdf is not None:
        return []
    if not Path(arguments.mesh).exists():
        return []

    path = Path(arguments.mesh)
    is_model = path.suffix.lower() in (".glb", ".gltf", ".obj", ".ply") or (path.is_file() and is_usd(path))
    if is_model and (doubt := find_doubt_of_parts(path, getattr(arguments, "search", None))) is not None:
        return [f"{path.name} {doubt}"] if doubt else []
    if not is_model and not (_is_bundle(path) or holds_material(path)):
        return []
    arguments.material = arguments.mesh
    if is_model:
        arguments.tile = getattr(arguments, "tile", None) or 1.0
    else:
        arguments.mesh = SHOWN_ON
    return []


def _is_bundle(path: Path) -> bool:
    """True for a name that says so, or a folder with a manifest."""
    return path.suffix.lower() == ".lightarc" or (path / MANIFEST).is_file()


def mesh_of(arguments: argparse.Namespace) -> Mesh:
    """The model that the arguments name, turned as they say; `arguments.model` where it was read before."""
    return getattr(arguments, "model", None) or open_mesh(arguments.mesh, arguments.orient or "auto")


def scene_of(arguments: argparse.Namespace, verb: str) -> Scene:
    """The model or the project of the arguments under its environment; `verb` says what needs one: "a plan"."""
    if project_input.is_given(arguments):
        scene = project_input.setup_of(arguments).scene
        project_input.needs_environment(scene, verb)
        if scene.near_lamps:
            raise UsageError(
                f"{verb} compares modes of which some show no light near the model; remove the project's near lights"
            )
        return scene
    material = open_material(arguments.material, search=arguments.search) if arguments.material else None
    mesh = mesh_of(arguments)
    return make_scene(
        mesh,
        parse(arguments.camera or "", frame(mesh.positions, arguments.width / arguments.height)),
        brdf=open_reflectance(arguments.brdf) if material is None else material.reflectance,
        material=material,
        irradiance=getattr(arguments, "intensity", scene_defaults.irradiance),
        repeats=getattr(arguments, "tile", scene_defaults.repeats),
        environment=open_environment(arguments.env),
        environment_rotation_deg=arguments.env_rotation_deg,
        ground_albedo=arguments.ground,
        brushing=arguments.brushing,
    )


def material_of(setup: Setup | None, arguments: argparse.Namespace) -> Material | None:
    """The material that is given, with those of the parts of its model, or that of the project."""
    if setup is not None:
        return setup.project.material
    return open_material(arguments.material, parts=True, search=arguments.search) if arguments.material else None
