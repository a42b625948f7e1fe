"""The material that a stack becomes, and the bundle that holds it."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from engine.core.errors import UsageError
from engine.core.steps import Step, drain
from lightarc._border import public

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.bundle.bundle import Verification
    from engine.capture.stack import ImageStack
    from engine.scene.material import Material

File = str | os.PathLike[str]
Progress = Callable[[Step], None]


@public
def build_material(
    stack: ImageStack,
    *,
    slices: int = 8,
    brdf: str | Brdf = "phong:exponent=20",
    representation: Literal["auto", "shading-map", "directional"] = "auto",
    excluded: Collection[str] = (),
    name: str = "material",
    progress: Progress | None = None,
) -> Material:
    """Make a stack the shading map or the directional map of a material, and give the material a BRDF.

    Parameters
    ----------
    slices : of the shading map, at least 2; their mean radiance grows evenly from 0.
    brdf : a measured one is kept as a table beside the GGX model that is nearest to it.
    representation : brightness of the light alone, as one arc of lamps needs it (`shading-map`), its direction
        (`directional`), or the one that shows photographs better that are left out.
    excluded : file names of photographs to leave out.

    InputError for a stack without light, ValueError for a photograph that the stack does not hold.

    >>> material = lightarc.build_material(stack, slices=4, brdf="ggx:alpha=0.4", name="plain")
    >>> material.shading_map.slices.shape, material.elevation_deg
    ((4, 32, 32, 3), (30.0, 60.0, 90.0))
    """
    from engine.brdf.brdf import MODELS, brdf_to_text
    from engine.brdf.fit import fit, fit_data
    from engine.brdf.models.microfacet import Ggx
    from engine.brdf.readers.table_file import keep_table
    from engine.factor.factor_file import open_reflectance
    from engine.scene.material import Material
    from engine.shading.representation import choose
    from engine.shading.shading_map import ShadingMap, include

    reflectance = open_reflectance(brdf) if isinstance(brdf, str) else brdf
    measured = None if type(reflectance) in MODELS.values() else drain(keep_table(reflectance), progress)
    model = reflectance if measured is None else drain(fit(fit_data(measured), Ggx()), progress).brdf
    chosen = drain(choose(stack, slices, excluded=excluded, wanted=representation), progress)
    shading_map = chosen.map if isinstance(chosen.map, ShadingMap) else None
    return Material(
        shading_map,
        None,
        directional=None if isinstance(chosen.map, ShadingMap) else chosen.map,
        brdf=brdf_to_text(model),
        elevation_deg=tuple(float(angle) for angle in stack.elevation_deg[include(stack, excluded)]),
        name=name,
        health=chosen.health if shading_map is None else shading_map.health.merge(chosen.health),
        measured=measured,
    )


@public
def compress_material(
    material: Material,
    *,
    scale: Literal["last-slice", "least-squares"] = "last-slice",
    max_error: float | None = None,
    exponent_bits: Literal[8, 16, 32] = 32,
    progress: Progress | None = None,
) -> Material:
    """`material` with the power law that stands for its slices: six numbers a texel.

    Parameters
    ----------
    scale : the factor of the power law is the last slice, or the best one.
    max_error : keep the slices of every tile of 16 × 16 texels in which the error of a texel (root mean square over
        slices and channels) reaches this times the largest mean radiance; None keeps none.
    exponent_bits : store exponents in so many bits.

    ValueError for a material without slices.

    >>> material = lightarc.compress_material(material, exponent_bits=16)
    >>> material.power_law.scale.shape, material.power_law.size_bytes < material.shading_map.slices.nbytes
    ((32, 32, 3), True)
    """
    from engine.shading.mixed import keep_tiles
    from engine.shading.power_law import fit
    from engine.shading.quantise import quantise

    slices = material.shading_map
    if slices is None:
        raise UsageError("a material without slices cannot be compressed")
    power_law = drain(fit(slices, scale), progress)
    if exponent_bits != 32:
        power_law = drain(quantise(power_law, slices, exponent_bits), progress)
    if max_error is not None:
        power_law = drain(keep_tiles(power_law, slices, max_error * slices.r_max), progress)
    return replace(material, power_law=power_law, health=slices.health.merge(power_law.health))


@public
def save_bundle(path: File, material: Material, *, progress: Progress | None = None) -> Path:
    """Write `material` as a bundle, a `.lightarc` file or a folder, and return its path.

    A bundle of that name is replaced, anything else is refused with an OutputError.

    >>> lightarc.save_bundle("plain.lightarc", material).name
    'plain.lightarc'
    """
    from engine.bundle.bundle import save_bundle as saving
    from engine.scene.material import error_figures

    return drain(saving(path, material, figures=error_figures(material)), progress)


@public
def open_bundle(path: File) -> Material:
    """The material in a bundle, bit for bit as it was saved; InputError where it is damaged or is no bundle.

    >>> again = lightarc.open_bundle("plain.lightarc")
    >>> again.name, bool((again.power_law.exponent == material.power_law.exponent).all())
    ('plain', True)
    """
    from engine.bundle.bundle import open_bundle as opened

    return opened(path)


@public
def verify_bundle(path: File) -> Verification:
    """Check names, sizes, fingerprints, schema, bounds and pixels of a bundle, and collect what is wrong.

    >>> lightarc.verify_bundle("plain.lightarc").ok
    True
    """
    from engine.bundle.bundle import verify_bundle as verified

    return verified(path)
