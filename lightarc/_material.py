"""The material that a stack becomes, the bundle that holds it, and its exports."""

from __future__ import annotations

import os
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from engine.brdf.brdf import MODELS, brdf_to_text
from engine.brdf.fit import fit, fit_data
from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.table_file import keep_table
from engine.bundle.bundle import open_bundle as read_bundle
from engine.bundle.bundle import save_bundle as saving
from engine.bundle.bundle import verify_bundle as verify
from engine.capture.diffuse_part import take_part
from engine.capture.evenness import even_out
from engine.capture.object_part import take_object
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.enlarge import enlarge as enlarging
from engine.exchange.enlarge import width_of_tile
from engine.exchange.export import export as exporting
from engine.exchange.subject import Settings
from engine.scene.credits import Credits
from engine.scene.material import Material, error_figures
from engine.shading.mixed import keep_tiles
from engine.shading.quantise import quantise
from engine.shading.representation import choose
from engine.shading.shading_map import ShadingMap, include
from engine.shading.stack_arcs import exclude_beside
from engine.shading.tile import make_tile, tile_health, tile_planes
from lightarc._border import public
from lightarc._inputs import BrdfLike, File, FileLike, Progress, as_azimuth, as_brdf, as_material, as_stack, on_disk

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from engine.bundle.bundle import Verification
    from engine.capture.stack import ImageStack


@public
def build_material(
    stack: ImageStack | File | ArrayLike,
    *,
    angles_deg: ArrayLike | None = None,
    lights: ArrayLike | None = None,
    slices: int = 8,
    brdf: BrdfLike = "phong:exponent=20",
    representation: Literal["auto", "shading-map", "directional"] = "auto",
    excluded: Collection[str] = (),
    azimuth_deg: float | tuple[float, float] | None = None,
    arc: bool = False,
    tileable: bool = False,
    overlap: int | None = None,
    brightness: Literal["evened", "as-it-is"] = "evened",
    part: Literal["diffuse", "whole"] = "diffuse",
    name: str = "material",
    progress: Progress | None = None,
) -> Material:
    """Make a material of photographs: their shading map or directional map, and a BRDF.

    Parameters
    ----------
    stack : ImageStack, path, or array of shape (N, H, W, 3)
        The photographs; an array is ordered by rising elevation and has linear radiance, or 8 or 16 bits.
    angles_deg : array_like, shape (N,), optional
        For arrays: elevations of the lamp in degrees; evenly spaced up to 90 where neither these nor lights are given.
    lights : array_like, shape (N, 3), optional
        In their place, vectors towards the lamps, x to the right of the photograph, y up, z to the camera.
    slices : int
        Slices of the shading map, at least 2; their mean radiance grows evenly from 0.
    brdf : str, path, Brdf or model class
        The BRDF; a measured one is kept as a table beside the GGX model that is nearest to it.
    representation : {'auto', 'shading-map', 'directional'}
        What the material knows of the light: its brightness, as one arc of lamps needs it, its direction, or what shows
        photographs better that are left out.
    excluded : collection of str
        File names of photographs to leave out.
    azimuth_deg : float or (float, float), optional
        Use the lamps of this azimuth alone, in degrees, 0 = right, 90 = up in the image, within a tolerance (2.5).
    arc : bool
        Use the lamps of one arc: the azimuth ±10° with most elevations.
    tileable : bool
        Cut the material so that it repeats without seams.
    overlap : int, optional
        Width in texels of the band in which opposite edges are joined; an eighth of the shorter side.
    brightness : {'evened', 'as-it-is'}
        Whether slow changes of brightness across the photographs are divided out before a tile is cut.
    part : {'diffuse', 'whole'}
        Light of pairs under polarisers that the map is made of: the diffuse part, to which the BRDF adds highlights, or
        the whole.
    name : str
        Name of the material.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Material
        The material.

    Raises
    ------
    UsageError
        For a photograph that the stack does not hold, and arrays that are not photographs.
    InputError
        For a stack without light, without lamps at the azimuth, or too small for the overlap.

    References
    ----------
    .. [1] J. Kautz, M. Sattler, R. Sarlette, R. Klein, H.-P. Seidel, "Decoupling BRDFs from Surface Mesostructures",
       Graphics Interface 2004.

    Examples
    --------
    >>> material = lightarc.build_material(stack, slices=4, brdf=lightarc.Ggx(alpha=0.4), name="plain")
    >>> material.name, material.brdf.split(",")[1], material.shading_map
    ('plain', 'alpha=0.4', ShadingMap(slices=4, size='32 × 32 texels', r_max=...))
    >>> tile = lightarc.build_material(stack, slices=4, tileable=True, overlap=4)
    >>> tile.shading_map.slices.shape[1] < 32
    True
    """
    if overlap is not None and (overlap < 1 or not tileable):
        raise UsageError("overlap is a positive number of texels, of a tileable material")
    if azimuth_deg is not None and arc:
        raise UsageError("give azimuth_deg or arc, not both")
    stack, reflectance = as_stack(stack, angles_deg, lights), as_brdf(brdf)
    measured = None if type(reflectance) in MODELS.values() else drain(keep_table(reflectance), progress)
    model = reflectance if measured is None else drain(fit(fit_data(measured), Ggx()), progress).brdf
    if azimuth_deg is not None or arc:
        excluded = exclude_beside(stack, as_azimuth(azimuth_deg), excluded)
    stack, evenness = drain(take_part(stack, part), progress)
    stack, mask, masked = drain(take_object(stack, to_tile=tileable), progress)
    evenness = evenness.merge(masked)
    if tileable and brightness == "evened":
        stack, evened = drain(even_out(stack), progress)
        evenness = evenness.merge(evened)
    chosen = drain(choose(stack, slices, excluded=excluded, wanted=representation), progress)
    health = chosen.health.merge(evenness)
    shading_map, directional = (chosen.map, None) if isinstance(chosen.map, ShadingMap) else (None, chosen.map)
    if tileable and shading_map is not None:
        shading_map = drain(make_tile(stack, shading_map, overlap=overlap, excluded=excluded), progress).shading_map
    elif tileable and directional is not None:
        sample = directional.planes.shape[1:]
        directional, source = drain(tile_planes(directional, overlap=overlap, name=name), progress)
        health = health.merge(tile_health(source, (sample[0], sample[1])))
    return Material(
        shading_map,
        None,
        directional=directional,
        brdf=brdf_to_text(model),
        elevation_deg=tuple(float(angle) for angle in stack.elevation_deg[include(stack, excluded)]),
        name=name,
        health=health if shading_map is None else shading_map.health.merge(health),
        measured=measured,
        mask=mask,
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
    """Compress the slices of a material by a power law: six numbers a texel.

    Parameters
    ----------
    material : Material
        A material with slices.
    scale : {'last-slice', 'least-squares'}
        The factor of the power law is the last slice, or the best one.
    max_error : float, optional
        Keep the slices of every tile of 16 × 16 texels in which the error of a texel (root mean square over slices and
        channels) reaches this times the largest mean radiance; None keeps none.
    exponent_bits : {8, 16, 32}
        Bits of a stored exponent.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Material
        The material, with its power law.

    Raises
    ------
    UsageError
        For a material without slices.

    Examples
    --------
    >>> material = lightarc.compress_material(material, exponent_bits=16)
    >>> material.power_law.scale.shape, material.power_law.size_bytes < material.shading_map.slices.nbytes
    ((32, 32, 3), True)
    """
    from engine.shading.power_law import fit

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
    """Write a material as a bundle.

    Parameters
    ----------
    path : path
        A `.lightarc` file or a folder; a bundle of that name is replaced, anything else is refused.
    material : Material
        The material.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    Path
        The path.

    Raises
    ------
    OutputError
        Where the bundle cannot be written.

    Examples
    --------
    >>> lightarc.save_bundle("plain.lightarc", material).name
    'plain.lightarc'
    """
    return drain(saving(path, material, figures=error_figures(material)), progress)


@public
def open_bundle(path: FileLike) -> Material:
    """Open the material in a bundle, bit for bit as it was saved.

    Parameters
    ----------
    path : path or file object
        The bundle; a file must be open in binary mode.

    Returns
    -------
    Material
        The material.

    Raises
    ------
    InputError
        Where the bundle is damaged or is none.

    Examples
    --------
    >>> again = lightarc.open_bundle("plain.lightarc")
    >>> again.name, bool((again.power_law.exponent == material.power_law.exponent).all())
    ('plain', True)
    """
    with on_disk(path, ".lightarc") as place:
        return read_bundle(place)


@public
def open_material(path: FileLike, *, search: str | os.PathLike[str] | None = None) -> Material:
    """Open a material of this program or of others.

    Parameters
    ----------
    path : path or file object
        A bundle, a folder or zip of PBR textures, a MaterialX document, a glTF, OBJ or USD file, or a file of
        reflectance transformation imaging (`.ptm`, `.rti`, a folder with `info.json`); `FILE#NAME` is the material of
        that name.
    search : path, optional
        A folder in which images that a document names may lie, beside its own.

    Returns
    -------
    Material
        The material; of a model with those of its parts.

    Raises
    ------
    InputError
        Where the file holds no material.

    Examples
    --------
    >>> lightarc.open_material("plain.lightarc").name
    'plain'
    """
    found = as_material(path, search)
    if found is None:
        raise UsageError("open_material needs a file")
    return found


@public
def verify_bundle(path: File) -> Verification:
    """Check names, sizes, fingerprints, schema, bounds and pixels of a bundle.

    Parameters
    ----------
    path : path
        The bundle.

    Returns
    -------
    Verification
        What is wrong, in sentences.

    Raises
    ------
    InputError
        Where the file is not a bundle at all.

    Examples
    --------
    >>> lightarc.verify_bundle("plain.lightarc").ok
    True
    """
    return verify(path)


@public
def export(
    material: Material | File,
    folder: File,
    to: str | Sequence[str] = "gltf",
    *,
    stack: ImageStack | File | ArrayLike | None = None,
    preset: str = "blender",
    coding: Literal["png8", "png16", "exr"] = "png8",
    normal: Literal["opengl", "directx"] | None = None,
    width_mm: float | None = None,
    enlarge: int | None = None,
    title: str = "",
    author: str = "",
    license: str = "",
    source: str = "",
    error: float = 0.05,
    progress: Progress | None = None,
) -> dict[str, Any]:
    """Write a material in forms that other programs open, with the error of each.

    Parameters
    ----------
    material : Material or path
        The material.
    folder : path
        Folder of the export, with a folder in it for each target; an earlier export is replaced.
    to : str or sequence of str
        Targets: textures, materialx, gltf, usd, blender, shaders, web, rti, brdf; or auto, the smallest within `error`.
    stack : ImageStack, path or array, optional
        The photographs, to state errors against them.
    preset : str
        Program whose names and packing textures have: blender, unreal, unity, godot, substance or gltf.
    coding : {'png8', 'png16', 'exr'}
        Format of textures.
    normal : {'opengl', 'directx'}, optional
        y of normals up or down; None for what the program of the preset reads.
    width_mm : float, optional
        Width of the sample, for the scale bar of a web page.
    enlarge : int, optional
        Write a tile of so many repeats along each side, 2 to 16, that all differ; its errors are not compared with the
        photographs.
    title, author, license, source : str
        Credits that are written into the files, before those that the material came with; the licence as an SPDX
        identifier.
    error : float
        For auto, the largest relative RMSE.
    progress : callable, optional
        Called with a step.

    Returns
    -------
    dict
        The record of the export: `targets` with files, sizes, errors and warnings, `material` with the errors before
        leaving, and `folder`.

    Raises
    ------
    UsageError
        For a target that does not exist or cannot hold the material.
    OutputError
        Where the folder cannot be written.

    Examples
    --------
    >>> record = lightarc.export(material, "plain-gltf", to="gltf")
    >>> record["targets"][0]["files"]
    ['gltf/plain.glb']
    """
    found = as_material(material)
    if found is None:
        raise UsageError("export needs a material")
    photographs = None if stack is None else as_stack(stack)
    if enlarge is not None:
        width_mm = width_of_tile(found, enlarge, photographs, width_mm)
        found, photographs = drain(enlarging(found, enlarge, photographs), progress), None
    settings = Settings(preset, coding, normal, width_mm, credits=Credits(title, author, license, source=source))
    names = [to] if isinstance(to, str) else list(to)
    work = exporting(folder, found, names, settings=settings, stack=photographs, error=error)
    return drain(work, progress)
