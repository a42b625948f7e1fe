"""Pixels of the stacks of a project: in the cache of the user while its photographs are there, else in the project.

A project keeps the record of a stack (`stack.json`) in `NAME.lap-data/stack-HASH`. Its pixels take many times the
photographs and can be made again of them, bit for bit, so they lie in the cache (`app.session.cache`), where all
projects with equal pixels share them. Once photographs are gone the project takes the pixels in, compressed, as long as
the cache has them. Projects of before that hold them as .npy files, which are read where they lie.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterable
from pathlib import Path
from typing import BinaryIO

from app.project.values import MAX_HEADER, name_of
from app.session import cache
from engine.capture.stack import CODES, DIFFUSE, RADIANCE, RECORD, ROOM, SATURATED, ImageStack, open_stack, read_record
from engine.capture.stack_record import StackRecord
from engine.core.errors import FileError, InputError, UnreadableError
from engine.core.steps import Step, Steps
from engine.storage.atomic import atomic_file, atomic_folder, discard, make_folder, perform, write_bytes
from engine.storage.file_array import FileArray
from engine.storage.packed import PackedFile, pack
from engine.storage.untrusted import read_bytes

log = logging.getLogger(__name__)

#: Ending of compressed pixels.
PACKED = ".packed"

#: Files of pixels: codes, before which room light is written where it is taken off, or the others, of which the first
#: is there only for pairs under polarisers, and is written before those.
FILES = (ROOM, CODES, DIFFUSE, RADIANCE, SATURATED)

#: Files of which all are there where pixels are.
_WHOLE = ((CODES,), (RADIANCE, SATURATED))

_RECORD_LIMIT_BYTES = 64 << 20

#: Bytes that the header of an array of pixels may take.
_OUTLINE_BYTES = 256


def open_kept(folder: Path, *, verify: bool = False) -> ImageStack:
    """The stack of a project, whose pixels may be made again later (`are_there`).

    With `verify` pixels are read; those of the cache that are damaged are then gone. Raises InputError where the record
    is gone or damaged, or with `verify`, where pixels that the project holds are.
    """
    if any(all((folder / name).exists() for name in names) for names in _WHOLE):
        return open_stack(folder, verify=verify)
    place = place_of(read_record(folder), folder)
    if place != folder and cache.use(place) and verify:
        try:
            return open_stack(folder, pixels=place)
        except InputError as error:
            log.warning("%s", error)
            discard(place)
    return open_stack(folder, verify=False, pixels=place)


def place_of(record: StackRecord, folder: Path) -> Path:
    """The folder in the cache for the pixels of a stack, by their checksums; its own `folder` where there is none.

    Pixels that a project brings along are shared with no other, which has made its own: checksums can be forged.
    """
    if record.checksums is None:
        return folder
    size = f"{len(record.sources)}x{record.height_px}x{record.width_px}"
    own = f"-{name_of(str(folder).encode())[:16]}" if are_packed(folder) else ""
    of_pixels = "".join(f"{each:08x}" for each in record.checksums)
    if record.codes is not None:  # of which there are as many as photographs
        of_pixels = f"{record.codes.bits}-{name_of(of_pixels.encode())[:32]}"
    place = cache.entry(f"pixels-{of_pixels}-{size}{own}")
    return place if place is not None else folder


def are_there(stack: ImageStack) -> bool:
    """True if the pixels of a stack can be read now."""
    return all(not isinstance(array, FileArray) or array.is_there for array in stack.pixels.values())


def are_packed(folder: Path) -> bool:
    """True if the project holds the compressed pixels of this stack."""
    return any(all((folder / f"{name}{PACKED}").is_file() for name in names) for names in _WHOLE)


def take_in(made: Path, target: Path, project: Path, photographs: Iterable[Path]) -> ImageStack:
    """Open the stack that was imported as `made` in the cache as the stack `target` of a `project`."""
    place = place_of(read_record(made), made)
    content = read_bytes(made / RECORD, _RECORD_LIMIT_BYTES)
    if place != made:
        _move(made, place)
    with atomic_folder(target, RECORD) as folder:
        write_bytes(folder / RECORD, content)
    if place != made:
        cache.note_origin(place, project, photographs)
    return open_kept(target)


def take_again(made: Path, stack: ImageStack, project: Path, photographs: Iterable[Path]) -> None:
    """Let what was imported again as `made` be the pixels of `stack`.

    Raises InputError where it has other pixels than the stack had; it is then removed.
    """
    assert stack.folder is not None
    assert isinstance(stack.radiance, FileArray)
    record, now = read_record(stack.folder), read_record(made)
    place = stack.radiance.path.parent
    if not _is_same(record, now):
        discard(made)
        by, own = str(record.provenance.get("software", "an unknown version")), str(now.provenance.get("software", ""))
        why = f"by {by}, and {own} reads" if by != own else "and now they give"
        raise InputError(
            stack.folder, f"was imported {why} other values of its photographs", "Import the photographs again"
        )
    if place == stack.folder:
        for name in stack.pixels:
            perform("rename", place / name, lambda name=name: (made / name).replace(place / name))  # type: ignore[misc]
        discard(made)
        return
    _move(made, place)
    cache.note_origin(place, project, photographs)


def _is_same(one: StackRecord, other: StackRecord) -> bool:
    """True for equal pixels."""
    names = ("checksums", "codes", "height_px", "width_px")
    return len(one.sources) == len(other.sources) and all(getattr(one, at) == getattr(other, at) for at in names)


def _move(made: Path, place: Path) -> None:
    """Give a folder of the cache its name; where one has that already, replace its files that are damaged."""
    if not cache.use(place):
        try:
            perform("rename", place, lambda: made.rename(place))
        except FileError:
            if not place.is_dir():
                raise
        cache.use(place)
    for name in FILES:
        if (made / name).exists() and _outline(place / name) != _outline(made / name):
            perform("rename", place / name, lambda name=name: (made / name).replace(place / name))  # type: ignore[misc]
    discard(made)
    cache.keep_within()


def _outline(path: Path) -> tuple[int, bytes] | None:
    """Size and header of an array, by which `FileArray` knows it; None where it cannot be read."""
    try:
        with path.open("rb") as file:
            return os.fstat(file.fileno()).st_size, file.read(_OUTLINE_BYTES)
    except OSError:
        return None


def secure_pixels(stack: ImageStack, project: Path, photographs: Iterable[Path], *, are_gone: bool) -> Steps[None]:
    """Take the pixels of a stack into the `project` where the photographs `are_gone` or are others now; else let the
    cache know the `photographs` that they can be made of."""
    place = stack.radiance.path.parent if isinstance(stack.radiance, FileArray) else stack.folder
    if stack.folder is None or place is None or place == stack.folder or not are_there(stack):
        return
    if are_gone:
        yield from keep_pixels(stack)
    else:
        cache.note_origin(place, project, photographs)


def keep_pixels(stack: ImageStack) -> Steps[bool]:
    """Compress the pixels of a stack into its folder; False where they are nowhere."""
    folder = stack.folder
    if folder is None or are_packed(folder):
        return folder is not None
    if not are_there(stack):
        return False
    for at, (name, array) in enumerate(stack.pixels.items()):
        assert isinstance(array, FileArray)
        size = array.path.stat().st_size
        with array.path.open("rb") as source, atomic_file(folder / f"{name}{PACKED}") as file:
            for done in pack(file, iter(lambda source=source: source.read(1 << 22), b""), size, array.dtype.itemsize):  # type: ignore[misc]
                yield Step((at + done) / len(stack.pixels), "compressing the photographs")
    return True


def unpack_pixels(stack: ImageStack) -> Steps[None]:
    """Put compressed pixels of the project where they are read. Raises InputError where they are damaged."""
    assert stack.folder is not None
    place = stack.radiance.path.parent if isinstance(stack.radiance, FileArray) else stack.folder
    if place == stack.folder:
        yield from _unpack(stack, place)
        return
    with atomic_folder(place, RECORD) as folder:
        yield from _unpack(stack, folder)
        write_bytes(folder / RECORD, read_bytes(stack.folder / RECORD, _RECORD_LIMIT_BYTES))
    cache.use(place)
    cache.keep_within()


def check_pixels(stack: ImageStack) -> Steps[None]:
    """Read the compressed pixels of a stack in the project. Raises InputError where they are damaged."""
    if stack.folder is not None and are_packed(stack.folder):
        for name, array in stack.pixels.items():
            with _open(stack.folder / f"{name}{PACKED}") as source:
                for _ in PackedFile(stack.folder / f"{name}{PACKED}", source, MAX_HEADER + array.nbytes).chunks():
                    yield Step(0.0, "reading the photographs")


def _unpack(stack: ImageStack, target: Path) -> Steps[None]:
    assert stack.folder is not None
    for at, (name, array) in enumerate(stack.pixels.items()):
        assert isinstance(array, FileArray)
        size = array.offset_bytes + array.nbytes
        path = stack.folder / f"{name}{PACKED}"
        with _open(path) as source, atomic_file(make_folder(target) / name, size) as file:
            packed = PackedFile(path, source, size)
            if packed.size_bytes != size:
                raise InputError(path, f"is damaged: it has {packed.size_bytes:,} bytes, not {size:,}", "Import again")
            for chunk in packed.chunks():
                file.write(chunk.data)
                yield Step((at + file.tell() / size) / len(stack.pixels), "unpacking the photographs")


def _open(path: Path) -> BinaryIO:
    try:
        return path.open("rb")
    except OSError as error:
        cause = os.strerror(error.errno or 0)
        raise UnreadableError(path, f"cannot be read ({cause})", "Check its permissions and its disk") from None
