"""Files of a capture as users keep them: sidecars, thumbnails, copies, RAW beside JPEG, and the folders of programs.

One photograph of each shot is kept. Where a shot lies there in several kinds of file (IMG_1.CR2 beside IMG_1.JPG), all
shots are taken from one kind: the best of those that hold every shot, else the one that holds the most, because kinds
differ in what they did to the light. A file that `capture.toml` names goes before all others.
Nothing is decided by content but for copies (`IMG_1 (1).jpg`), which are left out only where every byte is equal.
"""

from __future__ import annotations

import filecmp
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path

from engine.capture.lights.file_names import comparable, join_names
from engine.capture.photograph.kinds import RAW_SUFFIXES, kind_name, kind_of, kinds
from engine.core.health import Finding, Verdict

#: The file in which a user says what the photographs do not (`engine.capture.lights.capture_file`).
CAPTURE_FILE = "capture.toml"

#: Files that cameras and programs put beside photographs; none is a photograph.
SIDECARS = frozenset(
    f".{name}"
    for name in (
        *("xmp", "thm", "pp3", "dop", "arp", "on1", "cos", "cot", "cof", "comask", "lrcat", "lrprev", "nksc", "vrd"),
        *("wav", "ini", "db", "ds_store", "bridgesort", "bridgecache", "bridgecachet", "aae", "ctg", "log", "md5"),
    )
)

#: Folders that programs make inside the folder of a capture, whose images are none of it.
_MADE_BY_PROGRAMS = frozenset(
    (
        *("@eadir", "__macosx", "thumb", "thumbs", "thumbnail", "thumbnails", "preview", "previews"),
        *("captureone", "darktable_exported", "finished-files", "cropped-files"),
    )
)
_CATALOGUES = (".lrdata", ".lrlibrary", ".cocatalog")

#: Folders of RTIBuilder in the order in which photographs are looked for; its light positions lie in another.
_RTI_BUILDER, _RTI_LIGHTS = ("jpeg-exports", "original-captures"), "assembly-files"

_THUMBNAIL = re.compile(r"(.*[ _.-])?(thumb(nail)?s?|tn|contact[ _-]?sheet|preview)([ _.-].*)?", re.IGNORECASE)
_COPY = re.compile(r"(?P<of>.+?)( ?\(\d{1,3}\)| - (copy|kopie|copie|copia)( ?\(\d{1,3}\))?| copy( \d{1,3})?)", re.I)
_EDITED = re.compile(r"(?P<of>.+?)-(edit|enhanced(-nr|-sr)?)(-\d{1,3})?", re.IGNORECASE)


def is_sidecar(path: Path) -> bool:
    """True for files that cameras, programs and systems put beside photographs, and for hidden ones."""
    return path.name.startswith(".") or path.suffix.lower() in SIDECARS


def inside(folders: Sequence[tuple[str, int]]) -> tuple[str | None, str | None]:
    """The sub-folder that holds the capture and the one of light positions, of (name, number of photographs).

    None for the first where there is none, or more than one that could be meant.
    """
    filled = {name: count for name, count in folders if count and not is_made_by_program(name)}
    by_name = {name.lower(): name for name in filled}
    lights = next((name for name, _ in folders if name.lower() == _RTI_LIGHTS), None)
    for known in _RTI_BUILDER:
        if known in by_name:
            return by_name[known], lights
    return (next(iter(filled)), None) if len(filled) == 1 else (None, None)


def capture_folder(folder: Path) -> Path:
    """The folder whose name is that of the capture: the one around a folder of RTIBuilder."""
    return folder.parent if folder.name.lower() in _RTI_BUILDER else folder


def is_made_by_program(name: str) -> bool:
    """True for the name of a folder whose images a program made of the photographs, and for hidden folders."""
    name = name.lower()
    return name.startswith(".") or name in _MADE_BY_PROGRAMS or name.endswith(_CATALOGUES)


def one_of_each_shot(photographs: Sequence[Path], named: Collection[str]) -> tuple[list[Path], list[Finding]]:
    """`photographs` with one file for each shot, in their order, and what was left out and why.

    `named` are names of files that a user wrote down, as `comparable` has them; these stay.
    """
    kept, findings = list(photographs), list[Finding]()
    for rest, words in ((_thumbnails, "Thumbnails"), (_copies, "Copies, equal in every byte,"), (_edits, "Edits")):
        out = [path for path in rest(kept) if comparable(path.name) not in named]
        if out and len(kept) - len(out) >= 2:
            kept = [path for path in kept if path not in out]
            findings.append(_list_left_out(f"{words} were excluded", out))
    chosen, said = _select_one_kind(kept, named)
    return chosen, [*findings, *said]


def _list_left_out(words: str, paths: Sequence[Path], verdict: Verdict = Verdict.NOTE) -> Finding:
    return Finding(verdict, f"{words}: {join_names([path.name for path in paths])}")


def _thumbnails(paths: Sequence[Path]) -> list[Path]:
    return [path for path in paths if _THUMBNAIL.fullmatch(path.stem)]


def _copies(paths: Sequence[Path]) -> list[Path]:
    return [path for path in paths if any(_equal(path, one) for one in _origins(_COPY, path, paths))]


def _edits(paths: Sequence[Path]) -> list[Path]:
    return [path for path in paths if _origins(_EDITED, path, paths)]


def _origins(pattern: re.Pattern[str], path: Path, paths: Sequence[Path]) -> list[Path]:
    """Files of which `path` is a copy or an edit by its name."""
    match = pattern.fullmatch(path.stem)
    return [one for one in paths if one.stem.casefold() == match["of"].casefold()] if match else []


def _equal(path: Path, other: Path) -> bool:
    try:
        return path.suffix.lower() == other.suffix.lower() and filecmp.cmp(path, other, shallow=False)
    except OSError:
        return False  # what cannot be read is said when it is decoded


def _select_one_kind(paths: Sequence[Path], named: Collection[str]) -> tuple[list[Path], list[Finding]]:
    shots: dict[tuple[str, Path], dict[int, list[Path]]] = {}
    for path in paths:
        shots.setdefault((_shoot(path), path.parent), {}).setdefault(kind_of(path), []).append(path)
    if len(shots) == len(paths):
        return list(paths), []
    counts = {kind: sum(kind in found for found in shots.values()) for kind in kinds()}
    usual = max(counts, key=lambda kind: (counts[kind], -kind))
    suffixes = Counter(path.suffix.lower() for path in paths)
    kept: set[Path] = set()
    for found in shots.values():
        every = [path for some in found.values() for path in some]
        wanted = [path for path in every if comparable(path.name) in named]
        kept.update(wanted or [_one_suffix(found.get(usual) or found[min(found)], suffixes)])
    chosen = [path for path in paths if path in kept]
    used = sorted({kind_of(path) for path in chosen})
    words = " and ".join(kind_name(kind) for kind in used)
    text = f"Shots lie there in several kinds of files; {words} {'was' if len(used) == 1 else 'were'} taken, not"
    findings = [_list_left_out(text, [path for path in paths if path not in kept])]
    if len(used) > 1:
        findings.append(Finding(Verdict.WARNING, f"Not all photographs are of one kind: {words} are mixed"))
    return chosen, findings


def _one_suffix(paths: Sequence[Path], counts: Mapping[str, int]) -> Path:
    """Of files of one shot and kind, as CR2 and the DNG made of it, the one with the usual suffix; DNG comes last."""

    def key(path: Path) -> tuple[int, bool, str, str]:
        suffix = path.suffix.lower()
        return -counts[suffix], suffix == ".dng", suffix, path.name

    return min(paths, key=key)


def _shoot(path: Path) -> str:
    """The name without extensions: editors also write IMG_1.CR2.tif and IMG_1.NEF.jpg."""
    stem = Path(comparable(path.name)).stem
    inner = Path(stem)
    return (inner.stem if inner.suffix.lower() in RAW_SUFFIXES else stem).casefold()


def capture_files(files: Iterable[Path]) -> list[Path]:
    """Those of `files` that are called `capture.toml`, in any case of letters."""
    return [path for path in files if path.name.lower() == CAPTURE_FILE]
