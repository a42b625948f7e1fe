"""Folders of factors: what is written comes back bit for bit, and nothing else is taken for factors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.errors import InputError, OutputError
from engine.core.steps import drain
from engine.factor.errors import Factorisation, reference
from engine.factor.factor import factor
from engine.factor.factor_file import MEMBER, holds_factors, open_reflectance, read_factors, write_factors
from engine.factor.separable_factors import SeparableFactors
from engine.factor.settings import FactorSettings

PAINT = brdf_from_text("lafortune:preset=blue-paint")

KINDS = {
    "symmetric": {"side": 8, "products": 2},
    "polar": {"side": 8, "products": 2, "map": "polar", "method": "svd"},
    "half": {"side": 8, "products": 2, "parametrisation": "half-diff", "map": "parabolic"},
    "homomorphic": {"method": "homomorphic", "size": 8, "reciprocal": True},
    "search": {"method": "search", "size": 8, "textures": 2, "restarts": 1, "parametrisation": "half-diff"},
}


@pytest.fixture(scope="module")
def made() -> dict[str, Factorisation]:
    return {kind: drain(factor(PAINT, FactorSettings(samples=500, **more))) for kind, more in KINDS.items()}  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", KINDS)
def test_factors_come_back_bit_for_bit(kind: str, made: dict[str, Factorisation], tmp_path: Path) -> None:
    stored = write_factors(tmp_path / "factors", made[kind])
    found = read_factors(tmp_path / "factors")
    pairs = reference(PAINT, 2000)
    assert np.array_equal(found.factors.f(pairs.wi, pairs.wo), stored.factors.f(pairs.wi, pairs.wo))
    close = made[kind].factors.f(pairs.wi, pairs.wo)
    assert np.abs(found.factors.f(pairs.wi, pairs.wo) - close).max() <= 1e-5 * close.max()
    assert found.term_errors == made[kind].term_errors
    figures = ("method", "asymmetry", "condition_number", "optimum_ratio", "evaluations", "searching")
    for name in (*figures, "weighting", "converged", "negative_energy"):
        assert getattr(found, name) == getattr(made[kind], name)
    one, other = (getattr(result.factors, "isotropic", None) for result in (found, stored))
    assert (one, found.factors.reciprocal) == (other, stored.factors.reciprocal)
    shorter = [result.factors.truncate(1).f(pairs.wi, pairs.wo) for result in (found, stored)]
    assert np.array_equal(shorter[0], shorter[1])
    again = write_factors(tmp_path / "again", found)
    assert again.term_errors == found.term_errors
    for path in sorted((tmp_path / "factors").iterdir()):
        assert path.read_bytes() == (tmp_path / "again" / path.name).read_bytes()


def test_factors_are_opened_like_any_brdf(made: dict[str, Factorisation], tmp_path: Path) -> None:
    write_factors(tmp_path / "factors", made["symmetric"])
    assert holds_factors(tmp_path / "factors")
    assert open_reflectance(str(tmp_path / "factors")).f((0, 0, 1), (0, 0, 1)).shape == (3,)
    assert open_reflectance("lambert").isotropic
    assert not holds_factors(tmp_path)
    assert not holds_factors("a\0b")


def test_a_folder_of_factors_is_replaced_and_no_other(made: dict[str, Factorisation], tmp_path: Path) -> None:
    write_factors(tmp_path / "factors", made["symmetric"])
    write_factors(tmp_path / "factors", made["polar"])
    factors = read_factors(tmp_path / "factors").factors
    assert isinstance(factors, SeparableFactors)
    assert factors.hemisphere_map.kind == "polar"
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"factors\.json"):
        write_factors(tmp_path / "other", made["polar"])


def change(folder: Path, **values: Any) -> None:
    path = folder / MEMBER
    record = json.loads(path.read_text())
    for name, value in values.items():
        record[name] = {**record[name], **value} if isinstance(value, dict) else value
    path.write_text(json.dumps(record))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"format": "other"}, "does not describe factors"),
        ({"version": 4}, "newer"),
        ({"method": 3}, "method"),
        ({"extra": 1}, "extra"),
        ({"factors": {"size": 10**9}}, "size"),
        ({"factors": {"size": 9}}, "texels"),
        ({"factors": {"terms": 60}}, "not exist"),
        ({"factors": {"map": "square"}}, "map"),
        ({"sha256": {"term-01-view.exr": "0" * 64}}, "damaged"),
    ],
)
def test_records_that_do_not_fit_are_refused_in_a_sentence(
    values: Any, words: str, made: dict[str, Factorisation], tmp_path: Path
) -> None:
    write_factors(tmp_path / "factors", made["symmetric"])
    change(tmp_path / "factors", **values)
    with pytest.raises(InputError, match=words):
        read_factors(tmp_path / "factors")


def test_homomorphic_records_that_do_not_fit_are_refused(made: dict[str, Factorisation], tmp_path: Path) -> None:
    folder = tmp_path / "factors"
    for values in (
        {"mean": [0.0, 1.0, 1.0]},
        {"epsilon": 2.0},
        {"projections": [[{"kind": "linear", "rows": [[1.0] * 4] * 2, "extent": "disks"}]]},
        {"projections": [[{"kind": "linear"}]]},
    ):
        write_factors(folder, made["search"])
        change(folder, factors=values)
        with pytest.raises(InputError, match=r"cannot be|texels"):
            read_factors(folder)


def test_damaged_files_are_reported_and_never_read(made: dict[str, Factorisation], tmp_path: Path) -> None:
    write_factors(tmp_path / "factors", made["symmetric"])
    rng = np.random.default_rng(0)
    for name in (MEMBER, "term-01-light.exr", "term-02-view.exr"):
        path = tmp_path / "factors" / name
        whole = path.read_bytes()
        for cut in rng.integers(0, len(whole), 6):
            path.write_bytes(whole[:cut])
            with pytest.raises(InputError):
                read_factors(tmp_path / "factors")
        path.unlink()
        with pytest.raises(InputError):
            read_factors(tmp_path / "factors")
        path.write_bytes(whole)
    for content in (b"[]", b"{", b"[" * 100_000, b'{"format": NaN}', b"\xff"):
        (tmp_path / "factors" / MEMBER).write_bytes(content)
        with pytest.raises(InputError):
            read_factors(tmp_path / "factors")


def make_version_1(folder: Path) -> None:
    """Make the folder one of version 1, which knows nothing of regions that are left out."""
    record = json.loads((folder / MEMBER).read_text())
    for name in ("left_out", "held_out_by", "best_terms", "unmeasured"):
        del record[name]
    for term_error in record["ladder"]:
        for name in ("held_out_rms_cosine_weighted", "held_out_sq_log", "smoothing"):
            del term_error[name]
    (folder / MEMBER).write_text(json.dumps(record | {"version": 1}))


@pytest.mark.parametrize("kind", ["symmetric", "search"])
def test_factors_of_version_1_are_read_and_written_as_the_newest(
    kind: str, made: dict[str, Factorisation], tmp_path: Path
) -> None:
    stored = write_factors(tmp_path / "old", made[kind])
    make_version_1(tmp_path / "old")
    found = read_factors(tmp_path / "old")
    wi, wo = np.array([[0.6, 0.0, 0.8]]), np.array([[0.0, 0.28, 0.96]])
    assert np.array_equal(found.factors.f(wi, wo), stored.factors.f(wi, wo))
    assert (found.best_terms, found.held_out_by, found.left_out, found.unmeasured) == (None, "", (), "")
    assert [term_error.held_out for term_error in found.term_errors] == [None] * len(stored.term_errors)
    assert [term_error.metrics for term_error in found.term_errors] == [
        term_error.metrics for term_error in stored.term_errors
    ]
    write_factors(tmp_path / "new", found)
    assert json.loads((tmp_path / "new" / MEMBER).read_text())["version"] == 3
    assert read_factors(tmp_path / "new").term_errors == found.term_errors


@pytest.mark.long
def test_a_search_of_version_1_goes_on(made: dict[str, Factorisation], tmp_path: Path) -> None:
    write_factors(tmp_path / "old", made["search"])
    make_version_1(tmp_path / "old")
    old = read_factors(tmp_path / "old")
    settings = FactorSettings("search", parametrisation="half-diff", size=8, textures=3, restarts=1, samples=500)
    found = drain(factor(PAINT, settings, old))
    assert found.best_terms == found.factors.terms
    assert all(term_error.held_out is not None for term_error in found.term_errors)


def test_errors_of_other_terms_are_refused(made: dict[str, Factorisation], tmp_path: Path) -> None:
    for kind in ("symmetric", "search"):
        folder = tmp_path / kind
        write_factors(folder, made[kind])
        record = json.loads((folder / MEMBER).read_text())
        for term_errors in (record["ladder"] * 2, record["ladder"][1:]):
            (folder / MEMBER).write_text(json.dumps(record | {"ladder": term_errors}))
            with pytest.raises(InputError, match="errors are not those of its terms"):
                read_factors(folder)
        (folder / MEMBER).write_text(json.dumps(record | {"ladder": []}))
        assert read_factors(folder).term_errors == ()


@pytest.mark.parametrize("rows", [[[1e308, 1e308, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]], [[1.0, 0.0, 0.0, 0.0]] * 2])
def test_projections_that_are_not_orthonormal_are_refused_without_a_warning(
    rows: list[list[float]], made: dict[str, Factorisation], tmp_path: Path
) -> None:
    write_factors(tmp_path / "f", made["search"])
    record = json.loads((tmp_path / "f" / MEMBER).read_text())
    record["factors"]["projections"][0][0] = {"kind": "linear", "rows": rows, "extent": "disks"}
    (tmp_path / "f" / MEMBER).write_text(json.dumps(record))
    with pytest.raises(InputError, match="two orthonormal rows"):
        read_factors(tmp_path / "f")
