"""Readers of our own that follow published formats and share no line with the writers: RTI files, relit.

PTM 1.2 (Malzbender2001) holds rows from the bottom up and values to 255, HSH 1.2 (Gautron2004) rows from the top and
values to 1; both are codes of sRGB. Lines of a header that begin with # are comments.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np

from engine.proof.square import Drawn, Floats, lamp, middle


def draw_by_hsh(folder: Path) -> Drawn:
    """The `.rti` of `folder`, relit by the lamp."""
    (file,) = folder.glob("*.rti")
    return Drawn("rti", "HSH 1.2, read by its format", linear(relight_hsh(file.read_bytes())), "The .rti, relit.")


def draw_by_ptm(folder: Path) -> Drawn:
    """The `.ptm` of three channels of `folder`, relit by the lamp."""
    file = next(path for path in folder.glob("*.ptm") if not path.stem.endswith("_lrgb"))
    return Drawn("rti", "PTM 1.2, read by its format", linear(relight_ptm(file.read_bytes())), "The .ptm, relit.")


def relight_hsh(content: bytes) -> Floats:
    """(H, W, 3) codes of 255 under the lamp."""
    lines: list[bytes] = []
    while len(lines) < 3:
        line, _, content = content.partition(b"\r\n")
        if not line.startswith(b"#"):
            lines.append(line)
    width, height, channels = (int(word) for word in lines[1].split())
    count = int(lines[2].split()[0])
    scale = np.array(struct.unpack(f"<{count}f", content[: 4 * count]))
    bias = np.array(struct.unpack(f"<{count}f", content[4 * count : 8 * count]))
    codes = np.frombuffer(content[8 * count :], np.uint8).reshape(height, width, channels, count)
    x, y, z = lamp()
    phi, once = np.arctan2(y, x), 2.0 * z - 1.0
    root, less = np.sqrt(max(z - z * z, 0.0)), z * z - z
    weights = [
        np.sqrt(1.0 / (2.0 * np.pi)),
        np.sqrt(6.0 / np.pi) * np.cos(phi) * root,
        np.sqrt(3.0 / (2.0 * np.pi)) * once,
        np.sqrt(6.0 / np.pi) * np.sin(phi) * root,
        np.sqrt(30.0 / np.pi) * np.cos(2.0 * phi) * less,
        np.sqrt(30.0 / np.pi) * np.cos(phi) * once * root,
        np.sqrt(5.0 / (2.0 * np.pi)) * (1.0 + 6.0 * less),
        np.sqrt(30.0 / np.pi) * np.sin(phi) * once * root,
        np.sqrt(30.0 / np.pi) * np.sin(2.0 * phi) * less,
    ]
    return np.asarray(255.0 * ((codes / 255.0 * scale + bias) @ np.array(weights)))


def relight_ptm(content: bytes) -> Floats:
    """(H, W, 3) codes of 255 under the lamp, of PTM_FORMAT_RGB."""
    lines = content.split(b"\n", 6)
    width, height = int(lines[2]), int(lines[3])
    scale, bias = (np.array(line.split(), np.float64) for line in lines[4:6])
    terms = scale * (np.frombuffer(lines[6], np.uint8).reshape(3, height, width, 6) - bias)
    x, y, _ = lamp()
    return np.moveaxis(terms @ np.array([x * x, y * y, x * y, x, y, 1.0]), 0, 2)[::-1]


def linear(codes: Floats) -> Floats:
    """Linear light of the middle of an image of sRGB codes (IEC 61966-2-1)."""
    share = np.clip(middle(codes) / 255.0, 0.0, 1.0)
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
