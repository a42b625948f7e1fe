"""Programs of others that read our files: three.js in Chromium draws, Khronos' validator and glslang check.

Chromium is that of the machine; three and gltf-validator are looked for where `npm install --prefix build/node` puts
them, in this folder or beside the program. The page is served on this machine alone, for a page of a disk may not load
modules, and the page sends its image back there: a browser that is asked for the text of a page instead
(`--dump-dom`) must be told how long to wait, on a clock of its own (`--virtual-time-budget`) that runs through while
the decoding of large textures takes real time.
"""

from __future__ import annotations

import functools
import http.server
import json
import queue
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from engine.proof.libraries import PATIENCE_S, absent
from engine.proof.square import Drawn, lamp, windows
from engine.storage.atomic import write_bytes

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars", "--disable-sync",
    "--disable-background-networking", "--disable-component-update", "--use-gl=angle",
    "--use-angle=swiftshader-webgl",
)  # fmt: skip

#: Path of the image that the page sends, RGBA as float32 from the bottom up; words of a failure have another.
IMAGE = "/picture"

RESOURCES = Path(__file__).resolve().parents[2] / "resources"
NODE = (Path.cwd() / "build" / "node" / "node_modules", RESOURCES.parent / "build" / "node" / "node_modules")

#: Entry points around shaders, by the suffixes of these, and the options of glslang for each.
_ENTRIES = {
    ".glsl": ("#version 330 core\n{}\nvoid main() {{}}\n", "-S", "frag"),
    ".hlsl": ("{}\nfloat4 main() : SV_Target {{ return 0.0; }}\n", "-D", "-V", "-S", "frag", "-e", "main"),
}

_VALIDATE = """
const validator = require(process.argv[2]);
validator.validateBytes(new Uint8Array(require('fs').readFileSync(process.argv[1]))).then(
  (report) => console.log(JSON.stringify(report.issues)));
"""


def three(folder: Path, size: tuple[int, int]) -> Drawn:
    """The material of a `.glb` in `folder` on the square, as three.js draws it, of maps of `size` (H, W)."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    package = _package("three")
    if browser is None:
        return absent("gltf", "three.js", "no Chromium is installed")
    if package is None:
        return absent("gltf", "three.js", "npm install --prefix build/node three was not run")
    version = json.loads((package / "package.json").read_text(encoding="utf-8"))["version"]
    name = f"three.js {version} in Chromium"
    (file,) = folder.glob("*.glb")
    (height, width), shares = windows(size)
    asked = {"width": width, "height": height, "across": shares[1], "up": shares[0], "lamp": lamp().tolist()}
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as place:
        site = Path(place)
        (site / "material.glb").symlink_to(file.resolve())
        (site / "three").symlink_to(package.resolve())
        page = (RESOURCES / "proof" / "three.html").read_text(encoding="utf-8")
        write_bytes(site / "index.html", page.replace("@ASKED@", json.dumps(asked)).encode())
        kind, sent = _receive_from_page(browser, site, max_bytes=max(16 * width * height, 1 << 16))
    if kind != IMAGE or len(sent) != 16 * width * height:
        return Drawn("gltf", name, None, f"It draws nothing: {sent.decode(errors='replace')[:200]}.", False)
    values = np.frombuffer(sent, "<f4").reshape(height, width, 4)[::-1, :, :3]
    return Drawn("gltf", name, values.astype(np.float64), "It loads the file with GLTFLoader.")


def _receive_from_page(browser: str, site: Path, max_bytes: int) -> tuple[str, bytes]:
    """The path and the body that the page of a folder sends to it, within `PATIENCE_S`; the browser is ended then."""
    with serve(site, max_bytes) as (address, sent):
        words = [browser, *ARGUMENTS, f"--user-data-dir={site / 'profile'}", f"{address}/index.html"]
        end = time.monotonic() + PATIENCE_S
        with subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            try:
                while time.monotonic() < end:
                    try:
                        return sent.get(timeout=0.2)
                    except queue.Empty:
                        if process.poll() is not None:
                            return "", b"the browser ended early"
            finally:
                process.terminate()
    return "", f"no answer within {PATIENCE_S} s".encode()


def validator(folder: Path) -> Drawn:
    """Khronos' validator on the `.glb` of `folder`."""
    node, package = shutil.which("node"), _package("gltf-validator")
    if node is None or package is None:
        return absent("gltf", "glTF validator", "npm install --prefix build/node gltf-validator was not run")
    version = json.loads((package / "package.json").read_text(encoding="utf-8"))["version"]
    (file,) = folder.glob("*.glb")
    done = subprocess.run(
        [node, "-e", _VALIDATE, str(file), str(package)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    name = f"Khronos glTF validator {version}"
    if done.returncode:
        return Drawn("gltf", name, None, f"It ends with code {done.returncode}.", False)
    issues = json.loads(done.stdout)
    count = issues["numErrors"] + issues["numWarnings"]
    words = f"{issues['numErrors']} errors and {issues['numWarnings']} warnings. It draws no images."
    return Drawn("gltf", name, None, words, count == 0)


def glslang(folder: Path) -> Drawn:
    """The GLSL and the HLSL of `folder` compiled by glslang, each with an entry point beside it."""
    compiler = shutil.which("glslangValidator")
    if compiler is None:
        return absent("shaders", "glslang", "the Debian package glslang-tools is not installed")
    version = subprocess.run([compiler, "--version"], capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    number = next((line for line in version.stdout.splitlines() if "Glslang" in line), "glslang").split(":")[-1]
    complaints, compiled = [], []
    with tempfile.TemporaryDirectory() as place:
        for suffix, (entry, *options) in _ENTRIES.items():
            (source,) = folder.glob(f"*{suffix}")
            whole = Path(place) / f"whole{suffix}"
            write_bytes(whole, entry.format(source.read_text(encoding="utf-8")).encode())
            words = [compiler, *options, str(whole)]
            done = subprocess.run(words, capture_output=True, text=True, timeout=PATIENCE_S, check=False, cwd=place)
            compiled.append(source.name)
            complaints += [line for line in done.stdout.splitlines() if "ERROR" in line][:1] if done.returncode else []
    words_of_it = complaints[0][:160] if complaints else f"{' and '.join(compiled)} compile"
    return Drawn("shaders", f"glslang {number}", None, f"{words_of_it}. It draws no images.", not complaints)


@contextmanager
def serve(folder: Path, max_bytes: int) -> Iterator[tuple[str, queue.Queue[tuple[str, bytes]]]]:
    """The address at which this machine, and no other, finds the files of a folder, and what is sent there.

    That is a path and a body of at most `max_bytes` bytes each.
    """
    sent: queue.Queue[tuple[str, bytes]] = queue.Queue()

    class Handler(http.server.SimpleHTTPRequestHandler):
        def do_POST(self) -> None:
            length = int(self.headers.get("Content-Length", 0))
            body = self.rfile.read(length) if 0 <= length <= max_bytes else b""
            self.send_response(204)
            self.end_headers()
            sent.put((self.path, body))

        def log_message(self, *_words: object) -> None:
            """Say nothing of each request."""

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Handler, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_address[1]}", sent
    finally:
        server.shutdown()
        server.server_close()


def _package(name: str) -> Path | None:
    return next((place / name for place in NODE if (place / name / "package.json").is_file()), None)
