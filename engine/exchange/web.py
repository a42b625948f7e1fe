"""Web pages: the page of a bundle as one file, and in parts for sites whose policy allows no code within a page.

The page draws with WebGL 2 and loads nothing from elsewhere. As one file, `NAME.html`, it opens from a disk. The folder
`strict` holds the same page as HTML without code or styles, a script, a style sheet and PNG images, and works under
`Content-Security-Policy: default-src 'self'` where a server sends it (images of a disk may not become textures).
`embed.html` is the snippet that puts it into another page. To the page of a bundle it adds the PBR maps as channels,
and a scale bar where the width of the sample is known (`engine.bundle.page`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from engine.bundle.page import VIEWER_SIDE, Extras, viewer_and_parts
from engine.core.steps import Step, Steps
from engine.exchange.loss import Shown, material_shown
from engine.exchange.shaders import law_alone_shown
from engine.exchange.subject import Contents, Files, Settings, Subject, fit_warnings
from engine.exchange.textures import wide_warnings

_EMBED = """<iframe src="strict/index.html" title="{name}" width="900" height="600" loading="lazy"
  style="border: 0" sandbox="allow-scripts allow-same-origin"></iframe>
"""


def show(subject: Subject, settings: Settings) -> Shown | None:
    """The power law in all tiles, or the planes."""
    if subject.material.power_law is None and subject.material.directional is None:
        return None
    if (alone := law_alone_shown(subject, settings)) is not None:
        return alone
    return subject.remember("power-law", lambda: material_shown(subject.portable, "power-law"))


def contents(subject: Subject, settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.html`, `strict` and `embed.html`; UsageError for a material without a power law or planes."""
    yield Step(0.0, "writing the page")
    extras = Extras(loss, subject.maps, settings.width_mm)
    page, parts = viewer_and_parts(subject.material, extras)
    files: dict[str, bytes | Callable[[], bytes]] = {
        f"strict/{path}": partial(parts.__getitem__, path) for path in parts
    }
    files["embed.html"] = _EMBED.format(name=subject.name).encode()
    warnings = (*fit_warnings(subject), *_round(subject), *wide_warnings(subject))
    return Contents(Files(files), 24.0, warnings, pages={f"{subject.name}.html": page})


def _round(subject: Subject) -> list[str]:
    """Sentences on the coding of the maps of a page, which its errors do not count."""
    of_planes = subject.material.directional is not None
    said = [f"the page holds {'the weights of its planes' if of_planes else 'its maps'} in 16 bits"]
    if max(subject.maps.size) > VIEWER_SIDE:
        said.append(f"beyond {VIEWER_SIDE} texels a side the page shows averages, and finer texels in tiles of 8 bits")
    return said
