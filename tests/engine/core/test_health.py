"""Findings about many sources that are alike are one; others stay as they are."""

from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.core.figure_text import number, write_with
from engine.core.health import MAX_APART, Finding, Health, Verdict


def health(*findings: tuple[Verdict, str, str | None]) -> Health:
    return Health(findings=tuple(Finding(*each) for each in findings))


def test_alike_findings_about_many_photographs_are_one() -> None:
    noisy = [
        (Verdict.WARNING, f"is noisy: its mean is {n / 10:.1f} times the noise", f"{n}.tif") for n in range(31, 36)
    ]
    clipped = [
        (Verdict.NOTE, f"{n} % of the pixels are clipped; a shorter exposure would keep them", f"{n}.tif")
        for n in (1, 12, 3, 4)
    ]
    said = health(*noisy[:2], *clipped, (Verdict.GOOD, "Mean radiance grows", None), *noisy[2:]).summary
    assert [each.sentence for each in said] == [
        "31.tif and 4 more are noisy: their mean is 3.1 to 3.5 times the noise",
        "1.tif and 3 more: 1 to 12 % of the pixels are clipped; a shorter exposure would keep them",
        "Mean radiance grows",
    ]
    assert [each.source for each in said] == ["31.tif", "1.tif", None]
    assert health(*noisy).warnings == ["31.tif and 4 more are noisy: their mean is 3.1 to 3.5 times the noise"]


@pytest.fixture
def with_decimal_commas() -> Iterator[None]:
    write_with(",", minus="−")
    yield
    write_with(".")


def test_ranges_of_alike_findings_are_in_the_form_of_the_language(with_decimal_commas: None) -> None:
    noisy = [(Verdict.NOTE, f"is noisy: {number(n, 3)} of 1,2,3", f"{n}.tif") for n in (0.25, 1200.0, 31.5, 12.0)]
    assert noisy[1][1] == "is noisy: 1\u202f200 of 1,2,3"
    assert health(*noisy).warnings == []
    assert [each.sentence for each in health(*noisy).summary] == [
        "0.25.tif and 3 more are noisy: 0,25 to 1\u202f200 of 1,2,3"
    ]


def test_thousands_are_one_number() -> None:
    filled = [(Verdict.NOTE, f"fills {n:,} texels", f"{n}.tif") for n in (987, 1200, 45000, 1201)]
    assert [each.text for each in health(*filled).summary] == ["and 3 more: fills 987 to 45,000 texels"]


def test_few_or_different_findings_stay_apart() -> None:
    texts = ["looks like img_1.tif", "looks like img_2.tif", "looks like img_3.tif", "looks like img_4.tif"]
    findings = health(*((Verdict.NOTE, text, f"{n}.tif") for n, text in enumerate(texts)))
    assert findings.summary == findings.findings
    few = health(*((Verdict.NOTE, f"alignment left {n} px", f"{n}.tif") for n in range(MAX_APART)))
    assert few.summary == few.findings
    named = health(*((Verdict.NOTE, f"is the same as {n}.tif", f"b{n}.tif") for n in range(6)))
    assert named.summary == named.findings
    nobody = health(*((Verdict.NOTE, f"{n} texels were filled", None) for n in range(9)))
    assert nobody.summary == nobody.findings


@given(
    st.lists(
        st.builds(
            Finding,
            st.sampled_from(Verdict),
            st.text(" 0123456789.,-/#aits%", max_size=12),
            st.none() | st.sampled_from("abcde"),
        )
    )
)
def test_no_finding_is_lost_whatever_its_text(findings: list[Finding]) -> None:
    said = Health(findings=tuple(findings)).summary
    counted = [each for each in said if each not in findings]
    alone = [each for each in findings if each in said]
    merged = sum(int(each.text.removeprefix("and ").split(" more")[0]) + 1 for each in counted)
    assert len(alone) + merged >= len(findings)
    assert max((each.verdict for each in said), default=None) == max((each.verdict for each in findings), default=None)
