"""Forms in which a material leaves, declared once: the command line, the window and projects list them from here.

Loading this module loads none of the formats. A format of the package is a module beside this one, which
`engine.exchange.export` pairs with its declaration; a format of another package brings its functions along.
"""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from engine.core import plugins

#: Group of the entry points by which installed packages bring further exporters.
ENTRY_POINTS = "lightarc.exporters"

_NAME = re.compile(r"[a-z][a-z0-9-]{0,63}")


@dataclass(frozen=True)
class Exporter:
    """A form in which a material leaves.

    Attributes
    ----------
    name : of the target on the command line, in projects and records, and of its folder.
    title, hint : the card of the window.
    of_a_lookup : whether it holds a shading map or planes, which PBR maps are not.
    shows_surface : whether it is among the targets that `auto` chooses from.
    shown : for a format of another package: the representation as its files hold it, from subject and settings, or None
        where it shows no image of the surface (`engine.exchange.loss.Shown`).
    contents : for a format of another package: the files, a generator of steps from subject, settings and the sentence
        that states the errors (`engine.exchange.subject.Contents`).
    """

    name: str
    title: str
    hint: str
    of_a_lookup: bool = False
    shows_surface: bool = True
    shown: Callable[[Any, Any], Any] | None = None
    contents: Callable[[Any, Any, str], Any] | None = None


def has_blender() -> bool:
    """Return whether Blender's module is installed beside this program."""
    return importlib.util.find_spec("bpy") is not None


#: What the target of Blender writes: the `.blend`, or what Blender makes it of.
_FOR_BLENDER = (
    ("Blender (.blend)", "Two materials, PBR and the power law, in an asset library that Blender opens")
    if has_blender()
    else (
        "Blender (.glb and script)",
        "A .glb that Blender opens, and a script with which Blender makes the .blend; Blender's module is not here",
    )
)

#: All exporters by name, in the order in which they are listed.
EXPORTERS: dict[str, Exporter] = {
    each.name: each
    for each in (
        Exporter("textures", "Textures", "Base colour, normal, roughness and the like, named and packed for a program"),
        Exporter("materialx", "MaterialX", "OpenPBR and glTF PBR surfaces as .mtlx"),
        Exporter("gltf", "glTF", "A preview sphere with the material as .glb, for the web and engines"),
        Exporter("usd", "USD", "A preview sphere with UsdPreviewSurface as .usdz, for pipelines and Quick Look"),
        Exporter("blender", *_FOR_BLENDER),
        Exporter("shaders", "Shaders", "GLSL, HLSL and OSL that evaluate the material itself", of_a_lookup=True),
        Exporter(
            "web", "Web page", "A page with a light to drag, for any browser and for strict sites", of_a_lookup=True
        ),
        Exporter("rti", "RTI", ".ptm, .rti and a tree for web viewers, for conservators", of_a_lookup=True),
        Exporter(
            "brdf", "BRDF tables", "CSV, ALTA, MERL, RGL, and the nearest model as MaterialX", shows_surface=False
        ),
    )
}


def register(exporter: Exporter) -> Exporter:
    """Declare an exporter of another package; ValueError where it lacks something or its name is taken."""
    if not isinstance(exporter, Exporter) or exporter.shown is None or exporter.contents is None:
        raise ValueError("an exporter is an Exporter with the functions shown and contents")
    if not _NAME.fullmatch(exporter.name) or exporter.name == "auto":
        raise ValueError(f"{exporter.name!r} is not a name of lower-case words joined by hyphens")
    if EXPORTERS.get(exporter.name, exporter) is not exporter:
        raise ValueError(f"there is another exporter {exporter.name}")
    EXPORTERS[exporter.name] = exporter
    return exporter


def unregister(exporter: Exporter) -> None:
    """Take back what `register` did."""
    if EXPORTERS.get(exporter.name) is exporter:
        del EXPORTERS[exporter.name]


plugins.load(ENTRY_POINTS, register)
