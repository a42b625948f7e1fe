"""Readers of file formats, each declared once: its name, its endings, its first bytes, and the function that reads it.

Everything that asks which files are images, meshes or measured BRDFs derives from here: readers themselves, what a
dropped file is recognised as, file dialogs, and messages. Functions are named as text, so that a format is loaded where
a file of it is read, in the confined process (`engine.storage.untrusted`). Another package adds a reader by `register`
or by an entry point of the group `lightarc.readers`.
"""

from __future__ import annotations

import contextlib
import json
import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any, Literal

from engine.core import plugins

#: Group of the entry points by which installed packages bring further readers.
ENTRY_POINTS = "lightarc.readers"

Kind = Literal["image", "mesh", "brdf"]

_SUFFIX = re.compile(r"\.[a-z0-9_]{1,16}")
_FUNCTION = re.compile(r"[A-Za-z_][\w.]{0,200}+:[A-Za-z_]\w{0,100}+")


@dataclass(frozen=True)
class Reader:
    """A file format and how it is read.

    Attributes
    ----------
    kind : what its files hold.
    title : its name for users.
    decode : "package.module:function", called in the confined process: for an image `function(content, name)`, which
        returns an `engine.images.raster.Raster`; for a mesh the same, which returns the arrays (vertices, triangles) or
        `engine.geometry.polygons.Polygons`; for a BRDF `function(path)`, which reads by
        `engine.storage.untrusted.read_bytes` and returns `engine.brdf.samples.BrdfSamples`.
    suffixes : endings in lower case that files of this format alone have.
    shared : further endings, which other kinds of files have as well.
    signatures : first bytes, of which a file has one.
    looks_like : "package.module:function" called with the first bytes, the size in bytes and the name, where no
        signature decides.
    of_radiance : whether an image holds linear radiance without an upper limit, as environments do.
    confined : whether a BRDF is read in the confined process, as it is unless its reader allocates what its size says.
    companions : names of files beside it that belong to it.
    """

    kind: Kind
    title: str
    decode: str
    suffixes: tuple[str, ...] = ()
    shared: tuple[str, ...] = ()
    signatures: tuple[bytes, ...] = ()
    looks_like: str = ""
    of_radiance: bool = False
    confined: bool = True
    companions: tuple[str, ...] = ()

    @property
    def endings(self) -> tuple[str, ...]:
        """All endings, its own first."""
        return (*self.suffixes, *self.shared)

    def recognises(self, head: bytes, size_bytes: int, name: str) -> bool:
        """Return whether a file that begins with `head` is of this format."""
        if self.signatures and head.startswith(self.signatures):
            return True
        return bool(self.looks_like) and bool(load(self.looks_like)(head, size_bytes, name))


_BRDF = "engine.brdf.readers"


def _brdf(title: str, module: str, *suffixes: str, **more: Any) -> Reader:
    """A reader of BRDFs whose functions are `read_NAME` and `looks_like_NAME` of `package.module:NAME`."""
    module, name = module.split(":")
    return Reader("brdf", title, f"{module}:read_{name}", suffixes, looks_like=f"{module}:looks_like_{name}", **more)


#: Readers of the package: images from the best to the worst for measuring light; BRDFs in the order in which they are
#: asked, the strictest first.
_OWN: tuple[Reader, ...] = (
    Reader("image", "OpenEXR", "engine.images.exr:read_exr", (".exr",), (), (b"\x76\x2f\x31\x01",), of_radiance=True),
    Reader(
        "image",
        "Radiance",
        "engine.images.hdr:read_hdr",
        (".hdr", ".rgbe", ".pic"),
        signatures=(b"#?RADIANCE", b"#?RGBE"),
        of_radiance=True,
    ),
    Reader(
        "image",
        "PFM",
        "engine.images.pfm:read_pfm",
        (".pfm",),
        signatures=(b"PF\n", b"Pf\n", b"PF\r", b"Pf\r"),
        of_radiance=True,
    ),
    Reader(
        "image",
        "TIFF",
        "engine.images.tiff:read_tiff",
        (".tif", ".tiff"),
        signatures=(b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"),
    ),
    Reader("image", "PNG", "engine.images.png:read_png", (".png",), signatures=(b"\x89PNG\r\n\x1a\n",)),
    Reader("image", "Targa", "engine.images.tga:read_tga", (".tga",), looks_like="engine.images.tga:looks_like_tga"),
    Reader("image", "JPEG", "engine.images.jpeg:read_jpeg", (".jpg", ".jpeg", ".jpe"), signatures=(b"\xff\xd8\xff",)),
    Reader("mesh", "glTF", "engine.geometry.gltf:read_gltf", (".glb", ".gltf"), signatures=(b"glTF",)),
    Reader("mesh", "OBJ", "engine.geometry.obj:read_obj", (".obj",)),
    Reader("mesh", "OFF", "engine.geometry.obj:read_off", (".off",), signatures=(b"OFF",)),
    Reader("mesh", "PLY", "engine.geometry.ply:read_ply", (".ply",), signatures=(b"ply",)),
    Reader(
        "mesh",
        "USD",
        "engine.geometry.usd:read_usd",
        (".usd", ".usda", ".usdc", ".usdz"),
        signatures=(b"#usda", b"PXR-USDC"),
    ),
    Reader("mesh", "STL", "engine.geometry.read_scene:read_stl", (".stl", ".stl_ascii"), signatures=(b"solid",)),
    _brdf("GLSL of BRDF Explorer (.brdf)", "engine.brdf.written:written", ".brdf", confined=False),
    _brdf("RGL (.bsdf)", f"{_BRDF}.rgl:rgl", ".bsdf", confined=False),
    _brdf("tables of this program (.exr)", f"{_BRDF}.table_file:table", shared=(".exr",), confined=False),
    _brdf("MERL (.binary)", f"{_BRDF}.merl:merl", ".binary", confined=False),
    _brdf("UTIA (.bin)", f"{_BRDF}.utia:utia", shared=(".bin",), confined=False),
    _brdf("Cornell and ASTM E1392 (.brdf, .astm)", f"{_BRDF}.cornell:cornell", ".brdf", ".astm"),
    _brdf("ALTA text (.dat)", f"{_BRDF}.alta:alta", ".alta", shared=(".dat", ".txt")),
    _brdf(
        "CUReT (rbrdf.dat …)",
        f"{_BRDF}.curet:curet",
        shared=(".dat",),
        companions=("table.txt", "rbrdf.dat", "gbrdf.dat", "bbrdf.dat"),
    ),
    Reader(
        "brdf",
        "tables of angles and colours (.csv)",
        f"{_BRDF}.csv_samples:read_csv_samples",
        shared=(".csv",),
        looks_like=f"{_BRDF}.csv_samples:looks_like_csv",
    ),
)

_outside: list[Reader] = []

#: Groups of entry points that have not been loaded yet: that takes longer than all that is declared here.
_pending = [ENTRY_POINTS]


def register(reader: Reader) -> Reader:
    """Declare a reader of another package; ValueError where it lacks something or its ending is taken."""
    if not isinstance(reader, Reader) or reader.kind not in ("image", "mesh", "brdf") or not reader.title:
        raise ValueError("a reader is a Reader with a kind, which is image, mesh or brdf, and a title")
    if not _FUNCTION.fullmatch(reader.decode) or (reader.looks_like and not _FUNCTION.fullmatch(reader.looks_like)):
        raise ValueError(f"the functions of the reader {reader.title} are not named as package.module:function")
    if not reader.endings or not all(_SUFFIX.fullmatch(each) for each in reader.endings):
        raise ValueError(f"the reader {reader.title} states no endings such as .abc in lower case")
    if reader.kind != "mesh" and not (reader.signatures or reader.looks_like):
        raise ValueError(f"the reader {reader.title} states neither signatures nor looks_like")
    if reader.kind == "brdf" and not reader.confined:
        raise ValueError(f"the reader {reader.title} must run in the confined process")
    others = [other for other in (*_OWN, *_outside) if other != reader and other.kind == reader.kind]
    if taken := [each for other in others for each in other.suffixes if each in reader.suffixes]:
        raise ValueError(f"there is another reader of {taken[0]}")
    if reader not in _outside:
        _outside.append(reader)
    return reader


def unregister(reader: Reader) -> None:
    """Take back what `register` did."""
    if reader in _outside:
        _outside.remove(reader)


def _load_installed() -> None:
    while _pending:
        plugins.load(_pending.pop(), register)


def readers(kind: Kind) -> tuple[Reader, ...]:
    """All readers of a kind; those of other packages come last."""
    _load_installed()
    return tuple(each for each in (*_OWN, *_outside) if each.kind == kind)


def suffixes(kind: Kind) -> tuple[str, ...]:
    """The endings of files of a kind, each once, in the order of the readers."""
    return tuple(dict.fromkeys(ending for each in readers(kind) for ending in each.endings))


def radiance_suffixes() -> tuple[str, ...]:
    """The endings of images of radiance without an upper limit, which environments are kept in."""
    return tuple(ending for each in readers("image") if each.of_radiance for ending in each.endings)


def dialog_filter(words: str, endings: Iterable[str]) -> str:
    """A filter of a file dialog: 'Meshes (*.glb *.obj)'."""
    return f"{words} ({' '.join(f'*{ending}' for ending in endings)})"


def find_reader(kind: Kind, head: bytes, size_bytes: int, name: str) -> Reader | None:
    """The first reader of a kind that recognises a file by its first bytes, its size and its name."""
    return next((each for each in readers(kind) if each.recognises(head, size_bytes, name)), None)


def load(function: str) -> Any:
    """The function that "package.module:function" names."""
    module, name = function.split(":")
    return getattr(import_module(module), name)


def outside() -> str:
    """The readers of other packages as JSON, for a confined process."""
    _load_installed()
    return json.dumps([{**asdict(each), "signatures": _as_text(each.signatures)} for each in _outside])


def _as_text(signatures: Iterable[bytes]) -> list[str]:
    return [begin.decode("latin-1") for begin in signatures]


def adopt(records: str) -> None:
    """Know and load, in a process that is about to be confined, the readers that its parent knew (`outside`)."""
    _pending.clear()
    for each in json.loads(records):
        values: Any = {name: tuple(value) if isinstance(value, list) else value for name, value in each.items()}
        values["signatures"] = tuple(begin.encode("latin-1") for begin in each["signatures"])
        _outside.append(Reader(**values))
        with contextlib.suppress(ImportError):  # which is said of the file that needs it
            load(values["decode"])
