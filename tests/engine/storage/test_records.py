"""The manifest of a stranger (fault 9), and that ours comes back exactly."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from engine.core.errors import InputError
from engine.core.health import Finding, Health, Verdict
from engine.storage.records import (
    UNITS,
    HealthRecord,
    Manifest,
    Member,
    PowerLawRecord,
    read_manifest,
    write_manifest,
)
from engine.storage.text import read_json

MANIFEST = Manifest(
    name="Gewebe „blau“ 😀",
    brdf="phong:exponent=20",
    sigma=0.1 + 0.2,
    elevation_deg=[10.0, 1e-308, 90.0],
    units=UNITS,
    software={"lightarc": "0.1.0"},
    provenance={"camera": {"black_level": [512, 513.5], "raw": None, "flat": True}},
    figures={"rms": 5e-324},
    shading_map=None,
    power_law=PowerLawRecord(
        height_px=1, width_px=2, r_max=1 / 3, rms=0.0, rms_per_channel=[0.1, 0.2, 0.3], health=HealthRecord()
    ),
    health=HealthRecord.of(Health({"a": math.nan, "b": 1 / 7}, (Finding(Verdict.BAD, "dark", "a.tif"),))),
    members={"brdf.json": Member(sha256="0" * 64, size_bytes=3)},
)
PATH = Path("woven.lightarc")


def test_comes_back_exactly() -> None:
    assert read_manifest(write_manifest(MANIFEST), PATH) == MANIFEST
    health = MANIFEST.health.restored()
    assert math.isnan(health.figures["a"])
    assert health.figures["b"] == 1 / 7
    assert health.findings == (Finding(Verdict.BAD, "dark", "a.tif"),)


def reseal(**changes: Any) -> bytes:
    """The manifest with other fields and a seal that fits them, as a careful forger would write it."""
    from engine.storage import records

    value = {**MANIFEST.model_dump(), **changes}
    return json.dumps({**value, "manifest_sha256": records.seal(value)}).encode()


def test_fault_9_the_seal_notices_each_change() -> None:
    value = json.loads(write_manifest(MANIFEST))
    for name in value:
        changed = {**value, name: "changed"}
        with pytest.raises(InputError):
            read_manifest(json.dumps(changed).encode(), PATH)
    with pytest.raises(InputError, match="not as it was written"):
        read_manifest(json.dumps({**value, "name": "changed"}).encode(), PATH)


def test_fault_9_newer_versions_are_refused_with_words() -> None:
    with pytest.raises(InputError, match=r"newer Lightarc \(schema 7, this one reads 6\)\. Update Lightarc"):
        read_manifest(reseal(schema_version=7), PATH)


@pytest.mark.parametrize(
    "changes",
    [
        {"schema_version": 0},
        {"schema_version": "1"},
        {"schema_version": None},
        {"name": 5},
        {"name": "x" * 10_001},
        {"sigma": -1.0},
        {"sigma": 0},
        {"sigma": "1"},
        {"sigma": True},
        {"elevation_deg": {}},
        {"elevation_deg": [None]},
        {"elevation_deg": [10**400]},
        {"members": []},
        {"members": {"a": {"sha256": "0" * 63, "size_bytes": 1}}},
        {"members": {"a": {"sha256": "0" * 64, "size_bytes": -1}}},
        {"members": {"a": {"sha256": "0" * 64, "size_bytes": 1 << 40}}},
        {"power_law": []},
        {"power_law": {**MANIFEST.model_dump()["power_law"], "height_px": 0}},
        {"power_law": {**MANIFEST.model_dump()["power_law"], "width_px": 1 << 31}},
        {"power_law": {**MANIFEST.model_dump()["power_law"], "width_px": 2.0}},
        {"power_law": {**MANIFEST.model_dump()["power_law"], "rms_per_channel": [1.0]}},
        {"health": {"figures": {}, "findings": [{"verdict": "FINE", "text": "", "source": None}]}},
        {"surprise": 1},
    ],
    ids=str,
)
def test_fault_9_wrong_types_and_bounds(changes: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"woven.lightarc: manifest.json") as caught:
        read_manifest(reseal(**changes), PATH)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(
    "content",
    [
        b"", b"{", b"null", b"[]", b"3", b'"x"', b"\xff\xfe{}", b"{}", b'{"format": "other"}',
        b'{"a": NaN}', b'{"a": Infinity}', b'{"a": -Infinity}', b'{"a": 1e999}', b'{"a": -1e999}',
        b'{"a": 1, "a": 2}', b"[" * 100_000, b"[" * 100_000 + b"]" * 100_000, b'{"a":' * 100_000,
        b'{"a": ' + b"9" * 10_000 + b"}", b"\0" * 100, b'{"format": "lightarc-bundle", "schema_version": 1}',
    ],
    ids=lambda content: ascii(content[:20]),
)  # fmt: skip
def test_fault_9_json_of_strangers(content: bytes) -> None:
    with pytest.raises(InputError, match=r"woven.lightarc: .*manifest.json") as caught:
        read_manifest(content, PATH)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999", "-1e400"])
def test_fault_9_numbers_that_are_none_in_an_otherwise_good_manifest(number: str) -> None:
    content = write_manifest(MANIFEST).replace(b"513.5", number.encode())
    with pytest.raises(InputError, match=r"manifest.json is not valid JSON"):
        read_manifest(content, PATH)


def test_json_is_read_as_it_is() -> None:
    assert read_json(b'{"a": [1, 2.5, "\\u00e9", null, true]}', PATH, "brdf.json") == {"a": [1, 2.5, "é", None, True]}
