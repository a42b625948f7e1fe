"""One line that says what a value is, and a table of the same for notebooks."""

from __future__ import annotations

import base64
import html
from collections.abc import Mapping
from typing import Any


class Summary:
    """Base of values whose parts are too large to print: `summary` says what they are.

    It gives `__repr__`, one line, and `_repr_html_`, a table with the image of `_repr_png_` where the value has one.
    """

    def summary(self) -> Mapping[str, Any]:
        """Return a few short facts about the value, by name."""
        raise NotImplementedError

    def __repr__(self) -> str:
        parts = ", ".join(f"{name}={_text(value)}" for name, value in self.summary().items())
        return f"{type(self).__name__}({parts})"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><th style='text-align:left'>{html.escape(name.replace('_', ' '))}</th>"
            f"<td style='text-align:left'>{html.escape(_text(value).strip(chr(39)))}</td></tr>"
            for name, value in self.summary().items()
        )
        content = getattr(self, "_repr_png_", lambda: None)()
        image = f"<img src='data:image/png;base64,{base64.b64encode(content).decode()}'>" if content else ""
        return f"<div><strong>{html.escape(type(self).__name__)}</strong>{image}<table>{rows}</table></div>"


def _text(value: object) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 200 else f"{text[:199]}…"
