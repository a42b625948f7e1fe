"""Fault 5: thousands of damaged files through every reader (`tests.engine.damage` makes them).

Each gives a result of the right kind or one InputError, in time and within memory. Pixels (or a size) that change
without a word are a failure wherever the format could tell: PNG has a checksum on everything, deflate in TIFF and
OpenEXR one on the pixels, bundles a fingerprint of each member. These cannot tell, and there only the kind of the
result is looked at: JPEG, uncompressed TIFF, LZW, PackBits, Zstandard without its checksum, OpenEXR that is not
deflated (DWAA in part), Radiance, uncompressed DNG, all meshes, `.npy`, and text.
A cut file is never taken for a whole one, except OBJ and what ends in text, where the cut may go through a number.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
import math
import struct
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
import OpenEXR
import pytest
import tifffile
import trimesh

from engine.bundle.bundle import open_bundle, save_bundle
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.capture_file import CaptureFile, read_capture_file
from engine.capture.lights.light_positions import read_light_positions
from engine.capture.lights.sources import find
from engine.capture.stack import CODES, RADIANCE, RECORD, SATURATED, open_stack
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images import encode
from engine.simulate.camera import Levels, dng_bytes
from engine.storage import untrusted
from engine.storage.untrusted import decode_content
from tests.engine.damage import (
    COUNT,
    MEMORY_LIMIT_BYTES,
    ROUNDS,
    TIME_LIMIT_S,
    Damage,
    decoder_pids,
    find_damaged,
    peak_memory_bytes,
)
from tests.engine.scenes import weave
from tests.kept import keep

#: Flips of +1, -2, +1 at equal distances leave an Adler-32, the checksum of deflate, as it was: one met in 20000 files,
#: so that a round of a campaign may hold one.
ADLER = {"tiff-zlib", "exr-zip", "exr-pxr24", "exr-tiles"}

HEIGHT, WIDTH = 12, 16
RANDOM = np.random.default_rng(5)
NOISE = RANDOM.integers(0, 256, (HEIGHT, WIDTH, 3)).astype(np.uint8)
SMOOTH = cv2.resize(NOISE[:6, :8], (48, 32), interpolation=cv2.INTER_CUBIC)
FLOATS = cv2.resize(RANDOM.random((3, 4, 3)), (WIDTH, HEIGHT)).round(2).astype(np.float32)

PHOTOGRAPH = (
    "engine.capture.photograph.decode:decode_photograph",
    {"white_balance": "camera", "transfer": "auto", "half_size": False},
)
MESH: Any = ("engine.geometry.mesh:decode_mesh", {})


class Kind(NamedTuple):
    """A file format under test.

    `make` makes a good file, which is read under `name`; `header` gives the bytes of its header, `noticed` those under
    a checksum. Its image is padded to a multiple of `block`; any size within the padding is as good as the original.
    """

    make: Callable[[], bytes]
    name: str
    header: Callable[[bytes], tuple[int, int]]
    noticed: Callable[[bytes], tuple[int, int]] | None = None
    block: int = 1


@pytest.fixture(autouse=True, scope="module")
def fresh_decoder() -> None:
    """Reset the decoder, so that memory held from earlier tests is not counted."""
    untrusted.stop_children()


def up_to(mark: bytes) -> Callable[[bytes], tuple[int, int]]:
    return lambda good: (0, good.index(mark) + len(mark))


def first(length: int) -> Callable[[bytes], tuple[int, int]]:
    return lambda good: (0, length)


def whole(good: bytes) -> tuple[int, int]:
    return 0, len(good)


def tiff_pixels(good: bytes) -> tuple[int, int]:
    with tifffile.TiffFile(io.BytesIO(good)) as file:
        page = file.pages[0]
        return page.dataoffsets[0], page.dataoffsets[-1] + page.databytecounts[-1]


def tiff_header(good: bytes) -> tuple[int, int]:
    return 0, tiff_pixels(good)[0]


def exr_header(good: bytes) -> tuple[int, int]:
    """The attributes and the table of chunks, which the first chunk follows."""
    return 0, good.index((0).to_bytes(4, "little"), good.index(b"screenWindowWidth") + 32)


def exr_pixels(good: bytes) -> tuple[int, int]:
    return exr_header(good)[1], len(good)


def tiff(samples: np.ndarray, **options: Any) -> Callable[[], bytes]:
    def make() -> bytes:
        stream = io.BytesIO()
        tifffile.imwrite(stream, samples, photometric="rgb", metadata=None, **options)
        return stream.getvalue()

    return make


def exr(compression: Any, **header: Any) -> Callable[[], bytes]:
    def make() -> bytes:
        stream = io.BytesIO()
        channels = {name: np.ascontiguousarray(FLOATS[..., index]) for index, name in enumerate("RGB")}
        OpenEXR.File({"type": OpenEXR.scanlineimage, "compression": compression, **header}, channels).write(stream)
        return stream.getvalue()

    return make


def tiles() -> Any:
    description = OpenEXR.TileDescription()
    description.xSize = description.ySize = 8
    return description


def encode_image(suffix: str, pixels: np.ndarray, *options: int) -> Callable[[], bytes]:
    return lambda: cv2.imencode(suffix, pixels, list(options))[1].tobytes()


def mesh(**options: Any) -> Callable[[], bytes]:
    def make() -> bytes:
        content = trimesh.creation.icosphere(subdivisions=0).export(**options)
        return content if isinstance(content, bytes) else content.encode()

    return make


IMAGES = {
    "jpeg": Kind(encode_image(".jpg", SMOOTH), "a.jpg", up_to(b"\xff\xda"), block=16),
    "jpeg-progressive": Kind(
        encode_image(".jpg", SMOOTH, cv2.IMWRITE_JPEG_PROGRESSIVE, 1), "a.jpg", up_to(b"\xff\xda"), block=16
    ),
    "jpeg-restart": Kind(
        encode_image(".jpg", SMOOTH, cv2.IMWRITE_JPEG_RST_INTERVAL, 2), "a.jpg", up_to(b"\xff\xda"), block=16
    ),
    "png-8": Kind(lambda: encode.encode_png(NOISE), "a.png", up_to(b"IDAT"), whole),
    "png-16": Kind(lambda: encode.encode_png(NOISE.astype(np.uint16) * 257), "a.png", up_to(b"IDAT"), whole),
    "tiff-strips": Kind(tiff(NOISE, rowsperstrip=4), "a.tif", tiff_header),
    "tiff-tiles": Kind(tiff(NOISE, tile=(16, 16), bigtiff=True), "a.tif", tiff_header, block=16),
    "tiff-float": Kind(tiff(FLOATS, rowsperstrip=4), "a.tif", tiff_header),
    "tiff-zlib": Kind(tiff(NOISE, compression="zlib", rowsperstrip=4), "a.tif", tiff_header, tiff_pixels),
    "tiff-zstd": Kind(tiff(NOISE, compression="zstd", rowsperstrip=4), "a.tif", tiff_header),
    "tiff-lzw": Kind(tiff(NOISE, compression="lzw", rowsperstrip=4), "a.tif", tiff_header),
    "tiff-packbits": Kind(tiff(NOISE, compression="packbits", rowsperstrip=4), "a.tif", tiff_header),
    "tiff-jpeg": Kind(tiff(SMOOTH, compression="jpeg", rowsperstrip=16), "a.tif", tiff_header),
    "exr-none": Kind(exr(OpenEXR.NO_COMPRESSION), "a.exr", exr_header),
    "exr-zip": Kind(exr(OpenEXR.ZIP_COMPRESSION), "a.exr", exr_header, exr_pixels),
    "exr-pxr24": Kind(exr(OpenEXR.PXR24_COMPRESSION), "a.exr", exr_header, exr_pixels),
    "exr-piz": Kind(exr(OpenEXR.PIZ_COMPRESSION), "a.exr", exr_header),
    "exr-dwaa": Kind(exr(OpenEXR.DWAA_COMPRESSION), "a.exr", exr_header),
    "exr-tiles": Kind(
        exr(OpenEXR.ZIP_COMPRESSION, type=OpenEXR.tiledimage, tiles=tiles()), "a.exr", exr_header, exr_pixels
    ),
    "hdr": Kind(encode_image(".hdr", FLOATS), "a.hdr", up_to(b"+X 16\n")),
}


def polygons(order: str) -> Callable[[], bytes]:
    """A binary PLY of the triangles, squares and hexagon of half a cuboctahedron, which differ in size."""
    name = {"<": "little", ">": "big"}[order]

    def make() -> bytes:
        turn = np.arange(6) * math.pi / 3
        ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
        points = np.concatenate([ring, ring[::2] / math.sqrt(3) + (0, 0, math.sqrt(2 / 3))]).astype(order + "f4")
        faces = (
            (0, 1, 2, 3, 4, 5),
            (6, 7, 8),
            (0, 1, 7, 6),
            (2, 3, 8, 7),
            (4, 5, 6, 8),
            (1, 2, 7),
            (3, 4, 8),
            (5, 0, 6),
        )
        header = f"ply\nformat binary_{name}_endian 1.0\nelement vertex 9\n" + "".join(
            f"property float {axis}\n" for axis in "xyz"
        )
        header += "element face 8\nproperty list uchar ushort vertex_indices\nend_header\n"
        lists = (struct.pack(f"{order}B{len(face)}H", len(face), *face) for face in faces)
        return header.encode() + points.tobytes() + b"".join(lists)

    return make


def gltf() -> bytes:
    """One file with its numbers inside."""
    files = trimesh.creation.icosphere(subdivisions=0).scene().export(file_type="gltf")
    tree = json.loads(files.pop("model.gltf"))
    for buffer in tree["buffers"]:
        buffer["uri"] = "data:;base64," + base64.b64encode(files[buffer["uri"]]).decode()
    return json.dumps(tree).encode()


MESHES = {
    "obj": Kind(mesh(file_type="obj"), "a.obj", whole),
    "off": Kind(mesh(file_type="off"), "a.off", whole),
    "ply": Kind(mesh(file_type="ply"), "a.ply", up_to(b"end_header\n")),
    "ply-polygons": Kind(polygons("<"), "a.ply", up_to(b"end_header\n")),
    "ply-big-endian": Kind(polygons(">"), "a.ply", up_to(b"end_header\n")),
    "ply-ascii": Kind(mesh(file_type="ply", encoding="ascii"), "a.ply", whole),
    "stl": Kind(mesh(file_type="stl"), "a.stl", first(84)),
    "stl-ascii": Kind(mesh(file_type="stl_ascii"), "a.stl", whole),
    "glb": Kind(mesh(file_type="glb"), "a.glb", up_to(b"BIN\0")),
    "gltf": Kind(gltf, "a.gltf", whole),
}

#: Text in which a cut may leave a shorter file that is valid.
OPEN_ENDED = {"obj", "off", "ply-ascii"}


class Outcome(NamedTuple):
    """`refusal` or `reply`, None for the other; most memory that a decoder held so far."""

    reply: dict[str, Any] | None
    refusal: InputError | None
    held_bytes: int


def decode(decoder: tuple[str, dict[str, Any]], name: str, content: bytes) -> Outcome:
    """One damaged file through a child.

    Where that takes too long, the child may have been a new one that had its modules to load: it gets the time for
    that, and then a second chance.
    """
    for timeout_s in (TIME_LIMIT_S, 60.0, TIME_LIMIT_S):
        try:
            reply = decode_content(decoder[0], name, content, timeout_s=timeout_s, **decoder[1])
            refusal = None
        except InputError as error:
            reply, refusal = None, error
        if timeout_s == TIME_LIMIT_S and (refusal is None or "within" not in refusal.problem):
            break
    held_bytes = max(map(peak_memory_bytes, decoder_pids()), default=0)
    return Outcome(reply, refusal, held_bytes)


def assert_refused_in_words(refusal: InputError, what: str) -> None:
    assert refusal.path, what
    assert refusal.problem, what
    assert refusal.remedy, what
    assert "\n" not in str(refusal), what
    assert "could not be decoded within" not in refusal.problem, f"{what} takes more than {TIME_LIMIT_S} s"


def each_damaged(
    kind: str, one: Kind, decoder: tuple[str, dict[str, Any]], check: Callable[..., None], seed: int
) -> float:
    """Decode all damaged files of `kind`, let `check` look at each that passes, and return the part that was refused.

    A decoder in C may crash now and then (imagecodecs' LZW does): its process is there to be lost, and replaced.
    """
    good = one.make()
    pristine = decode_content(decoder[0], one.name, good, **decoder[1])
    allowed_bytes = max(map(peak_memory_bytes, decoder_pids())) + MEMORY_LIMIT_BYTES
    refused = crashed = 0
    damages = list(find_damaged(good, one.header(good), seed=seed))
    with ThreadPoolExecutor(untrusted.CHILDREN) as pool:
        outcomes = pool.map(lambda damage: decode(decoder, one.name, damage.content), damages)
        for number, (damage, outcome) in enumerate(zip(damages, outcomes, strict=True)):
            what = f"{kind} file {number} ({damage.what} at {damage.first})"
            with keep(one.name, damage.content):
                assert outcome.held_bytes <= allowed_bytes, f"{what} or one before takes {outcome.held_bytes >> 20} MiB"
                if outcome.refusal is not None:
                    refused += 1
                    crashed += "crashed" in outcome.refusal.problem
                    assert_refused_in_words(outcome.refusal, what)
                else:
                    check(outcome.reply, pristine, damage, what)
    assert crashed <= max(1, len(damages) // 100)
    return refused / len(damages)


def says_more(reply: dict[str, Any], pristine: dict[str, Any]) -> bool:
    return not set(reply["warnings"]) <= set(pristine["warnings"])


def check_image(reply: dict[str, Any], pristine: dict[str, Any], damage: Damage, what: str, block: int = 1) -> None:
    radiance, saturated = reply["radiance"], reply["saturated"]
    height, width = saturated.shape
    assert radiance.shape == (height, width, 3), what
    assert (radiance.dtype, saturated.dtype) == (np.float32, np.bool_), what
    sizes = ((height, width), pristine["saturated"].shape)
    same_size = len({tuple(sorted(math.ceil(side / block) for side in size)) for size in sizes}) == 1
    assert same_size or says_more(reply, pristine), f"{what} silently changes the size"
    assert np.isfinite(radiance).all(), what
    if damage.what == "cut":
        assert np.array_equal(radiance, pristine["radiance"]), f"{what} gives part of the image"


@pytest.mark.campaign(rounds=ROUNDS)
@pytest.mark.parametrize("kind", IMAGES)
def test_fault5_damaged_images(kind: str, seed: int) -> None:
    one = IMAGES[kind]
    noticed = one.noticed(one.make()) if one.noticed else (0, 0)
    slipped: list[str] = []

    def check(reply: dict[str, Any], pristine: dict[str, Any], damage: Damage, what: str) -> None:
        check_image(reply, pristine, damage, what, one.block)
        if noticed[0] <= damage.first and damage.last <= noticed[1] and not says_more(reply, pristine):
            slipped.extend([what] * (not np.array_equal(reply["radiance"], pristine["radiance"])))

    assert each_damaged(kind, one, PHOTOGRAPH, check, seed) > 1 / 8
    assert len(slipped) <= (seed > 0 and kind in ADLER), f"{slipped} get past the checksum"


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault5_damaged_raw(seed: int) -> None:
    mosaic = RANDOM.integers(600, 16000, (40, 40)).astype(np.uint16)
    one = Kind(lambda: dng_bytes(mosaic, Levels(), exposure_s=0.02), "a.dng", lambda good: (mosaic.nbytes, len(good)))
    assert each_damaged("dng", one, PHOTOGRAPH, check_image, seed) > 1 / 8


@pytest.mark.campaign(rounds=ROUNDS)
@pytest.mark.parametrize("kind", MESHES)
def test_fault5_damaged_meshes(kind: str, seed: int) -> None:
    def check(reply: dict[str, Any], pristine: dict[str, Any], damage: Damage, what: str) -> None:
        positions, faces = reply["positions"], reply["faces"]
        assert positions.shape == reply["normals"].shape == (len(positions), 3), what
        assert reply["uv"].shape == (len(positions), 2), what
        assert all(np.isfinite(reply[name]).all() for name in ("positions", "normals", "uv")), what
        assert faces.shape[1:] == (3,), what
        assert 0 <= faces.min() <= faces.max() < len(positions), what
        if damage.what == "cut" and kind not in OPEN_ENDED:
            assert np.array_equal(positions, pristine["positions"]), f"{what} gives part of the mesh"

    assert each_damaged(kind, MESHES[kind], MESH, check, seed) > 1 / 4


def each_written(
    path: Path, header: tuple[int, int], read: Callable[[], Any], count: int = COUNT, *, seed: int
) -> list[tuple[Damage, Any]]:
    """Read damaged contents of `path`, which stay untouched; a result is None where `read` refuses with a sentence."""
    good = path.read_bytes()
    results = []
    for damage in find_damaged(good, header, count, seed=seed):
        path.write_bytes(damage.content)
        with keep(path.name, damage.content):
            start_s = time.thread_time()
            try:
                result = read()
            except InputError as error:
                assert_refused_in_words(error, str(damage))
                result = None
            assert time.thread_time() - start_s <= TIME_LIMIT_S, damage
            assert path.read_bytes() == damage.content
        results.append((damage, result))
    path.write_bytes(good)
    return results


def _import_two(tmp_path: Path, *, as_codes: bool) -> Path:
    """Two tiny photographs imported."""
    for angle in (30, 60):
        (tmp_path / f"cloth_{angle}deg.png").write_bytes(encode.encode_png(NOISE // (90 // angle)))
    folder = tmp_path / "stack"
    drain(import_stack(find([tmp_path]), ImportSettings(motion="none"), folder, as_codes=as_codes))
    return folder


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault5_damaged_light_positions(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "lights.lp"
    path.write_text("5\n" + "".join(f"photo {n}.jpg 0.6 0.{n} {math.sqrt(0.64 - n * n / 100):.6f}\n" for n in range(5)))
    results = each_written(path, (0, path.stat().st_size), lambda: read_light_positions(path), seed=seed)
    for damage, lights in results:
        for light in lights.lights if lights else ():
            assert 0 <= light.elevation <= math.pi / 2, damage
            assert abs(light.azimuth) <= math.pi, damage
        assert lights is None or damage.what != "cut" or len(lights.lights) == 5, damage
    assert sum(lights is None for _, lights in results) > len(results) // 2


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault5_damaged_capture_files(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "capture.toml"
    entries = (
        f'[[photographs]]\nfile = "woven_{n}.tif"\nelevation_deg = {n}0.0\nexposure_s = 0.5\n' for n in range(1, 5)
    )
    path.write_text('notes = "suede"\ntransfer = "linear"\n\n' + "\n".join(entries))
    results = each_written(path, (0, path.stat().st_size), lambda: read_capture_file(path), seed=seed)
    for damage, capture in results:
        assert capture is None or isinstance(capture, CaptureFile), damage
        for entry in capture.photographs if capture else ():
            assert entry.elevation_deg is None or 0 <= entry.elevation_deg <= 90, damage
            assert entry.exposure_s is None or 0 < entry.exposure_s < math.inf, damage
    assert sum(capture is None for _, capture in results) > len(results) // 2


@pytest.mark.campaign(rounds=ROUNDS)
@pytest.mark.parametrize("member", [RECORD, CODES, RADIANCE, SATURATED])
def test_fault5_damaged_stacks(member: str, tmp_path: Path, seed: int) -> None:
    stack_folder = _import_two(tmp_path, as_codes=member in (RECORD, CODES))
    pristine = open_stack(stack_folder)
    path = stack_folder / member
    header = (0, path.stat().st_size if member == RECORD else 128)

    def check() -> bool:
        stack = open_stack(stack_folder)
        assert stack.radiance.shape == pristine.radiance.shape
        assert stack.saturated.shape == pristine.saturated.shape
        assert np.isfinite(stack.mean_radiance).all()
        assert ((stack.elevation >= 0) & (stack.elevation <= math.pi / 2)).all()
        return True

    results = each_written(path, header, check, seed=seed)
    assert all(result is None for damage, result in results if damage.what == "cut")
    in_header = [result for damage, result in results if damage.last <= header[1]]
    assert member == RECORD or not any(in_header)
    assert sum(result is None for _, result in results) > len(results) // 3


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault5_damaged_bundles(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "weave.lightarc"
    drain(save_bundle(path, weave(size=8, slices=3)))
    content = path.read_bytes()
    directory = content.index(b"PK\1\2")

    def check() -> str:
        material = open_bundle(path)
        assert material.shading_map is not None
        assert material.power_law is not None
        arrays = (material.shading_map.slices, material.power_law.scale, material.power_law.exponent)
        return hashlib.sha256(b"".join(array.tobytes() for array in arrays) + repr(material.name).encode()).hexdigest()

    pristine = check()
    results = each_written(path, (directory, len(content)), check, seed=seed)
    assert {result for _, result in results} <= {None, pristine}
    assert sum(result is None for _, result in results) > len(results) // 2
