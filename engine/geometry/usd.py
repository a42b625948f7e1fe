"""USD files for the library of USD, which opens files by their paths: copied to a folder that its process may read.

The file is copied with the layers that it names (sublayers, references, payloads), if they lie in its folder or below,
and nothing else is there for the process (`engine.storage.sandbox`). It says which layers it misses, until none is.
The library, some 100 MB, is an extra: `pip install 'lightarc[usd]'`.
Cost: 1 s for the start of the process, more than all else of small files.
"""

from __future__ import annotations

import importlib.util
import re
import tempfile
from pathlib import Path
from typing import Any

from engine.core.errors import InputError
from engine.storage import readers
from engine.storage.atomic import atomic_file, make_folder
from engine.storage.beside import file_beside
from engine.storage.untrusted import FILE_LIMIT_BYTES, decode_in_child, open_checked, read_head

#: Endings of USD files.
SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")

#: First bytes of layers, as text and in binary form; a package begins as a zip does.
SIGNATURES = (b"#usda", b"PXR-USDC")

#: Layers that a file may name, and layers within layers.
MAX_LAYERS, MAX_LEVELS = 200, 20

#: The decoder process for stages; this module is that for meshes.
STAGE = "engine.geometry.usd_stage"

#: Names of files that no library takes for more than a name.
_PLAIN = re.compile(r"[\w.,+ -]{1,200}", re.ASCII)


def is_usd(path: Path) -> bool:
    """True for a layer of USD by its first bytes, and for a package (.usdz) where the library is there to read it."""
    head = read_head(path, 8)[0]
    return head.startswith(SIGNATURES) or (head.startswith(b"PK") and path.suffix.lower() == ".usdz" and has_library())


def has_library() -> bool:
    """True if usd-core is installed."""
    return importlib.util.find_spec("pxr") is not None


def ask_usd(
    decoder: str, path: Path, search: Path | None = None, process: str = STAGE, **options: Any
) -> dict[str, Any]:
    """The answer of a decoder about a USD file; InputError where a layer that it names is missing, or lies elsewhere.

    The decoder gets the keywords `copies`, their folder, and `file`, the name of the first there. It answers
    `missing` layers by their names from that folder, or what it is asked for.
    """
    if not has_library():
        remedy = "Install the extra usd: pip install 'lightarc[usd]', or export it as .glb"
        raise InputError(path, "is USD, which is read by the library usd-core, and that is not installed", remedy)
    with tempfile.TemporaryDirectory(prefix="lightarc-usd-", ignore_cleanup_errors=True) as folder:
        copies = {_name_copy(path): path}
        _copy(path, Path(folder, *copies))
        for _ in range(MAX_LEVELS):
            more: dict[str, Any] = {"process": process, "as_file": True, "copies": folder}
            reply = decode_in_child(decoder, path, **more, **options, file=next(iter(copies)))
            missing = reply.get("missing", [])
            if not missing:
                return reply
            if len(copies) + len(missing) > MAX_LAYERS:
                break
            for name in missing:
                copies[name] = file_beside(path, name, "Copy that as well, or export it as .usdz", search)
                _copy(copies[name], Path(folder, name))
    raise InputError(path, f"names more than {MAX_LAYERS} layers, or layers in a circle", "Export it as .usdz")


def _name_copy(path: Path) -> str:
    """The name of a file in the folder of copies: its own where the library reads nothing else out of it."""
    head = read_head(path, 8)[0]
    kind = ".usda" if head.startswith(b"#usda") else ".usdc" if head.startswith(b"PXR") else ".usdz"
    is_plain = _PLAIN.fullmatch(path.name) and path.suffix.lower() in (kind, ".usd" if kind != ".usdz" else kind)
    return path.name if is_plain else f"model{kind}"


def _copy(source: Path, target: Path) -> None:
    make_folder(target.parent)
    with open_checked(source, FILE_LIMIT_BYTES) as (file, size_bytes), atomic_file(target, size_bytes) as copy:
        while piece := file.read(1 << 20):
            copy.write(piece)


def read_usd(copies: str, name: str, file: str) -> Any:
    """The parts of a model, as `engine.geometry.gltf.read_gltf` gives them, or the layers that are `missing`."""
    return readers.load(f"{STAGE}:read_stage")(copies, name, file)


def prepare() -> None:
    """Load the library, and what meshes need, before the process is confined."""
    readers.load("engine.geometry.mesh:prepare")()
    readers.load(f"{STAGE}:prepare")()
