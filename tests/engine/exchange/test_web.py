"""Pages: Chromium draws the strict one under a policy without inline code, and both show the same picture."""

from __future__ import annotations

import functools
import http.server
import re
import shutil
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.exchange.subject import Settings, Subject
from engine.exchange.web import contents, strict

from .materials import linear_material, woven_subject

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-gl=angle",
    "--use-angle=swiftshader-webgl", "--window-size=900,600", "--virtual-time-budget=10000",
)  # fmt: skip


class Strict(http.server.SimpleHTTPRequestHandler):
    """Serves a folder, each answer with the policy."""

    def end_headers(self) -> None:
        self.send_header("Content-Security-Policy", "default-src 'self'")
        super().end_headers()

    def log_message(self, *_words: object) -> None:
        pass


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, content in drain(contents(woven_subject(), Settings(), "An error of 3 %.")).files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    return tmp_path


@pytest.fixture
def address(folder: Path) -> Iterator[str]:
    """Of a server that sends the files of the folder with the policy."""
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Strict, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_address[1]}"
    server.shutdown()
    server.server_close()


def browse(folder: Path, address: str, *arguments: str) -> str:
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip("no Chromium is installed to open the page with")
    words = [browser, *ARGUMENTS, f"--user-data-dir={folder / 'profile'}", *arguments, address]
    return subprocess.run(words, capture_output=True, timeout=120, check=True).stdout.decode()


def screenshot(folder: Path, address: str) -> NDArray[np.uint8]:
    browse(folder, f"{address}#neutral=0&azimuth=30&elevation=50", f"--screenshot={folder / 'shot.png'}")
    picture = cv2.imread(str(folder / "shot.png"))
    assert picture is not None
    return np.asarray(picture, np.uint8)


def test_chromium_draws_the_strict_page_as_the_whole_one(folder: Path, address: str) -> None:
    shown = browse(folder, f"{address}/strict/index.html", "--dump-dom")
    assert 'data-state="ready"' in shown
    assert "An error of 3 %." in shown
    one, other = (
        screenshot(folder, f"{address}/strict/index.html"),
        screenshot(folder, (folder / "A_cloth_woven.html").as_uri()),
    )
    assert one[:, :620].max() > 60
    np.testing.assert_allclose(one.astype(int), other.astype(int), atol=1)


def test_the_whole_page_does_not_work_under_the_policy(folder: Path, address: str) -> None:
    """So that the test above can fail: the policy is in force."""
    assert 'data-state="ready"' not in browse(folder, f"{address}/A_cloth_woven.html", "--dump-dom")


def test_the_strict_page_holds_no_code(folder: Path) -> None:
    text = (folder / "strict" / "index.html").read_text(encoding="utf-8")
    scripts = re.findall(r"<script([^>]*)>(.*?)</script>", text, re.DOTALL)
    assert [words.strip() for words, _ in scripts] == ['type="application/json" id="data"', 'src="lightarc.js"']
    assert scripts[1][1] == ""
    assert "<style" not in text
    assert not re.search(r"\son[a-z]+=|style=|javascript:|data:image", text)
    assert "default-src 'self'" in text
    assert {path.name for path in (folder / "strict").glob("map_*.png")} == set(re.findall(r"map_\d+\.png", text))


def test_a_page_of_another_make_is_a_mistake() -> None:
    with pytest.raises(ValueError, match="one style sheet"):
        strict("<html><script>1</script><script>2</script></html>")


def test_slices_alone_make_no_page() -> None:
    subject = Subject(linear_material((0.5, 0.5, 0.5), "lambert"), woven_subject().maps)
    with pytest.raises(UsageError, match="the page shows"):
        drain(contents(subject, Settings(), ""))
