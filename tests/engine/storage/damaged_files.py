"""Damaged files of every format that the program reads, by seed and in bulk.

    python -m tests.engine.storage.damaged_files SEED COUNT

File number N is of format N modulo the number of formats and made by a generator with the seed N, so that COUNT 1
repeats one. Half of the damages know the structure of the file: chunks with right checksums, entries of directories,
attributes, values of JSON under a right seal, numbers of text. The others are those of `tests.engine.damage`.

Formats that are decoded in the child are damaged there too, hundreds in one request, by the same code that answers for
one file (`decoder_child._answer`); a process that ends is replaced and the file found that ended it. Formats of records
and archives go through their readers in this process. A fault is an exception other than a LightarcError, a result that
cannot be, a hang, or memory of more than 512 MB beyond that of the good files.
"""

from __future__ import annotations

import base64
import contextlib
import io
import json
import math
import os
import random
import re
import resource
import shutil
import sys
import tarfile
import tempfile
import time
import warnings
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from engine.core.errors import InputError, LightarcError
from engine.core.steps import drain
from engine.geometry.usd import has_library
from engine.images.encode import encode_png
from engine.simulate.camera import Levels, dng_bytes
from engine.storage import decoder_child, untrusted
from engine.storage.records import seal
from tests.engine.brdf.readers.tensor_files import fields_of, tensor_bytes
from tests.engine.brdf.readers.test_damaged_samples import FILES as SAMPLES
from tests.engine.damage import MEMORY_LIMIT_BYTES, TIME_LIMIT_S, _damage
from tests.engine.storage import damaged_usd
from tests.engine.storage.test_damage import IMAGES, MESHES, NOISE, tiff

Random = random.Random
Span = tuple[int, int]

#: Files of one format that a child damages in one request.
BATCH = 100
#: Seconds after which a file counts as one that hangs.
HANG_S = 60.0

#: CPU seconds of a file that a library reads which is not ours.
LIBRARY_LIMIT_S = 10.0

INTEGERS = (0, 1, 2, 3, 255, 256, 32767, 32768, 65535, 65536, 2**31 - 1, 2**31, 2**32 - 1, 2**32, 2**63 - 1, 2**64 - 1)
NUMBERS = (
    *("0", "-1", "1e400", "-1e400", "nan", "inf", "-inf", "1e-320", "9" * 5000, "²", "٣", "0x10", "1_0", "+5", "1e5"),
    *("2147483648", "4294967295", "18446744073709551616", "", ".", "-", "1.", "1e", "0" * 4000 + "1", "1,5", "\0"),
)
VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1.5, 1e308, -1e308, 2**63, 2**200, "", "x" * 5000, "²", "\ud800", "../../etc/passwd"),
    *([], {}, [[]], [None], {"": 0}, [0] * 2000, [1e308, -1e308], "nan", [[1, 2], [3]]),
)


# Structures: the spans of a file that are elements of its format, and what makes its checksums right again.


def _png(content: bytes) -> list[Span]:
    spans, at = [(0, 8)], 8
    while at + 12 <= len(content):
        end = at + 12 + int.from_bytes(content[at : at + 4], "big")
        spans.append((at, min(end, len(content))))
        at = end
    return spans


def _mended_png(content: bytes) -> bytes:
    fixed = bytearray(content)
    for start, end in _png(content)[1:]:
        fixed[end - 4 : end] = zlib.crc32(content[start + 4 : end - 4]).to_bytes(4, "big")
    return bytes(fixed)


def _jpeg(content: bytes) -> list[Span]:
    spans, at = [(0, 2)], 2
    while at + 4 <= len(content) and content[at] == 0xFF:
        end = at + 2 + int.from_bytes(content[at + 2 : at + 4], "big")
        spans.append((at, min(end, len(content))))
        if content[at + 1] == 0xDA:
            break
        at = end
    return spans


def _tiff(content: bytes) -> list[Span]:
    order: Any = "little" if content[:2] == b"II" else "big"
    big = content[2 if order == "little" else 3] == 43
    at = int.from_bytes(content[8:16] if big else content[4:8], order)
    head, entry = (8, 20) if big else (2, 12)
    count = int.from_bytes(content[at : at + head], order)
    spans = [(0, 16 if big else 8), (at, at + head)]
    return spans + [(at + head + entry * n, at + head + entry * (n + 1)) for n in range(min(count, 200))]


def _exr(content: bytes) -> list[Span]:
    spans, at = [(0, 8)], 8
    while content[at : at + 1] not in (b"\0", b""):
        kind = content.index(b"\0", at) + 1
        size = content.index(b"\0", kind) + 1
        end = size + 4 + int.from_bytes(content[size : size + 4], "little")
        spans.append((at, end))
        at = end
    return [*spans, (at + 1, min(at + 33, len(content)))]


def _zip(content: bytes) -> list[Span]:
    starts = [found.start() for found in re.finditer(rb"PK(\x01\x02|\x03\x04|\x05\x06|\x06\x06|\x06\x07)", content)]
    return [(start, min(start + 60, end)) for start, end in zip(starts, [*starts[1:], len(content)], strict=True)]


def _glb(content: bytes) -> list[Span]:
    text = 20 + int.from_bytes(content[12:16], "little")
    return [(0, 12), (12, 20), (20, text), (text, text + 8), (text + 8, len(content))]


def _lines(content: bytes) -> list[Span]:
    ends = [found.end() for found in re.finditer(rb"\n|[{}\[\],;>]|\Z", content)]
    return list(zip([0, *ends], ends, strict=False))


def _blocks(content: bytes) -> list[Span]:
    return [(at, min(at + 16, len(content))) for at in range(0, min(len(content), 2048), 16)]


def _whole(content: bytes) -> bytes:
    return content


def _element(content: bytes, spans: list[Span], rng: Random) -> bytes:
    """One element is missing, there twice, elsewhere, cut, or has another number in it."""
    start, end = rng.choice(spans)
    other = rng.choice(spans)
    element = content[start:end]
    kind = rng.randrange(9)
    if kind == 0:
        element = b""
    elif kind == 1:
        element *= rng.choice((2, 3, 1000))
    elif kind == 2:
        element = content[other[0] : other[1]]
    elif kind == 3:
        element = element[: rng.randrange(len(element) + 1)]
    elif element:
        width = rng.choice((1, 2, 4, 8))
        at = rng.randrange(len(element))
        value = rng.choice((*INTEGERS, len(content), rng.randrange(2**32))) % (1 << 8 * width)
        element = element[:at] + value.to_bytes(width, rng.choice(("little", "big"))) + element[at + width :]
    return content[:start] + element + content[end:]


def _number(content: bytes, rng: Random) -> bytes:
    """One number of a text is another."""
    found = list(re.finditer(rb"-?\d[\d.]*(?:[eE][-+]?\d+)?", content[: 1 << 16]))
    if not found:
        return content
    one = rng.choice(found)
    return content[: one.start()] + rng.choice(NUMBERS).encode() + content[one.end() :]


def changed_value(value: Any, rng: Random) -> Any:
    """Return JSON with one value in it replaced, removed, added or nested."""
    if rng.random() < 0.3 or not isinstance(value, (dict, list)) or not value:
        if isinstance(value, (int, float)) and not isinstance(value, bool) and rng.random() < 0.6:
            return rng.choice((0, -1, value + 1, -value, value * 2**31, 1e300, 0.5, 2**53 + 1))
        return rng.choice(VALUES)
    if isinstance(value, list):
        at = rng.randrange(len(value))
        kind = rng.randrange(4)
        if kind == 0:
            return [*value[:at], *value[at + 1 :]]
        if kind == 1:
            return [*value, value[at]]
        return [*value[:at], changed_value(value[at], rng), *value[at + 1 :]]
    key = rng.choice(sorted(value))
    kind = rng.randrange(8)
    if kind == 0:
        return {name: each for name, each in value.items() if name != key}
    if kind == 1:
        return {**value, rng.choice(("", "x", "__proto__", key + "²")): rng.choice(VALUES)}
    return {**value, key: changed_value(value[key], rng)}


def _json(content: bytes, rng: Random) -> bytes:
    text = json.dumps(changed_value(json.loads(content), rng))
    if rng.random() < 0.05:
        text = text.replace("[", "[" * 3000, 1)
    return text.encode()


class Format(NamedTuple):
    """A format: its good files, the spans of their elements, and what reads them.

    `decoder` and `options` are those of `decode_content`; `read` reads a path in this process instead. `mended` makes
    checksums right; `extra` is a further damage that knows the format. Of `as_files` the decoder gets a folder, for a
    library that opens files by their paths.
    """

    name: str
    good: Callable[[], bytes]
    spans: Callable[[bytes], list[Span]] = _blocks
    decoder: str = ""
    options: dict[str, Any] = {}  # noqa: RUF012
    read: Callable[[Path], Any] | None = None
    mended: Callable[[bytes], bytes] = _whole
    extra: Callable[[bytes, Random], bytes] | None = None
    as_files: bool = False


def find_damaged(one: Format, good: bytes, number: int) -> bytes:
    """The damaged file of a number."""
    rng = Random(number)
    content = good
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        kind = rng.random()
        if kind < 0.35 and len(content) > 1:
            header = (0, max(1, min(len(content), 600)))
            content = _damage(content, header, np.random.default_rng(rng.getrandbits(32))).content
        elif kind < 0.45 and len(content) > 1:
            content = content[: rng.randrange(1, len(content))]
        elif kind < 0.75 or one.extra is None:
            with contextlib.suppress(ValueError, IndexError):
                content = _element(content, one.spans(content), rng)
        else:
            with contextlib.suppress(ValueError, IndexError, KeyError, TypeError, AttributeError, RecursionError):
                content = one.extra(content, rng)
        if not content:
            content = b"\0"
    return one.mended(content) if rng.random() < 0.8 else content


# Good files.


def _dng() -> bytes:
    mosaic = np.random.default_rng(5).integers(600, 16000, (40, 40)).astype(np.uint16)
    return dng_bytes(mosaic, Levels(), exposure_s=0.02)


def _lp() -> bytes:
    lines = "".join(f"photo {n}.jpg 0.6 0.{n} {math.sqrt(0.64 - n * n / 100):.6f}\n" for n in range(5))
    return f"5\n{lines}".encode()


def _dome() -> bytes:
    directions = [{"x": 0.6, "y": n / 10, "z": 0.7} for n in range(5)]
    dome = {"directions": directions, "lightConfiguration": "spherical", "domeDiameter": 60, "imageWidth": 20}
    return json.dumps(dome).encode()


def _toml() -> bytes:
    entries = (
        f'[[photographs]]\nfile = "woven_{n}.tif"\nelevation_deg = {n}0.0\nexposure_s = 0.5\n' for n in range(1, 5)
    )
    return ('notes = "suede"\ntransfer = "linear"\n\n' + "\n".join(entries)).encode()


def _table() -> bytes:
    from engine.brdf.readers.table_file import encode_table
    from tests.engine.brdf.test_table import direction_table

    return encode_table(direction_table(columns=3))[0]


def _tensors() -> bytes:
    rng = np.random.default_rng(3)
    fields = fields_of(
        np.array([0.0]), np.linspace(0.0, 1.4, 3), vndf=rng.random((1, 3, 4, 4)), values=rng.random((1, 3, 3, 4, 4))
    )
    return tensor_bytes(fields)


def _mtlx() -> bytes:
    return b"""<?xml version="1.0"?>
<materialx version="1.39" colorspace="lin_rec709">
  <nodegraph name="g">
    <image name="b" type="color3">
      <input name="file" type="filename" value="base.png" colorspace="srgb_texture"/>
    </image>
    <multiply name="tinted" type="color3">
      <input name="in1" type="color3" nodename="b"/><input name="in2" type="color3" value="0.5, 0.25, 1"/>
    </multiply>
    <invert name="rough" type="float"><input name="in" type="float" nodename="b" output="outg"/></invert>
    <output name="base_out" type="color3" nodename="tinted"/>
    <output name="rough_out" type="float" nodename="rough"/>
  </nodegraph>
  <standard_surface name="shader" type="surfaceshader">
    <input name="base_color" type="color3" nodegraph="g" output="base_out"/>
    <input name="specular_roughness" type="float" nodegraph="g" output="rough_out"/>
    <input name="specular_IOR" type="float" value="2"/>
  </standard_surface>
  <surfacematerial name="paint" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="shader"/>
  </surfacematerial>
</materialx>
"""


def _gltf_material() -> bytes:
    texture = base64.b64encode(encode_png(NOISE[:4, :4])).decode()
    tree = {
        "asset": {"version": "2.0"},
        "images": [{"uri": f"data:image/png;base64,{texture}"}, {"uri": "base.png"}],
        "textures": [{"source": 0}, {"source": 1}],
        "materials": [
            {
                "name": "paint",
                "pbrMetallicRoughness": {
                    "baseColorTexture": {"index": 0},
                    "metallicRoughnessTexture": {"index": 1},
                    "roughnessFactor": 0.5,
                },
                "extensions": {"KHR_materials_ior": {"ior": 1.4}},
            }
        ],
    }
    return json.dumps(tree).encode()


def _zip_of_textures() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        for name in ("rock_color.png", "rock_roughness.png", "rock_normalgl.png"):
            packed.writestr(f"rock/{name}", encode_png(NOISE[:4, :4]))
    return stream.getvalue()


def _zip_of_photographs() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as packed:
        for angle in (20, 50, 80):
            packed.writestr(f"cloth/cloth_{angle}deg.png", encode_png(NOISE))
        packed.writestr("cloth/notes.txt", "suede\n" * 100)
    return stream.getvalue()


def _tar(mode: str) -> bytes:
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode=mode) as packed:  # type: ignore[call-overload]
        for angle in (20, 50, 80):
            content = encode_png(NOISE)
            entry = tarfile.TarInfo(f"cloth/cloth_{angle}deg.png")
            entry.size = len(content)
            packed.addfile(entry, io.BytesIO(content))
    return stream.getvalue()


@cache
def _place() -> Path:
    """A folder of this process, in memory where the system has that."""
    shared = "/dev/shm"
    return Path(tempfile.mkdtemp(prefix="damaged-", dir=shared if os.path.isdir(shared) else None))  # noqa: PTH112


@cache
def _make(kind: str) -> Path:
    """A good stack, bundle, transport or folder of factors."""
    place = _place() / f"good-{kind}"
    if kind in ("stack", "codes"):
        from engine.capture.import_stack import ImportSettings, import_stack
        from engine.capture.lights.sources import find

        photographs = _place() / f"photographs-{kind}"
        photographs.mkdir()
        for angle in (30, 60):
            (photographs / f"cloth_{angle}deg.png").write_bytes(encode_png(NOISE // (90 // angle)))
        drain(import_stack(find([photographs]), ImportSettings(motion="none"), place, as_codes=kind == "codes"))
    elif kind == "lit":
        from engine.capture.import_stack import ImportSettings, import_stack
        from engine.capture.lights.sources import find
        from tests.engine.capture.calibration.generated import Capture, render, write

        lit = Capture(seed=8, file_format="jpg", lamps=18, height=48, width=56, room=0.15, distance=4.0)
        photographs = write(render(lit), _place() / "photographs-lit")
        drain(import_stack(find([photographs]), ImportSettings(), place))
    elif kind == "bundle":
        from engine.bundle.bundle import save_bundle
        from tests.engine.scenes import weave

        drain(save_bundle(place, weave(size=8, slices=3)))
    elif kind == "factors":
        from engine.brdf.brdf import brdf_from_text
        from engine.factor.factor import factor
        from engine.factor.factor_file import write_factors
        from engine.factor.settings import FactorSettings

        settings = FactorSettings(samples=300, side=8, products=1)
        write_factors(place, drain(factor(brdf_from_text("lambert"), settings)))
    else:
        from tests.engine.transport.baking import test_file

        test_file.write(place)
    return place


def _record(kind: str, name: str) -> bytes:
    return (_make(kind) / name).read_bytes()


def _mended_seal(key: str, content: bytes) -> bytes:
    """A record of JSON with the seal that its values have."""
    try:
        value = {name: each for name, each in json.loads(content).items() if name != key}
        return json.dumps({**value, key: seal(value)}).encode()
    except (ValueError, AttributeError, RecursionError):
        return content


def _beside(kind: str, name: str, read: Callable[[Path], Any]) -> Callable[[Path], Any]:
    """Reads a good folder in which one file is the damaged one."""

    def read_folder(path: Path) -> Any:
        folder = path.parent / kind
        if not folder.is_dir():
            shutil.copytree(_make(kind), folder)
        good = folder / name
        kept = good.read_bytes()
        shutil.copy(path, good)
        try:
            return read(folder)
        finally:
            good.write_bytes(kept)

    return read_folder


def _open_stack(folder: Path) -> None:
    from engine.capture.stack import open_stack

    stack = open_stack(folder)
    assert np.isfinite(stack.mean_radiance).all()
    assert np.isfinite(np.asarray(stack.radiance[:1])).all()
    assert ((stack.elevation >= 0) & (stack.elevation <= math.pi / 2)).all()


def _open_bundle(path: Path) -> None:
    from engine.bundle.bundle import open_bundle
    from engine.bundle.manifest import describe_bundle

    with contextlib.suppress(LightarcError):
        describe_bundle(path)
    material = open_bundle(path)
    assert material.shading_map is None or np.isfinite(material.shading_map.slices).all()


def _open_bundle_file(path: Path) -> None:
    _open_bundle(Path(shutil.copy(path, path.with_suffix(".lightarc"))))


def _zip_bundle() -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        for path in sorted(_make("bundle").rglob("*")):
            if path.is_file():
                packed.write(path, path.relative_to(_make("bundle")).as_posix())
    return stream.getvalue()


def _open_factors(path: Path) -> None:
    from engine.factor.factor_file import read_factors

    read_factors(path)


def _transport_file() -> bytes:
    return _make("transport").read_bytes()


def _open_transport(path: Path) -> None:
    from engine.transport.baking.file import open_transport

    open_transport(path)


def _open_material(path: Path) -> None:
    from engine.exchange.readers.read import open_material

    image = path.parent / "base.png"
    if not image.exists():
        image.write_bytes(encode_png(NOISE[:4, :4]))
    material = open_material(path)
    assert material.pbr is None or all(
        np.isfinite(getattr(material.pbr, name)).all() for name in ("base_colour", "normal", "roughness", "f0")
    )


def _read_brdf(path: Path) -> None:
    from engine.brdf.readers.read import read_measurement

    read_measurement(path)


def _unpack(path: Path) -> None:
    from engine.storage.unpack import unpack, zip_names

    folder = path.parent / "unpacked"
    folder.mkdir()
    try:
        if path.suffix == ".zip":
            zip_names(path)
        drain(unpack(path, folder, lambda names: [name for name in names if name.endswith((".png", ".txt"))]))
        assert all(each.is_file() and not each.is_symlink() for each in folder.iterdir())
    finally:
        shutil.rmtree(folder)


def _recognise(path: Path) -> None:
    from app.commands.recognise import recognise

    recognise([path])


_PHOTOGRAPH = "engine.capture.photograph.decode:decode_photograph"
_PHOTOGRAPH_OPTIONS = {"white_balance": "camera", "transfer": "auto", "half_size": False}
_IMAGE_OPTIONS = {"transfer": "auto", "half_size": False}
_SPANS = {"jpeg": _jpeg, "png": _png, "tiff": _tiff, "exr": _exr, "hdr": _lines}
_LIGHTS = "engine.capture.lights"


def _images() -> Iterator[Format]:
    for kind, one in IMAGES.items():
        family = kind.partition("-")[0]
        mended = _mended_png if family == "png" else _whole
        yield Format(
            one.name, one.make, _SPANS[family], _PHOTOGRAPH, _PHOTOGRAPH_OPTIONS, mended=mended
        )  # as photographs
        decoder = "engine.images.decode:decode"
        if kind in ("jpeg", "png-16", "tiff-tiles", "exr-piz", "hdr"):
            yield Format(one.name, one.make, _SPANS[family], decoder, _IMAGE_OPTIONS, mended=mended)
    yield Format("a.dng", _dng, _tiff, _PHOTOGRAPH, _PHOTOGRAPH_OPTIONS)
    yield Format("a.dng", _dng, _tiff, "engine.capture.photograph.decode:decode_exposure")
    yield Format("a.exr", _table, _exr, "engine.images.exr:read_exr_channels")
    yield Format("a.tif", tiff(NOISE, compression="zlib", predictor=True), _tiff, _PHOTOGRAPH, _PHOTOGRAPH_OPTIONS)


def _meshes() -> Iterator[Format]:
    for kind, one in MESHES.items():
        spans = _glb if kind == "glb" else _blocks if kind == "stl" else _lines
        extra = _json if kind == "gltf" else _number
        yield Format(one.name, one.make, spans, "engine.geometry.mesh:decode_mesh", extra=extra)
    yield Format("a.gltf", MESHES["gltf"].make, _lines, "engine.geometry.mesh:decode_names", extra=_json)


def _lists() -> Iterator[Format]:
    for name, reader in (
        ("paint.brdf", "cornell"),
        ("paint.astm", "cornell"),
        ("paint.dat", "alta"),
        ("paint.csv", "csv"),
    ):
        text = SAMPLES[name][0]
        decoder = "engine.brdf.readers.samples_child:decode_samples"
        options = {"reader": reader, "asked": name}
        yield Format(name, partial(bytes, text, "utf-8"), _lines, decoder, options, extra=_number)
    yield Format("a.lp", _lp, _lines, f"{_LIGHTS}.light_positions:decode_light_positions", extra=_number)
    yield Format("a.dome", _dome, _lines, f"{_LIGHTS}.light_positions:decode_dome", extra=_json)
    yield Format("capture.toml", _toml, _lines, f"{_LIGHTS}.capture_file:decode_capture_file", extra=_number)


def _records() -> Iterator[Format]:
    manifest, record = partial(_mended_seal, "manifest_sha256"), partial(_mended_seal, "sha256")
    bundle, stack = partial(_record, "bundle"), partial(_record, "stack")
    open_bundle, open_stack = _open_bundle, _open_stack
    yield Format(
        "manifest.json",
        partial(bundle, "manifest.json"),
        _lines,
        read=_beside("bundle", "manifest.json", open_bundle),
        mended=manifest,
        extra=_json,
    )
    yield Format("a.zip", _zip_bundle, _zip, read=_open_bundle_file)
    for kind in ("stack", "codes", "lit"):
        name = "stack.json"
        read = _beside(kind, name, open_stack)
        yield Format(name, partial(_record, kind, name), _lines, read=read, mended=record, extra=_json)
    yield Format("codes.npy", partial(_record, "codes", "codes.npy"), read=_beside("codes", "codes.npy", open_stack))
    yield Format("room.npy", partial(_record, "lit", "room.npy"), read=_beside("lit", "room.npy", open_stack))
    for name in ("radiance.npy", "saturated.npy"):
        yield Format(name, partial(stack, name), read=_beside("stack", name, open_stack))
    name = "factors.json"
    factors = _beside("factors", name, _open_factors)
    yield Format(name, partial(_record, "factors", name), _lines, read=factors, extra=_json)
    yield Format("a.transport", _transport_file, read=_open_transport, extra=_number)
    yield Format("paint.bsdf", _tensors, read=_read_brdf)
    yield Format("table.exr", _table, _exr, read=_read_brdf)
    yield Format("a.mtlx", _mtlx, _lines, read=_open_material, extra=_number)
    yield Format("a.gltf", _gltf_material, _lines, read=_open_material, extra=_json)
    yield Format("a.zip", _zip_of_textures, _zip, read=_open_material)
    if has_library():
        decoder = f"{damaged_usd.__name__}:decode_batch"
        yield Format("a.usda", damaged_usd.layer, _lines, decoder, as_files=True, extra=_number)
        yield Format("a.usdc", damaged_usd.crate, _blocks, decoder, as_files=True)
        yield Format("a.usdz", damaged_usd.package, _zip, decoder, as_files=True)
    yield Format("a.zip", _zip_of_photographs, _zip, read=_unpack)
    for suffix, mode in ((".tar", "w"), (".tar.gz", "w:gz"), (".tar.bz2", "w:bz2"), (".tar.xz", "w:xz")):
        yield Format(f"a{suffix}", partial(_tar, mode), read=_unpack)
    yield Format("a.exr", IMAGES["exr-zip"].make, _exr, read=_recognise)
    yield Format("a.zip", _zip_of_photographs, _zip, read=_recognise)


#: Every format; those of images, meshes and lists are decoded by the child, and stand several times for each record.
FORMATS: tuple[Format, ...] = (*_images(), *_meshes(), *_lists(), *_records())


def prepare() -> None:
    """Make the good files and load the decoders, before the child is confined."""
    for one in FORMATS:
        if one.decoder and not one.as_files:
            find_damaged(one, _good(FORMATS.index(one)), 0)
            _decode(one, _good(FORMATS.index(one)))


@cache
def _good(index: int) -> bytes:
    return FORMATS[index].good()


def _decode(one: Format, content: bytes) -> dict[str, Any]:
    request = {"decoder": one.decoder, "name": one.name, "options": one.options, "beside": [], "memory_bytes": 6 << 30}
    return decoder_child._answer(request, [content], None)


def decode_batch(content: bytes, name: str, format: int, first: int, last: int) -> dict[str, Any]:
    """The decoder of the child: files `first` to `last` of a format, damaged and decoded; what became of them."""
    one, good = FORMATS[format], _good(format)
    faults, outcomes, times = list[tuple[int, str]](), Counter[str](), list[float]()
    # Peaks are those of the process: the one of the good files is there from the beginning.
    peak = _peak_bytes()
    for number in _numbers(format, first, last):
        bad = find_damaged(one, good, number)
        start = time.process_time()
        try:
            reply = _decode(one, bad)
        except Exception as error:  # the product would end this process; counted, and told with its number
            faults.append((number, f"{type(error).__name__}: {str(error)[:200]}"))
            outcomes["FAULT"] += 1
        else:
            outcomes["refused" if "problem" in reply else "read"] += 1
            if problem := _impossible(reply):
                faults.append((number, problem))
            del reply
        times.append(time.process_time() - start)
        if _peak_bytes() > peak + MEMORY_LIMIT_BYTES:
            faults.append((number, f"needs {_peak_bytes() - peak >> 20} MB more"))
            peak = _peak_bytes()
    return {"faults": faults, "outcomes": dict(outcomes), "times": np.array(times), "peak": _peak_bytes()}


def _numbers(format: int, first: int, last: int) -> range:
    step = len(FORMATS)
    return range(first + (format - first) % step, last, step)


def _peak_bytes() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss << 10


def _impossible(reply: dict[str, Any]) -> str:
    """A sentence on a result that cannot be; '' for a good one or a refusal in one sentence."""
    if "problem" in reply:
        error = InputError(reply.get("path", "a"), reply["problem"], reply["remedy"])
        return "" if reply["problem"] and reply["remedy"] and "\n" not in str(error) else f"no sentence: {error}"
    for name, value in reply.items():
        is_number = isinstance(value, np.ndarray) and value.dtype.kind == "f"
        if is_number and not name.startswith(("pixels", "spectra", "channel:")) and not np.isfinite(value).all():
            return f"{name} is not finite"
    faces = reply.get("faces")
    if faces is not None and not (0 <= faces.min() <= faces.max() < len(reply["positions"])):
        return "faces name vertices that do not exist"
    return ""


class Tally:
    """What became of the files so far."""

    def __init__(self, seed: int) -> None:
        self.seed, self.count = seed, 0
        self.outcomes, self.times = Counter[str](), list[float]()
        self.longest = (0.0, seed)
        self.peak = self.own = 0

    def fault(self, number: int, text: str) -> None:
        print(f"file {number} ({FORMATS[number % len(FORMATS)].name}): {text}", flush=True)

    def took(self, number: int, seconds: float, limit_s: float = TIME_LIMIT_S) -> None:
        self.count += 1
        self.times.append(seconds)
        self.longest = max(self.longest, (seconds, number))
        if seconds > limit_s:
            self.fault(number, f"SLOW {seconds:.1f} s")

    def report(self) -> None:
        order = np.sort(self.times)
        p999 = order[int(0.999 * (len(order) - 1))]
        print(
            f"seeds {self.seed} to {self.seed + self.count - 1}: {dict(self.outcomes)}; peak {self.own >> 20} MB, "
            f"of decoders {self.peak >> 20} MB; CPU median {1e3 * np.median(order):.2f} ms, p99.9 {p999:.3f} s, "
            f"longest {self.longest[0]:.2f} s (file {self.longest[1]})",
            flush=True,
        )


def _batched(tally: Tally, index: int, first: int, last: int) -> None:
    """The files of one format in the child; where that ends, one by one."""
    options: dict[str, Any] = {"format": index, "first": first, "last": last}
    numbers = _numbers(index, first, last)
    decoder = f"{MODULE}:decode_batch"
    try:
        reply = untrusted.decode_content(decoder, "batch", b" ", timeout_s=HANG_S * math.sqrt(len(numbers)), **options)
    except InputError as error:
        if len(numbers) > 1:
            for number in numbers:
                _batched(tally, index, number, number + 1)
            return
        tally.outcomes["crashed" if "crashed" in error.problem else "FAULT"] += 1
        tally.fault(numbers[0], error.problem)
        tally.took(numbers[0], 0.0)
        return
    for number, text in reply["faults"]:
        tally.fault(number, text)
    tally.outcomes.update(reply["outcomes"])
    tally.peak = max(tally.peak, reply["peak"])
    for number, seconds in zip(numbers, reply["times"], strict=True):
        tally.took(number, float(seconds))


def _batched_files(tally: Tally, index: int, numbers: Sequence[int], folder: Path) -> None:
    """The files of a format in a folder that a child reads; where that ends, in halves.

    A file that ends the child is refused by the product, in words.
    """
    one, copies = FORMATS[index], folder / "copies"
    copies.mkdir()
    names = [f"{number}{Path(one.name).suffix}" for number in numbers]
    for number, name in zip(numbers, names, strict=True):
        (copies / name).write_bytes(find_damaged(one, _good(index), number))
    options: dict[str, Any] = {"copies": str(copies), "files": names, "timeout_s": HANG_S * math.sqrt(len(numbers))}
    try:
        reply = untrusted.decode_in_child(one.decoder, copies / names[0], as_file=True, **options)
    except InputError as error:
        shutil.rmtree(copies)
        if len(numbers) > 1:
            half = len(numbers) // 2
            _batched_files(tally, index, numbers[:half], folder)
            _batched_files(tally, index, numbers[half:], folder)
        else:
            is_refused = any(words in error.problem for words in ("crashed", "GiB to decode", "cannot be decoded"))
            tally.outcomes["refused" if is_refused else "FAULT"] += 1
            if not is_refused:
                tally.fault(numbers[0], error.problem)
            tally.took(numbers[0], 0.0)
        return
    shutil.rmtree(copies)
    for number, text, seconds in zip(numbers, reply["outcomes"], reply["times"], strict=True):
        if text not in ("read", "refused"):
            tally.fault(number, text)
        tally.outcomes[text if text in ("read", "refused") else "FAULT"] += 1
        tally.took(number, float(seconds), LIBRARY_LIMIT_S)


def _read(tally: Tally, index: int, number: int, folder: Path) -> None:
    """A file of a format that is read in this process."""
    one = FORMATS[index]
    path = folder / one.name
    path.write_bytes(find_damaged(one, _good(index), number))
    start, peak = time.process_time(), _peak_bytes()
    assert one.read is not None
    try:
        one.read(path)
        tally.outcomes["read"] += 1
    except LightarcError as error:
        tally.outcomes["refused"] += 1
        if "\n" in str(error):
            tally.fault(number, f"no sentence: {error}")
    except Exception as error:  # counted, and told with its number
        tally.outcomes["FAULT"] += 1
        tally.fault(number, f"{type(error).__name__}: {str(error)[:200]}")
    tally.took(number, time.process_time() - start)
    tally.own = max(tally.own, _peak_bytes())
    if number >= tally.seed + len(FORMATS) and _peak_bytes() > peak + MEMORY_LIMIT_BYTES:
        tally.fault(number, f"needs {_peak_bytes() - peak >> 20} MB more")


def run(seed: int, count: int, report_every: int = sys.maxsize, *, in_child: bool = True) -> Tally:
    """Damage and read files `seed` to `seed` + `count`; faults are printed.

    Without those `in_child`, only the formats of records and archives.
    """
    tally, folder, due = Tally(seed), _place() / "now", report_every
    folder.mkdir(exist_ok=True)
    try:
        for first in range(seed, seed + count, BATCH * len(FORMATS)):
            last = min(seed + count, first + BATCH * len(FORMATS))
            for index, one in enumerate(FORMATS):
                numbers = _numbers(index, first, last)
                if one.as_files and in_child and numbers:
                    _batched_files(tally, index, numbers, folder)
                elif one.decoder and not one.as_files and in_child:
                    _batched(tally, index, first, last)
                elif not one.decoder:
                    for number in numbers:
                        _read(tally, index, number, folder)
            if tally.count >= due:
                tally.report()
                due += report_every
    finally:
        shutil.rmtree(_place())
        _place.cache_clear()
        _make.cache_clear()
        _good.cache_clear()
    return tally


MODULE = "tests.engine.storage.damaged_files"


def main(seed: int, count: int) -> None:
    warnings.simplefilter("error", RuntimeWarning)
    run(seed, count, min(count, 10_000)).report()


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
