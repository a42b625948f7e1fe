"""Chromium without a window, driven through the DevTools protocol over two pipes: pointers, keys and images."""

from __future__ import annotations

import base64
import fcntl
import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--remote-debugging-pipe",
    "--use-gl=angle", "--use-angle=swiftshader-webgl",
)  # fmt: skip

#: Seconds after which a page that does not answer is given up.
PATIENCE_S = 60

#: Parts of what the browser says of itself: that it draws on the CPU, and that a screenshot reads the image.
OF_BROWSER = ("software WebGL", "GPU stall due to ReadPixels")

#: Names of keys that are no letters, with their numbers.
KEYS = {"Tab": 9, "Enter": 13, " ": 32, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40}
SHIFT = 8


class Page:
    """One tab: `errors` are messages of its console and exceptions, `requests` the addresses that it asked for."""

    def __init__(self, ask: int, answer: int) -> None:
        self._ask, self._answer, self._number, self._rest = ask, answer, 0, b""
        self._session: str | None = None
        self.errors: list[str] = []
        self.requests: list[str] = []

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to a command of the protocol; events that come before it are kept."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._ask, json.dumps(message).encode() + b"\0")
        while True:
            found = self._next()
            if found.get("id") == self._number:
                assert "error" not in found, found["error"]
                result: dict[str, Any] = found["result"]
                return result
            self._keep(found)

    def _next(self) -> dict[str, Any]:
        while b"\0" not in self._rest:
            content = os.read(self._answer, 1 << 20)
            assert content, "Chromium ended"
            self._rest += content
        message, _, self._rest = self._rest.partition(b"\0")
        found: dict[str, Any] = json.loads(message)
        return found

    def _keep(self, event: dict[str, Any]) -> None:
        parameters = event.get("params", {})
        if event.get("method") == "Runtime.exceptionThrown":
            self.errors.append(json.dumps(parameters["exceptionDetails"])[:500])
        if event.get("method") == "Log.entryAdded":
            words = parameters["entry"]["text"]
            self.errors += [] if any(part in words for part in OF_BROWSER) else [words]
        if event.get("method") == "Runtime.consoleAPICalled" and parameters["type"] in ("error", "warning"):
            self.errors.append(json.dumps(parameters["args"])[:500])
        if event.get("method") == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"][:200])

    def attach(self) -> None:
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")

    def open(self, address: str, size: tuple[int, int] = (900, 600), *, is_mobile: bool = False) -> None:
        """Load a page in a window of `size`, and wait until it says that it is ready or why not."""
        self.call(
            "Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1, mobile=is_mobile
        )
        self.call("Emulation.setTouchEmulationEnabled", enabled=is_mobile, maxTouchPoints=2 if is_mobile else 1)
        self.call("Page.navigate", url="about:blank")
        self.errors.clear()
        self.requests.clear()
        self.call("Page.navigate", url=address)
        self.wait("document.documentElement?.dataset.state !== undefined")

    def value(self, expression: str) -> Any:
        """The value of an expression of JavaScript, a promise's when it is kept."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def wait(self, condition: str) -> None:
        """Let the page go on until a condition of JavaScript holds."""
        promise = f"""new Promise((kept, broken) => {{
            const until = Date.now() + {1000 * PATIENCE_S};
            const look = () => ({condition}) ? kept() : Date.now() > until ? broken("too late") : setTimeout(look, 10);
            look();
        }})"""
        self.value(promise)

    def drawn(self) -> None:
        """Let the page draw what is asked for."""
        self.value("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def image(self) -> NDArray[np.uint8]:
        """The window (H, W, 3), 8-bit sRGB."""
        self.drawn()
        content = base64.b64decode(self.call("Page.captureScreenshot", format="png")["data"])
        pixels = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
        assert pixels is not None
        return np.asarray(pixels[..., ::-1], np.uint8)

    def drag(self, *places: tuple[float, float], button: str = "left", modifiers: int = 0) -> None:
        """Press a button of the mouse at the first place, move through the others and let go at the last."""
        held: dict[str, Any] = {"button": button, "modifiers": modifiers}
        held["buttons"] = {"left": 1, "right": 2, "middle": 4}[button]
        (x, y), *further = places
        self.call("Input.dispatchMouseEvent", type="mousePressed", x=x, y=y, clickCount=1, **held)
        for x, y in further:
            self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, **held)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, clickCount=1, **{**held, "buttons": 0})

    def wheel(self, x: float, y: float, down: float) -> None:
        self.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=down)

    def pinch(self, *moments: tuple[tuple[float, float], tuple[float, float]]) -> None:
        """Two fingers down, through the places of each moment, and up."""
        for kind, places in (("touchStart", moments[0]), *(("touchMove", moment) for moment in moments[1:])):
            points = [{"x": x, "y": y, "id": number} for number, (x, y) in enumerate(places)]
            self.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def key(self, name: str, modifiers: int = 0) -> None:
        text = name if len(name) == 1 else "\r" if name == "Enter" else ""
        words: dict[str, Any] = {"key": name, "modifiers": modifiers, "windowsVirtualKeyCode": KEYS.get(name, 0)}
        words["code"] = "Space" if name == " " else name
        self.call("Input.dispatchKeyEvent", type="keyDown", **words, **({"text": text} if text else {}))
        self.call("Input.dispatchKeyEvent", type="keyUp", **words)


@contextmanager
def chromium() -> Iterator[Page]:
    """A tab of a browser of its own; the test is skipped where none is installed."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip("no Chromium is installed to open the page with")
    asked, ask = os.pipe()
    answer, answered = os.pipe()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:

        def as_three_and_four() -> None:
            first, second = (fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (asked, answered))
            os.dup2(first, 3)
            os.dup2(second, 4)

        words = [browser, *ARGUMENTS, f"--user-data-dir={profile}", "about:blank"]
        process = subprocess.Popen(
            words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=as_three_and_four, close_fds=False
        )
        os.close(asked)
        os.close(answered)
        page = Page(ask, answer)
        try:
            page.attach()
            yield page
        finally:
            process.kill()
            process.wait()
            os.close(ask)
            os.close(answer)
