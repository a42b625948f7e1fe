"""Pages: Chromium draws the strict one under a policy without inline code, and both show the same image."""

from __future__ import annotations

import functools
import http.server
import re
import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.pbr_from_material import nearest_maps
from engine.exchange.subject import Settings, Subject
from engine.exchange.web import contents
from engine.storage.atomic import write_bytes
from tests.chromium import Page, chromium

from .materials import linear_material, woven_material, woven_subject


class Strict(http.server.SimpleHTTPRequestHandler):
    """Serves a folder, each answer with the policy."""

    def end_headers(self) -> None:
        self.send_header("Content-Security-Policy", "default-src 'self'")
        super().end_headers()

    def do_GET(self) -> None:
        """As any, but for the icon that browsers ask every site for."""
        if self.path == "/favicon.ico":
            self.send_response(204)
            self.end_headers()
        else:
            super().do_GET()

    def log_message(self, *_words: object) -> None:
        pass


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = drain(contents(woven_subject(), Settings(), "An error of 3 %."))
    for name in made.paths:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        write_bytes(tmp_path / name, made.content(name))
    return tmp_path


@pytest.fixture
def address(folder: Path) -> Iterator[str]:
    """Of a server that sends the files of the folder with the policy."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Strict, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Page]:
    with chromium() as page:
        yield page


def test_chromium_draws_the_strict_page_as_the_whole_one(browser: Page, folder: Path, address: str) -> None:
    places, shown = (f"{address}/strict/index.html", (folder / "A_cloth_woven.html").as_uri()), []
    for place in places:
        browser.open(f"{place}#neutral=0&azimuth=30&elevation=50")
        assert "An error of 3 %." in browser.value("byId('facts').textContent")
        shown.append(browser.image().astype(int))
        assert browser.errors == []
        assert [place for place in browser.requests if not place.startswith((address, "file:", "data:"))] == []
    assert shown[0][:, :620].max() > 60
    np.testing.assert_allclose(shown[0], shown[1], atol=1)


def test_the_whole_page_does_not_work_under_the_policy(browser: Page, address: str) -> None:
    """So that the test above can fail: the policy is in force."""
    browser.call("Page.navigate", url=f"{address}/A_cloth_woven.html")
    browser.wait("document.readyState === 'complete'")
    assert browser.value("document.documentElement.dataset.state") is None
    assert any("Content Security Policy" in words for words in browser.errors)


def test_the_strict_page_holds_no_code(folder: Path) -> None:
    text = (folder / "strict" / "index.html").read_text(encoding="utf-8")
    scripts = re.findall(r"<script([^>]*)>(.*?)</script>", text, re.DOTALL)
    assert [words.strip() for words, _ in scripts] == ['type="application/json" id="data"', 'src="lightarc.js"']
    assert scripts[1][1] == ""
    assert "<style" not in text
    assert not re.search(r"\son[a-z]+=|style=|javascript:|data:image", text)
    assert "default-src 'self'" in text
    assert {path.name for path in (folder / "strict").glob("*.png")} == set(re.findall(r'"([\w-]+\.png)"', text))


def test_slices_alone_make_no_page() -> None:
    subject = Subject(linear_material((0.5, 0.5, 0.5), "lambert"), woven_subject().maps)
    with pytest.raises(UsageError, match="the page shows"):
        drain(contents(subject, Settings(), ""))


@pytest.mark.parametrize(("width", "said"), [(20, 1), (1025, 2)])
def test_what_the_coding_of_a_page_leaves_out_is_said(width: int, said: int) -> None:
    material = woven_material(2, width)
    maps, white = drain(nearest_maps(material))
    warnings = drain(contents(Subject(material, maps, white), Settings(), "")).warnings
    assert len(warnings) == said
    assert "16 bits" in warnings[0]
    assert said == 1 or "1024 texels a side" in warnings[1]
