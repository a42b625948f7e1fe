"""Scattered samples and directions from text files of strangers, read in the decoder child
(`engine.storage.untrusted`).

The readers of the formats run there as they are: what they read is handed to the child beforehand, the file itself and,
of CUReT, those that lie beside it.
Cost: 0.5 s for the first file, the start of the child; then a millisecond more than in this process.
"""

from __future__ import annotations

from pathlib import Path
from types import MappingProxyType
from typing import Any

from engine.brdf.readers.csv_samples import read_csv_directions
from engine.brdf.readers.curet import split_material
from engine.brdf.samples import BrdfSamples
from engine.core.directions import Vectors
from engine.core.health import Finding, Health, Verdict
from engine.storage.readers import Reader, load, readers
from engine.storage.untrusted import decode_in_child, hand

_ARRAYS = ("wi", "wo", "value", "wavelengths_nm", "spectra")

#: Seconds that reading may take: the largest text holds some hundred million numbers.
LIMIT_S = 600.0


def read_samples(reader: Reader, path: Path) -> BrdfSamples:
    """The samples in `path`, read in the child; InputError as the reader raises."""
    source = split_material(path)[0] if reader.companions else path
    places = [source.with_name(name) for name in reader.companions]
    beside = {str(place): place for place in places if place.name != source.name and place.is_file()}
    decoder = "engine.brdf.readers.samples_child:decode_samples"
    reply = decode_in_child(decoder, source, timeout_s=LIMIT_S, beside=beside, reader=reader.decode, asked=str(path))
    findings = tuple(Finding(Verdict(verdict), text, source) for verdict, text, source in reply["findings"])
    health = Health(MappingProxyType({name: float(value) for name, value in reply["figures"].items()}), findings)
    arrays: dict[str, Any] = {name: reply.get(name) for name in _ARRAYS}
    return BrdfSamples(
        **arrays, name=reply["name"], kind=reply["kind"], health=health, invalid_samples=reply["invalid_samples"]
    )


def decode_samples(
    content: bytes, name: str, reader: str, asked: str, beside: dict[str, bytes] | None = None
) -> dict[str, Any]:
    """The decoder: fields of `BrdfSamples` as arrays and JSON values."""
    with hand({name: content, **(beside or {})}):
        samples: BrdfSamples = load(reader)(Path(asked))
    arrays = {each: getattr(samples, each) for each in _ARRAYS if getattr(samples, each) is not None}
    findings = [(int(one.verdict), one.text, one.source) for one in samples.health.findings]
    values = {"name": samples.name, "kind": samples.kind, "invalid_samples": samples.invalid_samples}
    return {**arrays, **values, "figures": dict(samples.health.figures), "findings": findings}


def read_directions(path: Path) -> tuple[Vectors, Vectors]:
    """Unit directions wi, wo (N, 3) of the table `path`, read in the child; InputError as `read_csv_directions`."""
    reply = decode_in_child("engine.brdf.readers.samples_child:decode_directions", path, timeout_s=LIMIT_S)
    return reply["wi"], reply["wo"]


def decode_directions(content: bytes, name: str) -> dict[str, Any]:
    """The decoder: the arrays wi and wo."""
    with hand({name: content}):
        wi, wo = read_csv_directions(Path(name))
    return {"wi": wi, "wo": wo}


def prepare() -> None:
    """Load the readers, before the child is confined."""
    for reader in readers("brdf"):
        if reader.confined:
            load(reader.decode)
