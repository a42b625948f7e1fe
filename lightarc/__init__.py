"""Lightarc for notebooks and pipelines: from photographs of a material to images of it.

    import lightarc

    stack = lightarc.import_capture("photographs", "stack", angles_deg=[10, 30, 50, 70, 90])
    material = lightarc.compress_material(lightarc.build_material(stack, brdf=lightarc.Ggx(alpha=0.3)))
    lightarc.save_bundle("woven.lightarc", material)
    lightarc.save_image("woven.png", lightarc.render("cloth", material=material, light=(0.3, 1, 0.5)))
    lightarc.export(material, "woven-gltf", to="gltf")

The names in `__all__` are the whole of it; everything else belongs to the program and may change at any time. The
examples of the functions follow one another in that order: the files that one leaves are read by those after it.

Whatever stands for its kind is accepted: photographs, environments and images as arrays, paths or open files; a model
as a file, a trimesh object or (vertices, faces); a light as a vector; a BRDF as its text on the command line
(`ggx:alpha=0.3`), a measured file, a model (`lightarc.Ggx(alpha=0.3)`) or any object with `f(wi, wo)`. Images are
float32 arrays (height, width, 4) of linear sRGB radiance times coverage, and coverage. Long work reports to
`progress`, where one is given, a step with `done` in [0, 1] and a `note`.

What a user can fix raises a `LightarcError`, whose text is a sentence with the file, the cause and the remedy;
impossible values raise its UsageError, which is a ValueError too. Whatever is written is complete, or absent.

Packages add BRDF models, readers of files, modes and exporters by `register_brdf`, `register_reader`, `register_mode`
and `register_exporter`, or by entry points of the groups `lightarc.brdfs`, `lightarc.readers`, `lightarc.modes` and
`lightarc.exporters` (see CONTRIBUTING.md).
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from engine import __version__
from engine.core.errors import (
    FileError,
    InputError,
    LightarcError,
    MissingCapability,
    OutOfMemory,
    OutputError,
    UsageError,
)

if TYPE_CHECKING:
    from engine.accuracy.compare import ImageError
    from engine.brdf.brdf import Brdf
    from engine.brdf.brdf import register as register_brdf
    from engine.brdf.fit import Fit
    from engine.brdf.models.diffuse import Lambert, OrenNayar
    from engine.brdf.models.lafortune import Lafortune, LafortuneThreeLobes
    from engine.brdf.models.microfacet import (
        AshikhminShirley,
        CookTorrance,
        Ggx,
        GgxAnisotropic,
        MetallicRoughness,
        Ward,
    )
    from engine.brdf.models.model import Model
    from engine.brdf.models.phong import BlinnPhong, Phong
    from engine.brdf.models.poulin_fournier import PoulinFournier
    from engine.bundle.bundle import Verification
    from engine.capture.lights.sources import Sources
    from engine.capture.stack import ImageStack
    from engine.core.params import Colour, param
    from engine.exchange.targets import Exporter
    from engine.exchange.targets import register as register_exporter
    from engine.factor.errors import Factorisation
    from engine.geometry.camera import Camera
    from engine.geometry.mesh import Mesh
    from engine.light.environment import EnvironmentMap
    from engine.light.lamps import Lamp
    from engine.light.near_lamps import NearLamp
    from engine.planning.plan import EffectsPlan
    from engine.scene.material import Material
    from engine.scene.mode import Mode
    from engine.scene.mode import register as register_mode
    from engine.scene.scene import Scene
    from engine.storage.readers import Reader
    from engine.storage.readers import register as register_reader
    from engine.surface.recover import Surface
    from engine.tradeoff.sweep import Tradeoff
    from lightarc._batch import run_batch
    from lightarc._brdf import (
        evaluate_brdf,
        evaluate_pdf,
        factor_brdf,
        fit_brdf,
        open_brdf,
        sample_brdf,
        save_brdf,
        save_factors,
    )
    from lightarc._capture import import_capture, open_capture, open_stack, recover_normals, simulate_capture
    from lightarc._image import Image
    from lightarc._material import (
        build_material,
        compress_material,
        export,
        open_bundle,
        open_material,
        save_bundle,
        verify_bundle,
    )
    from lightarc._scene import (
        bake,
        compare,
        draw_figures,
        make_scene,
        plan,
        relight,
        render,
        save_image,
        tradeoff,
    )

__all__ = [  # noqa: RUF022 - in the order in which they are used
    "simulate_capture",
    "open_capture",
    "import_capture",
    "open_stack",
    "recover_normals",
    "build_material",
    "compress_material",
    "save_bundle",
    "open_bundle",
    "open_material",
    "verify_bundle",
    "export",
    "run_batch",
    "open_brdf",
    "evaluate_brdf",
    "sample_brdf",
    "evaluate_pdf",
    "fit_brdf",
    "factor_brdf",
    "save_factors",
    "save_brdf",
    "make_scene",
    "render",
    "save_image",
    "compare",
    "bake",
    "relight",
    "plan",
    "tradeoff",
    "draw_figures",
    "register_brdf",
    "register_exporter",
    "register_reader",
    "register_mode",
    "Exporter",
    "Reader",
    "Mode",
    "Lambert",
    "OrenNayar",
    "Phong",
    "BlinnPhong",
    "Lafortune",
    "LafortuneThreeLobes",
    "Ward",
    "AshikhminShirley",
    "CookTorrance",
    "Ggx",
    "GgxAnisotropic",
    "PoulinFournier",
    "MetallicRoughness",
    "Model",
    "Brdf",
    "Colour",
    "param",
    "Sources",
    "ImageStack",
    "Surface",
    "Material",
    "Mesh",
    "Camera",
    "EnvironmentMap",
    "Lamp",
    "NearLamp",
    "Scene",
    "Image",
    "ImageError",
    "Fit",
    "Factorisation",
    "EffectsPlan",
    "Tradeoff",
    "Verification",
    "LightarcError",
    "UsageError",
    "FileError",
    "InputError",
    "OutputError",
    "MissingCapability",
    "OutOfMemory",
    "__version__",
]

#: Modules of the names that are loaded when they are first asked for: numpy alone takes longer than all that is above.
_LATER = {
    **dict.fromkeys(("evaluate_brdf", "evaluate_pdf", "factor_brdf", "fit_brdf"), "lightarc._brdf"),
    **dict.fromkeys(("open_brdf", "sample_brdf", "save_brdf", "save_factors"), "lightarc._brdf"),
    "run_batch": "lightarc._batch",
    **dict.fromkeys(("import_capture", "open_capture", "open_stack", "recover_normals"), "lightarc._capture"),
    **dict.fromkeys(("simulate_capture",), "lightarc._capture"),
    **dict.fromkeys(("build_material", "compress_material", "export", "open_bundle"), "lightarc._material"),
    **dict.fromkeys(("open_material", "save_bundle", "verify_bundle"), "lightarc._material"),
    **dict.fromkeys(("bake", "compare", "draw_figures", "make_scene"), "lightarc._scene"),
    **dict.fromkeys(("plan", "relight", "render", "save_image"), "lightarc._scene"),
    **dict.fromkeys(("tradeoff",), "lightarc._scene"),
    **dict.fromkeys(("Lambert", "OrenNayar"), "engine.brdf.models.diffuse"),
    **dict.fromkeys(("Phong", "BlinnPhong"), "engine.brdf.models.phong"),
    **dict.fromkeys(("Lafortune", "LafortuneThreeLobes"), "engine.brdf.models.lafortune"),
    **dict.fromkeys(("Ggx", "GgxAnisotropic", "MetallicRoughness"), "engine.brdf.models.microfacet"),
    **dict.fromkeys(("Ward", "AshikhminShirley", "CookTorrance"), "engine.brdf.models.microfacet"),
    "PoulinFournier": "engine.brdf.models.poulin_fournier",
    "Model": "engine.brdf.models.model",
    "Brdf": "engine.brdf.models.model",
    "Colour": "engine.core.params",
    "param": "engine.core.params",
    "Sources": "engine.capture.lights.sources",
    "ImageStack": "engine.capture.stack",
    "Surface": "engine.surface.recover",
    "Material": "engine.scene.material",
    "Mesh": "engine.geometry.mesh",
    "Camera": "engine.geometry.camera",
    "EnvironmentMap": "engine.light.environment",
    "Lamp": "engine.light.lamps",
    "NearLamp": "engine.light.near_lamps",
    "Scene": "engine.scene.scene",
    "Image": "lightarc._image",
    "ImageError": "engine.accuracy.compare",
    "Fit": "engine.brdf.fit",
    "Factorisation": "engine.factor.errors",
    "EffectsPlan": "engine.planning.plan",
    "Tradeoff": "engine.tradeoff.sweep",
    "Verification": "engine.bundle.bundle",
    "Exporter": "engine.exchange.targets",
    "Reader": "engine.storage.readers",
    "Mode": "engine.scene.mode",
}

#: Modules whose `register` adds a part of another package.
_REGISTERS = {
    "register_brdf": "engine.brdf.brdf",
    "register_exporter": "engine.exchange.targets",
    "register_reader": "engine.storage.readers",
    "register_mode": "engine.scene.mode",
}

#: Names of earlier versions, and those that took their place.
_RENAMED = {"save_picture": "save_image"}


def __getattr__(name: str) -> Any:
    if name in _RENAMED:
        import warnings

        warnings.warn(f"lightarc.{name} is now lightarc.{_RENAMED[name]}", DeprecationWarning, stacklevel=2)
        return __getattr__(_RENAMED[name])
    if name in _REGISTERS:
        found: Any = import_module(_REGISTERS[name]).register
    elif name in _LATER:
        found = getattr(import_module(_LATER[name]), name)
    else:
        raise AttributeError(f"module 'lightarc' has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
