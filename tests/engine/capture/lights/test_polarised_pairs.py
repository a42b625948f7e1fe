"""Pairs under parallel and crossed polarisers, told by names of files or folders."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from engine.capture.lights.sources import find
from engine.core.errors import InputError

DIRECTIONS = ("0.6 0 0.8", "0 0.6 0.8", "-0.6 0 0.8")


def put(folder: Path, names: Sequence[str], lights: Sequence[str] = ()) -> Path:
    """Files that are looked for but not read, and a list of `lights` by name."""
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(name.encode())
    if lights:
        lines = [f"{name} {DIRECTIONS[at % 3]}" for at, name in enumerate(lights)]
        (folder / "lights.lp").write_text("\n".join([str(len(lines)), *lines]))
    return folder


def pairs_of(folder: Path, **options: object) -> dict[str, str]:
    """Names of crossed photographs by those of the parallel ones, from the folder."""
    found = find([folder], **options)  # type: ignore[arg-type]
    assert len(found.photographs) == 3
    return {
        path.relative_to(folder).as_posix(): found.crossed[path].relative_to(folder.parent).as_posix()
        for path in found.photographs
    }


@pytest.mark.parametrize(
    ("parallel", "crossed"),
    [("img_{}_par.tif", "img_{}_cross.tif"), ("XP-{} PP.png", "XQ-{} XP.png"), ("{}-co-pol.tif", "{}-cross-pol.tif")],
)
def test_names_of_files_tell_pairs(tmp_path: Path, parallel: str, crossed: str) -> None:
    if "XP" in parallel:
        parallel, crossed = parallel.replace("XP-", "S-"), crossed.replace("XQ-", "S-")
    both = [[name.format(at) for at in (1, 2, 10)] for name in (parallel, crossed)]
    put(tmp_path / "c", [*both[0], *both[1]], both[0])
    assert pairs_of(tmp_path / "c") == {one: f"c/{other}" for one, other in zip(*both, strict=True)}


def test_a_list_may_name_both_photographs_of_a_pair_under_one_light(tmp_path: Path) -> None:
    names = [[f"{at}_{side}.tif" for at in (1, 2, 3)] for side in ("par", "cross")]
    put(tmp_path / "c", [*names[0], *names[1]], [*names[0], *names[1]])
    assert pairs_of(tmp_path / "c") == {f"{at}_par.tif": f"c/{at}_cross.tif" for at in (1, 2, 3)}
    put(tmp_path / "c", [], [*names[0], names[1][1], names[1][0], names[1][2]])
    with pytest.raises(InputError, match=r"lists other lights for 1_par.tif and 1_cross.tif"):
        find([tmp_path / "c"])


def test_names_of_folders_tell_pairs_by_equal_names_else_by_order(tmp_path: Path) -> None:
    put(tmp_path / "c", [f"{side}/IMG_{at}.tif" for side in ("Parallel", "crossed") for at in (1, 2, 10)])
    put(tmp_path / "c", [], [f"IMG_{at}.tif" for at in (1, 2, 10)])
    assert pairs_of(tmp_path / "c") == {f"Parallel/IMG_{at}.tif": f"c/crossed/IMG_{at}.tif" for at in (1, 2, 10)}
    assert find([tmp_path / "c"]).name == "c"
    other = put(
        tmp_path / "d", [*(f"p par/{at}.tif" for at in (8, 9, 10)), *(f"x cross/{at}.tif" for at in (98, 99, 100))]
    )
    put(other, [], [f"{at}.tif" for at in (8, 9, 10)])
    assert pairs_of(other) == {f"p par/{at}.tif": f"d/x cross/{at + 90}.tif" for at in (8, 9, 10)}
    both = find([other / "p par", other / "x cross"], [30.0, 40.0, 50.0])
    assert [path.name for path in both.crossed.values()] == ["98.tif", "99.tif", "100.tif"]


def test_the_folder_of_crossed_photographs_may_be_stated(tmp_path: Path) -> None:
    one = put(tmp_path / "one", ["1.tif", "2.tif", "3.tif"], ["1.tif", "2.tif", "3.tif"])
    two = put(tmp_path / "two", ["1.tif", "2.tif", "3.tif", "white.tif", "lights.lp"])
    assert pairs_of(one, pair=two) == {f"{at}.tif": f"two/{at}.tif" for at in (1, 2, 3)}
    assert not find([one]).crossed
    (two / "3.tif").unlink()
    with pytest.raises(InputError, match="2 photographs under crossed polarisers and 3 under parallel"):
        find([one], pair=two)


def test_photographs_without_counterpart_are_named_and_pairs_can_be_switched_off(tmp_path: Path) -> None:
    names = [f"{at}_{side}.tif" for at in (1, 2, 3) for side in ("par", "cross")]
    put(tmp_path / "c", names, names)
    put(tmp_path / "c", ["4_par.tif"])
    with pytest.raises(InputError, match=r"4_par.tif has no counterpart"):
        find([tmp_path / "c"])
    (tmp_path / "c" / "4_par.tif").unlink()
    found = find([tmp_path / "c"], pair="none")
    assert len(found.photographs) == 6
    assert not found.crossed
