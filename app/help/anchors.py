"""Anchors of the manual: the name that a heading of a panel's page has in the pages for a browser."""

from __future__ import annotations

import re


def anchor_of(page: str, heading: str = "") -> str:
    """The anchor of a heading, of the whole page where none is given: `panel-view-light`."""
    words = re.sub(r"[^a-z0-9]{1,200}+", "-", f"panel {page} {heading}".lower())
    return words.strip("-")
