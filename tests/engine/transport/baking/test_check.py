"""The check of a bake: what passes, what is said where it does not, and its page in the file."""

from __future__ import annotations

import zlib
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import InputError
from engine.geometry.shapes import open_mesh
from engine.transport.baking import file_header
from engine.transport.baking.check import (
    LAMP,
    Alternative,
    BakeCheck,
    LightCheck,
    decode_check,
    encode_check,
    lines_of_check,
    warnings_at_render,
    warnings_of_check,
    write_check,
)
from engine.transport.baking.file import open_transport, plan_transport, write_transport
from engine.transport.baking.file_header import PAGE


def light_check(light: str = "studio", mean_rel: float = 0.0, dark: float = 0.0, margin: float = 0.0) -> LightCheck:
    return LightCheck(
        light=light, mean_rel=mean_rel, mean_uncertainty=margin, rmse_rel=0.05, dark=dark, bright=0.0, pixels=1000
    )


def check_of(*lights: LightCheck, alternative: Alternative | None = None) -> BakeCheck:
    return BakeCheck(views=2, edge=48, lights=lights, alternative=alternative)


def write_empty(path: Path) -> None:
    """Write a transport file without rows, which has a page for a check."""
    mesh = open_mesh("plane")
    write_transport(path, plan_transport("sh", mesh, {}, {}, {}, np.zeros(1, np.int64)))


@pytest.mark.parametrize(
    ("mean_rel", "dark", "margin", "passes"),
    [(0.02, 0.0, 0.0, True), (-0.021, 0.0, 0.0, False), (0.021, 0.0, 0.002, True), (0.0, 0.0011, 0.0, False)],
)
def test_a_light_passes_within_its_limits(mean_rel: float, dark: float, margin: float, passes: bool) -> None:
    assert light_check(mean_rel=mean_rel, dark=dark, margin=margin).passes == passes


def test_a_bake_that_passes_has_no_warnings() -> None:
    check = check_of(light_check(), light_check(LAMP))
    assert warnings_of_check(check, "sh") == []
    assert warnings_at_render(check, "sh", "studio") == warnings_at_render(check, "sh", None) == []
    assert lines_of_check(check) == ["error of 2 small views against the reference: 5 % under studio, 5 % under a lamp"]


def test_warnings_name_the_light_the_error_and_what_passes() -> None:
    other = Alternative(mode="sh", lights=("noon",))
    check = check_of(light_check(), light_check("noon", -0.18, 0.024), light_check(LAMP, 0.09), alternative=other)
    assert warnings_of_check(check, "wavelet") == [
        "in the mode wavelet this bake differs from the reference: under noon 18 % too dark and 2.4 % of its pixels "
        "below a tenth of the reference; under a lamp 9 % too bright; the mode sh passes under noon"
    ]
    assert warnings_at_render(check, "wavelet", "studio") == []
    (noon,) = warnings_at_render(check, "wavelet", "noon")
    assert "under this light 18 % too dark" in noon
    assert noon.endswith("the mode sh passes there")
    (lamp,) = warnings_at_render(check, "wavelet", None)
    assert "under a lamp 9 % too bright" in lamp
    assert "passes" not in lamp


def test_an_environment_that_was_not_checked_is_judged_by_the_worst_one() -> None:
    check = check_of(light_check(), light_check("noon", 0.03), light_check("window", -0.2))
    (said,) = warnings_at_render(check, "sh", "mine")
    assert "under window, the nearest light that was checked, 20 % too dark" in said


def test_the_check_lies_in_the_last_page_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "a.transport"
    write_empty(path)
    size = path.stat().st_size
    assert open_transport(path).check is None
    check = check_of(light_check("studio", 0.01), alternative=Alternative(mode="sh", lights=("studio",)))
    write_check(path, check)
    assert path.stat().st_size == size
    assert open_transport(path).check == check


def test_a_file_of_an_older_version_has_no_page(tmp_path: Path) -> None:
    """Its size is that of its arrays; here the page is cut off and the header says so."""
    path = tmp_path / "a.transport"
    mesh = open_mesh("plane")
    plan = plan_transport("sh", mesh, {}, {}, {}, np.zeros(1, np.int64))
    older = plan.header.model_copy(update={"size_bytes": plan.header.size_bytes - PAGE})
    text = file_header.header_text(older)
    beginning = file_header.MAGIC + len(text).to_bytes(4, "little") + zlib.crc32(text).to_bytes(4, "little") + text
    content = beginning.ljust(older.table_offset, b"\0") + zlib.crc32(b"").to_bytes(4, "little")
    for array in older.arrays:
        content = content.ljust(array.offset, b"\0") + plan.whole[array.name].tobytes()
    path.write_bytes(content.ljust(older.size_bytes, b"\0"))
    assert open_transport(path).check is None


@pytest.mark.parametrize("at", [0, 4, 9, 200, PAGE - 1])
def test_damage_to_the_page_is_found(tmp_path: Path, at: int) -> None:
    page = bytearray(encode_check(check_of(light_check())))
    page[at] ^= 0x40
    with pytest.raises(InputError, match="damaged"):
        decode_check(tmp_path / "a.transport", bytes(page))


def test_values_that_cannot_be_are_refused(tmp_path: Path) -> None:
    good = encode_check(check_of(light_check()))
    length = int.from_bytes(good[:4], "little")
    text = good[8 : 8 + length].replace(b'"dark": 0.0', b'"dark": 7.0')
    page = (len(text).to_bytes(4, "little") + zlib.crc32(text).to_bytes(4, "little") + text).ljust(PAGE, b"\0")
    with pytest.raises(InputError, match="impossible"):
        decode_check(tmp_path / "a.transport", page)


def test_modes_have_the_names_that_a_user_knows() -> None:
    other = Alternative(mode="sh", lights=("studio",))
    check = check_of(light_check(mean_rel=0.3), alternative=other)
    (said,) = warnings_at_render(check, "wavelet", "studio", str.upper)
    assert said.startswith("in the mode WAVELET")
    assert said.endswith("the mode SH passes there")
