"""Lightarc for notebooks and pipelines: from photographs of a material to images of it.

    import lightarc

    lightarc.import_capture("photographs", "stack", angles_deg=[10, 30, 50, 70, 90])
    material = lightarc.compress_material(lightarc.build_material(lightarc.open_stack("stack")))
    lightarc.save_bundle("woven.lightarc", material)
    image = lightarc.render("cloth", material=material, light_deg=(40, 0))
    lightarc.save_picture("woven.png", image)

The names in `__all__` are the whole of it; everything else belongs to the program and may change at any time. The
examples of the functions follow one another in that order: the files that one leaves are read by those after it.

Images are float32 arrays (height, width, 4) of linear sRGB radiance times coverage, and coverage. A BRDF is named as
on the command line (`ggx:alpha=0.3`, a measured file, a folder of factors) or is what `open_brdf` returns. Long work
reports to `progress`, where one is given, a step with `done` in [0, 1] and a `note`.

What a user can mend raises a `LightarcError`, whose text is a sentence with the file, the cause and the remedy;
impossible values raise its UsageError, which is a ValueError too. Whatever is written is complete, or absent.
"""

from engine import __version__
from engine.core.errors import FileError, LightarcError, MissingCapability, OutOfMemory, UsageError
from lightarc._brdf import evaluate_brdf, factor_brdf, fit_brdf, open_brdf, save_factors
from lightarc._capture import import_capture, open_capture, open_stack, simulate_capture
from lightarc._image import bake, compare, relight, render, save_image
from lightarc._material import build_material, compress_material, open_bundle, save_bundle, verify_bundle

__all__ = [  # noqa: RUF022 - in the order in which they are used
    "simulate_capture",
    "open_capture",
    "import_capture",
    "open_stack",
    "build_material",
    "compress_material",
    "save_bundle",
    "open_bundle",
    "verify_bundle",
    "open_brdf",
    "evaluate_brdf",
    "fit_brdf",
    "factor_brdf",
    "save_factors",
    "render",
    "save_image",
    "compare",
    "bake",
    "relight",
    "LightarcError",
    "UsageError",
    "FileError",
    "MissingCapability",
    "OutOfMemory",
    "__version__",
]
