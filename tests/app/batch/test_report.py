"""The report of a batch: escaped whatever names hold, and sorted and filtered in a browser."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from app.batch.captures import Capture
from app.batch.record import Row
from app.batch.report import write_report
from tests.chromium import chromium

HOSTILE = '"><script>document.title = "taken"</script><img src=x onerror=alert(1)>$title'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Reports of one capture that failed, one with a warning, one that is good, and one that waits."""
    folder = tmp_path_factory.mktemp("batch & co")
    done = {"photographs": 8, "project": "medal.lap", "page": "export/web/a b#.html", "verdict": "good"}
    odd = Capture("=cmd", Path(f"/x/{HOSTILE}"), {}, {"note": HOSTILE, "@sum": "=1+1", "raw": "\udce9\x1b[31m"})
    rows = [
        Row(odd, "failed", reason=f"{HOSTILE} is damaged.", seconds=3.0),
        Row(Capture("medal 10", Path("/x/a")), "done", seconds=20.0, record={**done, "held_out_rmse_srgb8": 10.0}),
        Row(
            Capture("medal 9", Path("/x/b")),
            "done",
            seconds=100.0,
            record={**done, "held_out_rmse_srgb8": 9.5, "verdict": "warning", "warnings": [HOSTILE], "delta_e": 1.25},
        ),
        Row(Capture("plain", Path("/x/c"))),
    ]
    write_report(folder, rows)
    return folder


def test_names_are_escaped_and_formulas_are_text(folder: Path) -> None:
    page = (folder / "report.html").read_text()
    assert page.count("<script") == 1
    assert "<img src=x" not in page
    assert "onerror" in page  # as text
    assert "\x1b" not in page
    with (folder / "report.csv").open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    assert not any(cell.startswith(("=", "+", "-", "@")) for row in rows for cell in (*row, *row.values()))
    assert [row["state"] for row in rows] == ["failed", "done", "done", "waiting"]
    found = json.loads((folder / "report.json").read_text())
    assert {name: found[name] for name in ("waiting", "running", "done", "failed")} == {
        "waiting": 1,
        "running": 0,
        "done": 2,
        "failed": 1,
    }
    assert found["captures"][2]["warnings"] == [HOSTILE]
    assert found["captures"][1]["files"]["page"] == "medal 10/export/web/a b#.html"


def test_the_page_sorts_and_filters_in_a_browser(folder: Path) -> None:
    with chromium() as page:
        page.open((folder / "report.html").as_uri(), (1280, 800))
        names = (
            "[...document.querySelectorAll('tbody tr')].filter((r) => !r.hidden).map((r) => r.dataset.state + ' ' + "
        )
        names += "r.cells[1].firstChild.textContent)"

        def press(words: str) -> list[str]:
            page.value(f"[...document.querySelectorAll('th button')].find((b) => b.textContent === '{words}').click()")
            return list(page.value(names))

        assert page.value(names) == ["failed =cmd", "done medal 10", "done medal 9", "waiting plain"]
        assert press("Capture")[1:] == ["done medal 9", "done medal 10", "waiting plain"]
        assert press("Held-out error")[:2] == ["done medal 9", "done medal 10"]
        assert press("Held-out error")[:2] == ["done medal 10", "done medal 9"]
        assert press("Time")[-1] == "waiting plain"
        page.value("const t = document.getElementById('text'); t.value = 'ONERROR medal'; "
                   "t.dispatchEvent(new Event('input'))")  # fmt: skip
        assert page.value(names) == ["done medal 9"]
        page.value("document.getElementById('text').value = ''; const s = document.getElementById('state'); "
                   "s.value = 'failed'; s.dispatchEvent(new Event('change'))")  # fmt: skip
        assert page.value(names) == ["failed =cmd"]
        assert page.value("document.getElementById('count').textContent") == "1 of 4"
        assert page.value("document.title") == "Batch " + folder.name
        assert page.value("document.querySelector('td a[href$=html]').pathname").endswith("/a%20b%23.html")
        assert page.errors == []
        assert [address for address in page.requests if not address.startswith(("file:", "data:"))] == []
