"""The bundle: a material as it leaves the program, in one folder or one `.lightarc` zip (the suffix decides).

It holds the maps so that opening restores every bit (`engine.bundle.maps`, `engine.bundle.pbr`); of photographs the
shader and a page that show the material without this program; and a manifest with the provenance, the error figures and
a fingerprint of each other member. The same material gives the same bytes: members carry no time of day. Reading trusts
nothing: see `engine.storage.archive` for names and sizes, `engine.storage.records` for the manifest; zips, JSON and
pixels are decoded in a process of its own, pixels after the manifest has said how many there must be.
Cost: compressing the maps (some 60 MB/s a core, a strip at a time) bounds saving, decompressing and hashing bound
opening.

A small image of a material, flat and from above, for lists of files: the preview of a bundle that has no better.

Of a shading map it is the slice half way up, of a directional map the image under a lamp `TILT_DEG` from the normal
towards the upper left, of PBR maps the base colour. Only every so many texels are looked at, so that it costs a few
milliseconds at any size.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import AbstractContextManager
from contextvars import copy_context
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

import engine
from engine.brdf.readers.table_file import Table, decode_table, encode_table, keep_table
from engine.bundle.directional import (
    directional_members,
    directional_record,
    read_directional,
)
from engine.bundle.maker import MAKER, check_made_anew, maker
from engine.bundle.manifest import (
    BRDF,
    JSON_LIMIT_BYTES,
    MANIFEST,
    MAPS_PROCESS,
    MASK,
    MEMBERS,
    PREVIEW,
    SHADER,
    VIEWER,
    read_manifest,
)
from engine.bundle.maps import (
    check_fingerprint,
    map_members,
    pixels_member,
    power_law_record,
    read_power_law,
    read_shading_map,
    shading_map_record,
)
from engine.bundle.members import SMALL_LIMIT_BYTES, OpenMember, folder_members, zip_members
from engine.bundle.page import make_page
from engine.bundle.pbr import pbr_members, pbr_record, read_pbr
from engine.bundle.portable import brdf_json, shader
from engine.core.colour import to_display8
from engine.core.directions import surface_direction
from engine.core.errors import InputError, OutputError, UsageError
from engine.core.steps import Step, Steps, part
from engine.images.encode import encode_png
from engine.images.exr_strips import Planes, write_exr_strips
from engine.scene.credits import credits_of
from engine.scene.material import Material
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap
from engine.storage.archive import BUNDLE_LIMIT_BYTES, Archive, json_of, open_archive
from engine.storage.atomic import Pieces
from engine.storage.records import (
    TABLE,
    UNITS,
    HealthRecord,
    Manifest,
    MaskRecord,
    Member,
    write_manifest,
)
from engine.storage.scratch import release
from engine.storage.text import valid
from engine.surface.pbr_maps import PbrMaps, SurfaceMaps

#: Longest side in pixels, share of texels that are at most white, and the lamp of directional maps.
SIDE, BELOW_WHITE, TILT_DEG, AZIMUTH_DEG = 384, 0.98, 40.0, 135.0

#: Radiance above it is as good as this.
_BRIGHTEST = 1e30


def swatch(material: Material) -> bytes:
    """A PNG of at most `SIDE` pixels a side; ValueError for a material without maps."""
    shading_map, law, directional, pbr = material.maps
    if shading_map is not None:
        step = _step(shading_map.slices.shape[1:3])
        image = np.asarray(shading_map.slices[len(shading_map.slices) // 2, ::step, ::step])
    elif law is not None:
        image = _few(law).slice_image(0.5 * law.r_max)
    elif directional is not None:
        lamp = surface_direction(np.radians(TILT_DEG), np.radians(AZIMUTH_DEG))
        image = _thin(directional).image(lamp)
    elif pbr is not None:
        step = _step(pbr.size)
        image = pbr.base_colour[::step, ::step]
    else:
        raise ValueError("a material without maps has no image of its surface")
    image = np.clip(np.nan_to_num(image.astype(np.float64)), 0.0, _BRIGHTEST)
    bright = float(np.quantile(image, BELOW_WHITE))
    shown = to_display8(image / bright if bright > 0.0 else image)
    mask = _mask(material)
    if mask is not None and mask.shape == material.size:
        step = _step(mask.shape)
        shown = np.dstack([shown, np.where(mask[::step, ::step], np.uint8(255), np.uint8(0))])
    return encode_png(shown, software="Lightarc")


def _step(size: tuple[int, ...]) -> int:
    return max(1, -(-max(size) // SIDE))


def _few(law: PowerLawMap) -> PowerLawMap:
    """Every so many texels of a power law, without the tiles that it keeps."""
    step = _step(law.error_map.shape)
    scale, exponent, errors = (map_[::step, ::step] for map_ in (law.scale, law.exponent, law.error_map))
    return replace(law, kept=None, scale=scale, exponent=exponent, error_map=errors)


def _thin(directional: DirectionalMap) -> DirectionalMap:
    step = _step(directional.planes.shape[1:])
    return replace(directional, planes=np.ascontiguousarray(directional.planes[:, ::step, ::step]))


SUFFIX = ".lightarc"
_AT_ONCE = 1 << 24

#: Bytes that are copied at once.
_PART_BYTES = 1 << 22

_MAY_BE_NEGATIVE = ("the shading map", "the kept tiles")

#: A function that makes the content of a member.
Produce = Callable[[], bytes | Planes | Pieces]

Value = TypeVar("Value")
Maps = NDArray[np.float32]


@dataclass(frozen=True)
class Verification:
    """Result of `verify_bundle`: `problems` in sentences, none if the bundle is whole.

    `unchecked` are sentences on members for other programs that another version of this one wrote, so that it cannot
    tell whether somebody changed them; the material does not depend on them.
    """

    members: tuple[str, ...]
    problems: tuple[str, ...]
    size_bytes: int
    schema_version: int | None
    unchecked: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        return not self.problems


def save_bundle(
    path: str | os.PathLike[str],
    material: Material,
    *,
    provenance: Mapping[str, Any] | None = None,
    figures: Mapping[str, Any] | None = None,
    preview: bytes | None = None,
) -> Steps[Path]:
    """Write `material` as a bundle; an existing bundle is replaced in one step, anything else is refused.

    Factors are sampled into a table first, the one form of measured BRDF that a bundle has.

    Parameters
    ----------
    path : folder, or a file that ends in .lightarc.
    provenance : JSON values: cameras, levels, white balance, angles, what was assumed.
    figures : JSON values: error figures, with the unit in each key.
    preview : a PNG; by default a small image of the material flat under a lamp (`engine.bundle.bundle`).

    Returns `path`. Raises OutputError where it cannot be written, and UsageError for a material without maps or with
    values that are not finite, or negative outside the slices.
    """
    target = Path(path)
    check_replaceable(target)
    _check_values(material)
    material = replace(material, name=valid(material.name))
    if material.measured is not None:
        material = replace(material, measured=(yield from part(keep_table(material.measured), 0.0, 0.2)))
    contents = _contents(material, preview)
    members: dict[str, Member] = {}
    with _sink(target, _size_estimate(material)) as opened:
        for index, (name, produce) in enumerate(contents.items()):
            start, stop = (0.2 + 0.8 * place / (len(contents) + 1) for place in (index, index + 1))
            members[name] = yield from part(_write(name, produce, opened), start, stop)
        yield Step(0.99, f"writing {MANIFEST}")
        manifest = write_manifest(_manifest(material, provenance or {}, figures or {}, members))
        with opened(MANIFEST, len(manifest)) as member:
            member.write(manifest)
        if sum(member.size_bytes for member in members.values()) > BUNDLE_LIMIT_BYTES - JSON_LIMIT_BYTES:
            problem = f"the material is larger than the {BUNDLE_LIMIT_BYTES >> 30} GiB of a bundle"
            raise OutputError(target, problem, "Reduce the resolution")
    return target


def _write(name: str, produce: Produce, opened: OpenMember) -> Steps[Member]:
    """Write one member; maps are packed strip by strip, and the page image by image."""
    note = f"writing {name}"
    content = yield from _in_thread(produce, 0.0, note)
    if not isinstance(content, Planes):
        with opened(name, len(content)) as member:
            for piece in (content,) if isinstance(content, bytes) else content:
                member.write(piece)
                yield Step(0.5, note)
        return member.fingerprint
    with opened(name, content.size_bytes + (1 << 20)) as member:
        member.late = yield from write_exr_strips(content, member.write, note)
    return member.fingerprint


def open_bundle(path: str | os.PathLike[str]) -> Material:
    """The material in a bundle, bit for bit as it was saved; InputError where anything is not as it was written."""
    archive = open_archive(path, MEMBERS, MAPS_PROCESS)
    manifest = read_manifest(archive)
    return _material(archive, manifest)


def verify_bundle(path: str | os.PathLike[str]) -> Verification:
    """Check names, sizes, fingerprints, schema, bounds, pixels, page and shader of a bundle, and collect what is wrong.

    Raises InputError only where there is nothing to look at: `path` is missing or not readable.
    """
    archive = open_archive(path, MEMBERS, MAPS_PROCESS)
    names = tuple(sorted(archive.sizes))
    try:
        manifest = read_manifest(archive)
    except InputError as error:
        return Verification(names, (f"{error.problem}.",), archive.size_bytes, None)

    problems = _fingerprint_problems(archive, manifest)
    unchecked: list[str] = []
    if not problems:
        try:
            _check_brdf(archive, manifest)
            material = _material(archive, manifest)
            _check_values(material)
            foreign, unchecked = check_made_anew(archive, manifest, material)
            problems += foreign
        except InputError as error:
            problems.append(f"{error.problem}.")
        except UsageError as error:
            problems.append(f"{error}.")
    return Verification(names, tuple(problems), archive.size_bytes, manifest.schema_version, tuple(unchecked))


def extract_bundle(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> list[str]:
    """Write the members of a bundle into `folder`, which is then a bundle itself, and return their names.

    InputError where a member is not as it was written, OutputError for a folder that holds something else.
    """
    archive = open_archive(path, MEMBERS, MAPS_PROCESS)
    manifest = read_manifest(archive)
    target = Path(folder)
    check_replaceable(target)
    names = sorted(manifest.members)
    with folder_members(target, MANIFEST, sum(archive.sizes.values())) as opened:
        for name in (*names, MANIFEST):
            content = archive.read_array(name)
            if name != MANIFEST:
                check_fingerprint(archive, manifest, name, content)
            with opened(name, len(content)) as member:
                for start in range(0, len(content), _PART_BYTES):
                    member.write(content[start : start + _PART_BYTES].tobytes())
    return [*names, MANIFEST]


def check_replaceable(target: Path) -> None:
    """Raise OutputError where `target` exists and is not a bundle that this version wrote or could have written."""
    if not os.path.exists(target):  # noqa: PTH110 - Path.exists raises for names that are too long
        return
    try:
        archive = open_archive(target, MEMBERS, MAPS_PROCESS)
        if archive.is_zip or archive.sizes:
            read_manifest(archive)
    except InputError as error:
        problem = f"it exists and cannot be replaced, because {error.problem}"
        raise OutputError(target, problem, "Choose another name") from None


def _contents(material: Material, preview: bytes | None) -> dict[str, Produce]:
    """Producer of each member but the manifest, in the order of writing."""
    contents: dict[str, Produce] = dict(map_members(material))
    if material.directional is not None:
        contents |= directional_members(material.directional)
    if (maps := _pbr_maps(material)) is not None:
        contents |= pbr_members(maps)
    if material.power_law is not None or material.directional is not None:
        contents[VIEWER] = lambda: make_page(material)
    contents[BRDF] = lambda: brdf_json(material).encode()
    if isinstance(measured := material.measured, Table):
        contents[TABLE] = lambda: encode_table(measured)[0]
    if (mask := _mask(material)) is not None:
        contents[MASK] = lambda: encode_png(np.where(mask, np.uint8(255), np.uint8(0)), transfer="linear")
    if material.pbr is None:
        contents[SHADER] = lambda: shader(material).encode()
    contents[PREVIEW] = lambda: preview or swatch(material)
    return contents


def _in_thread(produce: Callable[[], Value], done: float, note: str) -> Steps[Value]:
    """Run `produce`, which releases the interpreter lock, while yielding steps; who cancels does not wait for it.

    Its arrays lie where those of this thread do (`engine.storage.spilling`).
    """
    pool = ThreadPoolExecutor(1)
    try:
        future = pool.submit(copy_context().run, produce)
        yield Step(done, note)
        while wait([future], timeout=0.05).not_done:
            yield Step(done, note)
        return future.result()
    finally:
        pool.shutdown(wait=False)


def _sink(target: Path, size_bytes: int) -> AbstractContextManager[OpenMember]:
    """A function that opens members one after the other; the bundle appears at `target` when the block ends."""
    is_zip = target.suffix.lower() == SUFFIX
    return zip_members(target, size_bytes) if is_zip else folder_members(target, MANIFEST, size_bytes)


def _manifest(
    material: Material, provenance: Mapping[str, Any], figures: Mapping[str, Any], members: dict[str, Member]
) -> Manifest:
    software = {"lightarc": engine.__version__, "numpy": np.__version__, "python": platform.python_version()}
    return Manifest(
        schema_version=_schema_of(material),
        name=material.name,
        brdf=material.brdf,
        sigma=None if material.sigma is None else float(material.sigma),
        elevation_deg=[float(elevation) for elevation in material.elevation_deg],
        units=UNITS,
        software={**software, MAKER: maker()},
        provenance=valid({**provenance, **({CREDITS: material.credits.entries} if material.credits else {})}),
        figures=valid(figures),
        shading_map=shading_map_record(material.shading_map),
        power_law=power_law_record(material.power_law),
        directional=directional_record(material.directional),
        pbr=pbr_record(_pbr_maps(material), None if material.surface is None else material.surface.white),
        mask=None if (mask := _mask(material)) is None else MaskRecord(height_px=mask.shape[0], width_px=mask.shape[1]),
        health=HealthRecord.of(material.health),
        members=members,
    )


#: Entry of the provenance with title, author, licence and source.
CREDITS = "credits"


def _mask(material: Material) -> NDArray[np.bool_] | None:
    """The mask of a material, or else that of its PBR maps."""
    maps = _pbr_maps(material)
    if material.mask is not None or maps is None or maps.mask is None:
        return material.mask
    return np.asarray(maps.mask > 0.0)


def _pbr_maps(material: Material) -> PbrMaps | None:
    """The maps of the one member that a bundle has for them."""
    return material.surface.maps if material.surface is not None else material.pbr


def _schema_of(material: Material) -> Literal[1, 2, 3, 4, 5, 6]:
    maps = _pbr_maps(material)
    if _mask(material) is not None:
        return 6
    if maps is not None and maps.wide is not None:
        return 5
    if material.surface is not None:
        return 4
    if material.pbr is not None:
        return 3
    return 1 if material.directional is None else 2


def _material(archive: Archive, manifest: Manifest) -> Material:
    try:
        maps, white = read_pbr(archive, manifest), manifest.pbr.white_radiance if manifest.pbr is not None else None
        mask = _read_mask(archive, manifest)
        if maps is not None and mask is not None and maps.size == mask.shape:
            maps = replace(maps, mask=mask.astype(np.float32))
        return Material(
            shading_map=read_shading_map(archive, manifest),
            power_law=read_power_law(archive, manifest),
            brdf=manifest.brdf,
            sigma=manifest.sigma,
            elevation_deg=tuple(manifest.elevation_deg),
            name=manifest.name,
            credits=credits_of(manifest.provenance.get(CREDITS)),
            health=manifest.health.restored(),
            measured=_measure(archive, manifest),
            directional=read_directional(archive, manifest),
            pbr=maps if white is None else None,
            surface=SurfaceMaps(maps, white) if maps is not None and white is not None else None,
            mask=mask,
        )
    except ValueError as error:
        raise InputError(archive.path, f"holds a material that cannot be: {error}", "Export the bundle again") from None


def _read_mask(archive: Archive, manifest: Manifest) -> NDArray[np.bool_] | None:
    """The mask of a bundle; None where it holds none."""
    record = manifest.mask
    if record is None:
        return None
    size = record.height_px, record.width_px
    return np.asarray(pixels_member(archive, manifest, MASK, "decode_codes", 1, *size, bits=8, grey=True) > 127)


def _measure(archive: Archive, manifest: Manifest) -> Table | None:
    """The measured BRDF of a bundle; None where it holds none."""
    if TABLE not in manifest.members:
        return None
    content = archive.read(TABLE, SMALL_LIMIT_BYTES)
    check_fingerprint(archive, manifest, TABLE, content)
    return decode_table(content, archive.path)


def _fingerprint_problems(archive: Archive, manifest: Manifest) -> list[str]:
    problems = [f"{name} is not in the manifest." for name in sorted(archive.sizes) if name not in manifest.members]
    problems.remove(f"{MANIFEST} is not in the manifest.")
    for name in sorted(manifest.members):
        limit_bytes = BUNDLE_LIMIT_BYTES if name.endswith(".exr") else SMALL_LIMIT_BYTES
        try:
            check_fingerprint(archive, manifest, name, archive.read_array(name, limit_bytes))
        except InputError as error:
            problems.append(f"{error.problem}.")
    return problems


def _check_brdf(archive: Archive, manifest: Manifest) -> None:
    brdf = json_of(archive.read(BRDF, JSON_LIMIT_BYTES), archive.path, BRDF, archive.process)
    if not isinstance(brdf, dict) or brdf.get("text") != manifest.brdf:
        raise InputError(archive.path, f"{BRDF} contradicts the manifest", "Export the bundle again")


def _check_values(material: Material) -> None:
    """Raise UsageError unless there are maps with finite values; only slices may be negative (noise around black)."""
    maps: dict[str, Maps] = {}
    if material.shading_map is not None:
        maps["the shading map"] = material.shading_map.slices
    if material.power_law is not None:
        maps["the scale"] = material.power_law.scale
        maps["the exponent"] = material.power_law.exponent
        maps["the error map"] = material.power_law.error_map
        if material.power_law.kept is not None:
            maps["the kept tiles"] = material.power_law.kept.slices
    if not maps and material.directional is None and material.pbr is None:
        raise UsageError("the material has neither a shading map nor a power law, a directional map or PBR maps")
    beside = maps or material.directional is not None or material.surface is not None
    if material.pbr is not None and beside:
        raise UsageError("PBR maps replace what comes from photographs: a material has one of them")
    for name, values in maps.items():
        low, high = _extremes(values)
        if not (np.isfinite(low) and np.isfinite(high) and (low >= 0 or name in _MAY_BE_NEGATIVE)):
            raise UsageError(f"{name} has values that are negative or not finite")


def _extremes(values: Maps) -> tuple[float, float]:
    """Smallest and largest value, NaN where one is; parts of mapped maps are let go of one after the other."""
    flat, lows, highs = values.reshape(-1), [], []
    for start in range(0, flat.size, _AT_ONCE):
        lows.append(flat[start : start + _AT_ONCE].min())
        highs.append(flat[start : start + _AT_ONCE].max())
        release(values)
    return float(np.min(lows)), float(np.max(highs))


def _size_estimate(material: Material) -> int:
    """Bytes of all maps before compression."""
    shading_map, power_law = material.shading_map, material.power_law
    size_bytes = shading_map.slices.nbytes if shading_map is not None else 0
    size_bytes += material.measured.values.nbytes if isinstance(material.measured, Table) else 0
    size_bytes += pbr.size_bytes if (pbr := _pbr_maps(material)) is not None else 0
    size_bytes += material.directional.planes.nbytes if material.directional is not None else 0
    return size_bytes + (power_law.size_bytes + power_law.error_map.nbytes if power_law is not None else 0)
