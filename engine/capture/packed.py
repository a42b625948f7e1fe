"""A capture that comes as an archive: its photographs are unpacked into a folder that lives as long as its sources."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Literal

from engine.capture.mirror_sphere import Circle
from engine.capture.sources import PHOTOGRAPH_SUFFIXES, Sources, Unpacked, belongs, find
from engine.capture.stated_lights import listed
from engine.errors import InputError, OutputError
from engine.files.archive import one_line
from engine.files.atomic import make_folder
from engine.files.unpack import is_archive, unpack
from engine.health import Finding, Verdict
from engine.steps import Step, Steps

_NESTED = (".zip", ".7z", ".rar", ".tar", ".tgz", ".tbz2", ".txz", ".tar.gz", ".tar.bz2", ".tar.xz", ".gz", ".xz")
_BUNDLE = PurePosixPath("manifest.json")


def find_packed(
    paths: Sequence[Path],
    angles_deg: Sequence[float] | None = None,
    *,
    sphere: Circle | Literal["auto"] | None = None,
    aside: Sequence[Path] = (),
    scratch: Path | None = None,
) -> Steps[Sources]:
    """As `sources.find`, where `paths` may also be one archive (zip, or tar with or without compression).

    It is unpacked into a folder in `scratch` (else in the system's folder for temporary files), which vanishes when
    nothing refers to the sources any more. Of its folders the uppermost with photographs counts.
    """
    yield Step(0.0, "Looking for photographs")
    archives = [path for path in paths if is_archive(path)]
    if not archives:
        return find(paths, angles_deg, sphere=sphere, aside=aside)
    (archive, *others) = archives
    if others or len(paths) > 1:
        raise InputError(archive, "is an archive among other files", "Give one archive alone, or files and folders")
    folder = _scratch_folder(scratch)
    place = make_folder(Path(folder.name) / archive.name)
    left_out: list[str] = []
    members = yield from unpack(archive, place, lambda names: _chosen(archive, names, left_out))
    sources = find([place], angles_deg, sphere=sphere, aside=aside)
    text = f"Photographs in other folders of {archive.name} were left out: {listed(left_out)}"
    findings = (Finding(Verdict.NOTE, text),) if left_out else ()
    unpacked = Unpacked(archive, members, folder)
    return replace(sources, unpacked=unpacked, findings=(*sources.findings, *findings))


def _scratch_folder(scratch: Path | None) -> tempfile.TemporaryDirectory[str]:
    try:
        return tempfile.TemporaryDirectory(prefix="lightarc-", dir=scratch, ignore_cleanup_errors=True)
    except OSError as error:
        place = scratch or Path(tempfile.gettempdir())
        raise OutputError(place, f"cannot be written ({one_line(error)})", "Check its permissions") from None


def _chosen(archive: Path, names: Sequence[str], left_out: list[str]) -> list[str]:
    """The photographs in the uppermost folder that has any, and what describes them; other folders are `left_out`."""
    visible = [PurePosixPath(name) for name in names if not _hidden(PurePosixPath(name))]
    if _BUNDLE in visible:
        raise InputError(archive, "is a bundle, or holds one: no photographs", "Open it in the window")
    nested = [path.name for path in visible if path.name.lower().endswith(_NESTED)]
    if nested:
        raise InputError(archive, f"holds another archive ({nested[0]})", "Unpack it and give the folder")
    folders = {path.parent for path in visible if path.suffix.lower() in PHOTOGRAPH_SUFFIXES}
    if not folders:
        raise InputError(archive, "holds no photographs", "Pack the photographs of one capture")
    top = min(len(folder.parts) for folder in folders)
    uppermost = [folder for folder in folders if len(folder.parts) == top]
    if len(uppermost) > 1:
        several = listed(sorted(map(str, uppermost)))
        raise InputError(archive, f"holds photographs in several folders: {several}", "Pack one capture by itself")
    left_out += sorted(str(folder) for folder in folders - set(uppermost))
    return [str(path) for path in visible if path.parent == uppermost[0] and belongs(Path(path.name))]


def _hidden(path: PurePosixPath) -> bool:
    """What file managers and packers add."""
    return path.name.startswith(".") or "__MACOSX" in path.parts
