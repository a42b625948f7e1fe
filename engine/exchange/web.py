"""Web pages: the page of a bundle as one file, and in parts for sites whose policy allows no code within a page.

The page draws with WebGL 2 and loads nothing from elsewhere. As one file, `NAME.html`, it opens from a disk. The folder
`strict` holds the same page as HTML without code or styles, a script, a style sheet and PNG pictures, and works under
`Content-Security-Policy: default-src 'self'` where a server sends it (pictures of a disk may not become textures).
`embed.html` is the snippet that puts it into another page. Maps are those of the page of a bundle: 16 bits, at most
1024 texels a side.
"""

from __future__ import annotations

import base64
import re

from engine.bundle.portable import viewer
from engine.core.steps import Step, Steps
from engine.exchange.loss import Shown, material_shown
from engine.exchange.subject import Contents, Settings, Subject, fit_warnings

_PICTURE = re.compile(r'"(iVBOR[A-Za-z0-9+/=]*)"')
_STYLE = re.compile(r"<style>(.*?)</style>", re.DOTALL)
_SCRIPT = re.compile(r"<script>(.*?)</script>", re.DOTALL)
_POLICY = re.compile(r"""content="default-src 'none';[^"]*\"""")

#: The script's way to a picture within the page, and that to one beside it.
_WITHIN, _BESIDE = '"data:image/png;base64," + text', "text"

_EMBED = """<iframe src="strict/index.html" title="{name}" width="900" height="600" loading="lazy"
  style="border: 0" sandbox="allow-scripts allow-same-origin"></iframe>
"""


def shown(subject: Subject, _settings: Settings) -> Shown | None:
    """The power law or the planes."""
    if subject.material.power_law is None and subject.material.directional is None:
        return None
    return subject.kept("power-law", lambda: material_shown(subject.portable, "power-law"))


def contents(subject: Subject, _settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.html`, `strict` and `embed.html`; UsageError for a material without a power law or planes."""
    yield Step(0.0, "writing the page")
    page = viewer(subject.material, loss)
    files = {f"{subject.name}.html": page.encode(), **strict(page)}
    files["embed.html"] = _EMBED.format(name=subject.name).encode()
    return Contents(files, 24.0, fit_warnings(subject))


def strict(page: str) -> dict[str, bytes]:
    """The parts of a page, by path; ValueError where it is not built as the one of resources/viewer is."""
    parts = [pattern.findall(page) for pattern in (_STYLE, _SCRIPT, _POLICY)]
    if [len(found) for found in parts] != [1, 1, 1] or page.count(_WITHIN) != 1:
        raise ValueError("the page has not one style sheet, one script, one policy and one way to pictures")
    files = {"strict/lightarc.css": parts[0][0].encode(), "strict/lightarc.js": b""}
    names: dict[str, str] = {}

    def beside(found: re.Match[str]) -> str:
        name = names.setdefault(found[1], f"map_{len(names)}.png")
        files[f"strict/{name}"] = base64.b64decode(found[1])
        return f'"{name}"'

    files["strict/lightarc.js"] = parts[1][0].replace(_WITHIN, _BESIDE).encode()
    page = _STYLE.sub('<link rel="stylesheet" href="lightarc.css">', page)
    page = _SCRIPT.sub('<script src="lightarc.js"></script>', page)
    page = _POLICY.sub("content=\"default-src 'self'\"", page)
    files["strict/index.html"] = _PICTURE.sub(beside, page).encode()
    return files
