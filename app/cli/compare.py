"""`lightarc compare`: the error of one image against another, in figures and as an image."""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from app.arguments.results import Input, Output, image_by, software
from engine.accuracy.compare import comparison
from engine.accuracy.difference import compute_signed_difference, label
from engine.core.colour import luminance
from engine.core.errors import InputError
from engine.core.figure_text import number, percent
from engine.core.steps import Step, drain
from engine.images.decode import read_image
from engine.images.encode import encode_png
from engine.storage.atomic import write_bytes

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from engine.images.decode import Image

EXAMPLE = "lightarc compare direct.exr reference.exr --difference difference.png"

#: Share of full scale above which a pixel of the mask is taken to be selected.
SELECTED = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "image", type=Input(), metavar="A", help="EXR, HDR, PNG, TIFF or JPEG; compared as linear light"
    )
    parser.add_argument("reference", type=Input(), metavar="B", help="reference; errors are relative to it")
    parser.add_argument(
        "--mask", type=Input(), metavar="M", help="an image of the same size, white at the pixels to compare"
    )
    parser.add_argument(
        "--difference",
        type=Output(image_by("compare", ".png")),
        metavar="OUT.png",
        help="image of A minus B in luminance: orange where A is brighter, blue where it is darker, with its scale",
    )


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    start = time.perf_counter()
    image, reference = (read_image(path) for path in (arguments.image, arguments.reference))
    _same_size(arguments, arguments.image, image, reference)
    valid = _valid(image, reference)
    mask = _mask(arguments, reference)
    _something_left(arguments, valid, mask)
    displayed = not _is_radiance(image) and not _is_radiance(reference)
    wanted = valid if mask is None else valid & mask
    error = drain(comparison(image.pixels, reference.pixels, wanted, displayed=displayed), show)
    scale = _write(arguments, image.pixels, reference.pixels, wanted)
    invalid = int((~valid).sum() if mask is None else (mask & ~valid).sum())
    return {
        "rmse_rel": error.rmse_rel if math.isfinite(error.rmse_rel) else None,
        "flip": error.flip,
        "max_abs": error.max_abs,
        "pixels": error.pixels,
        "invalid_pixels": invalid,
        "flip_range": "displayed" if displayed else "radiance",
        **({} if scale is None else {"difference": arguments.difference, "difference_scale_radiance": scale}),
        "warnings": _warnings(arguments, image, reference, invalid, error.rmse_rel),
        "time_s": time.perf_counter() - start,
    }


def report(result: dict[str, Any]) -> str:
    relative = "–" if result["rmse_rel"] is None else percent(result["rmse_rel"], 3)
    flip, largest = number(result["flip"], 3), number(result["max_abs"], 4)
    return f"relative RMSE {relative}, FLIP {flip}, largest difference {largest}, {result['pixels']} pixels"


def _is_radiance(image: Image) -> bool:
    return image.container in ("EXR", "HDR", "PFM")


def _valid(*images: Image) -> NDArray[np.bool_]:
    """(H, W) where all images are finite; integer images always are."""
    invalid = [image.saturated & ~image.pixels.any(axis=2) for image in images if _is_radiance(image)]
    return ~np.any(invalid, axis=0) if invalid else np.ones(images[0].saturated.shape, np.bool_)


def _mask(arguments: argparse.Namespace, reference: Image) -> NDArray[np.bool_] | None:
    if not arguments.mask:
        return None
    image = read_image(arguments.mask, transfer="linear")
    _same_size(arguments, arguments.mask, image, reference)
    selected: NDArray[np.bool_] = luminance(image.pixels) > SELECTED
    return selected


def _same_size(arguments: argparse.Namespace, path: str, image: Image, reference: Image) -> None:
    sizes = [f"{one.pixels.shape[1]} × {one.pixels.shape[0]}" for one in (image, reference)]
    if sizes[0] != sizes[1]:
        problem = f"has {sizes[0]} pixels, and {arguments.reference} has {sizes[1]}"
        raise InputError(path, problem, "Give images of one size")


def _something_left(arguments: argparse.Namespace, valid: NDArray[np.bool_], mask: NDArray[np.bool_] | None) -> None:
    if mask is not None and not mask.any():
        raise InputError(arguments.mask, "selects no pixel", "Make white what is to be compared")
    if not (valid if mask is None else valid & mask).any():
        problem = f"holds no pixel that is finite here and in {arguments.reference}"
        raise InputError(arguments.image, problem, "Render it again")


def _write(arguments: argparse.Namespace, a: NDArray[Any], b: NDArray[Any], wanted: NDArray[np.bool_]) -> float | None:
    """Write the image of the difference where one is wanted; returns the difference that has full colour."""
    if not arguments.difference:
        return None
    apart, scale = compute_signed_difference(np.where(wanted[..., None], a, 0), np.where(wanted[..., None], b, 0))
    write_bytes(arguments.difference, encode_png(label(apart, scale), software=software("compare")))
    return scale


def _warnings(
    arguments: argparse.Namespace, image: Image, reference: Image, invalid: int, rmse_rel: float
) -> list[str]:
    names = (arguments.image, arguments.reference)
    words = [f"{name}: {text}" for name, one in zip(names, (image, reference), strict=True) for text in one.warnings]
    if invalid:
        words.append(f"{invalid} pixels that are not finite in one of the two were left out")
    if not math.isfinite(rmse_rel):
        words.append(f"{arguments.reference} is black: there is no relative error")
    if _is_radiance(image) != _is_radiance(reference):
        words.append("one image holds radiance and the other display values: they may not be comparable")
    return words
