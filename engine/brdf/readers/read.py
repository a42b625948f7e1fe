"""Measured BRDF from files of any known format, recognised by content and never by the name alone.

A format is a file of this package with `looks_like_…(head, size_bytes, name)` and `read_…(path)`, declared in
`engine.storage.readers`. Readers give a BRDF, or `BrdfSamples` where the file is a scattered list, which `read_brdf`
makes smooth. Text is read in the decoder child (`engine.brdf.readers.samples_child`).
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, Protocol, TypeGuard

from engine.brdf.brdf import MODELS, Brdf, brdf_from_text
from engine.brdf.readers.curet import split_material
from engine.brdf.readers.samples_child import read_samples
from engine.brdf.samples import BrdfSamples
from engine.core.errors import InputError, UsageError
from engine.core.health import Health
from engine.core.steps import Step, Steps, drain, part
from engine.core.suggestion import suggest
from engine.storage.readers import find_reader, load, readers
from engine.storage.untrusted import read_head


class MeasuredBrdf(Brdf, Protocol):
    """A BRDF that was measured.

    Attributes
    ----------
    name : what was measured, usually the stem of the file's name.
    kind : how, in a short phrase for a user: "MERL table".
    samples : measured directions that the file holds.
    invalid_samples : how many of them could not be used; `health` says what became of them.
    """

    @property
    def name(self) -> str: ...

    @property
    def kind(self) -> str: ...

    @property
    def samples(self) -> int: ...

    @property
    def invalid_samples(self) -> int: ...

    @property
    def health(self) -> Health: ...


def is_measured(brdf: object) -> TypeGuard[MeasuredBrdf]:
    """True for a BRDF that says where its values come from, as measured and written ones do, and no model."""
    return hasattr(brdf, "health")


#: Bytes of a file that are read to recognise its format: some begin with pages of comments.
HEAD_BYTES = 1 << 16


def read_measurement(path: str | os.PathLike[str]) -> Any:
    """Contents of the file `path` as its reader gives them: a `MeasuredBrdf`, or `BrdfSamples` for a scattered list.

    Raises InputError, in a sentence that lists the formats, for a file of none of them.
    """
    path = Path(path)
    source, _ = split_material(path)
    head, size_bytes = read_head(source, HEAD_BYTES)
    reader = find_reader("brdf", head, size_bytes, source.name)
    if reader is not None:
        return read_samples(reader, path) if reader.confined else load(reader.decode)(path)
    refuse_others(path, head)
    titles = ", ".join(known.title for known in readers("brdf"))
    raise InputError(path, "is not a measured BRDF of a known format", f"These are read: {titles}")


#: First bytes, or words near the beginning, of files that measure reflectance otherwise, and what to say of them.
_OTHERS = (
    (
        re.compile(rb"<WindowElement\b|<DataDefinition>\s{0,99}<IncidentDataStructure>"),
        "is a BSDF of a window system in XML (WINDOW, Radiance), by Klems' patches or a tensor tree",
        "Sample it with Radiance's bsdfquery into a table of angles and colours (.csv)",
    ),
    (
        re.compile(
            rb"\A(?:#[^\n]{0,200}+\n){0,50}+Source\s{1,20}+(?:Measured|Calculated)\b.{0,400}?ScatterType", re.DOTALL
        ),
        "is a BSDF of Zemax",
        "Write its values as a table of angles and colours (.csv)",
    ),
    (
        re.compile(rb"\A\x89HDF\r\n\x1a\n"),
        "is an AxF file of X-Rite, or another of HDF5",
        "Export its maps as PBR textures, or its BRDF as a table, with the program that it comes from",
    ),
)

#: Endings of such files, where the first bytes do not tell.
_OTHER_SUFFIXES = {
    ".axf": _OTHERS[2][1:],
    ".btf": (
        "is a bidirectional texture function (BTF)",
        "Export its maps as PBR textures, or its images as a capture",
    ),
}


def refuse_others(path: Path, head: bytes) -> None:
    """InputError, by name, for a file of reflectance that is not read; `head` are its first bytes."""
    for words, problem, remedy in _OTHERS:
        if words.search(head):
            raise InputError(path, problem + ", which is not read", remedy)
    if path.suffix.lower() in _OTHER_SUFFIXES:
        problem, remedy = _OTHER_SUFFIXES[path.suffix.lower()]
        raise InputError(path, problem + ", which is not read", remedy)


def read_brdf(path: str | os.PathLike[str]) -> MeasuredBrdf:
    """The measured BRDF in the file `path`; InputError where there is none."""
    return drain(read_brdf_steps(path))


def read_brdf_steps(path: str | os.PathLike[str]) -> Steps[MeasuredBrdf]:
    """As `read_brdf`, in steps: a scattered list takes seconds to become smooth."""
    yield Step(0.0, "reading")
    measured = read_measurement(path)
    if isinstance(measured, BrdfSamples):
        from engine.brdf.scattered import fit_scattered  # loads scipy, which tables do without

        return (yield from part(fit_scattered(measured), 0.1, 1.0))
    table: MeasuredBrdf = measured
    return table


def open_brdf(text: str) -> Brdf:
    """The BRDF that `text` names: an existing file, or a model such as `ggx:alpha=0.3`.

    Raises
    ------
    InputError : the file is not a BRDF, or `text` is a path to nothing.
    UsageError : `text` is neither a file nor a model, or its parameters are not possible.
    """
    stripped = text.strip()
    if _exists(stripped):
        return read_brdf(stripped)
    if stripped.partition(":")[0] in MODELS:
        return brdf_from_text(stripped)
    if os.sep in stripped or "/" in stripped or Path(stripped).suffix[1:].isalpha():
        raise InputError(stripped, "does not exist", f"Name a file, or a model: {', '.join(MODELS)}")
    meant = suggest(stripped, MODELS)
    raise UsageError(f"{stripped!r} is neither a file nor a BRDF model{meant}; models are {', '.join(MODELS)}")


def _exists(text: str) -> bool:
    try:
        return bool(text) and split_material(Path(text))[0].exists()
    except (OSError, ValueError):
        return False
