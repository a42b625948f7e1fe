"""Measured errors of exports, kept beside the project under the hash of what they depend on.

That is the material, its photographs with those that are in use, and, of textures, their settings. So an error is
measured once for the same input, whatever was undone, closed or saved elsewhere meanwhile. Each target has a file of
some 50 kB, which holds its errors and an image of its preview sphere; it may be removed at any time.
"""

from __future__ import annotations

import base64
import json
import logging
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from app.document.document import Project
from app.project.made import keep_newest, key_of, use
from engine.capture.stack import RECORD
from engine.core.errors import FileError, InputError
from engine.core.health import Health
from engine.core.steps import Step, Steps
from engine.storage.atomic import make_folder, write_json
from engine.storage.untrusted import read_bytes

if TYPE_CHECKING:
    from engine.exchange.export import Offer

log = logging.getLogger(__name__)

#: Raised with each change after which equal input gives other errors, or files have another form.
FORMAT = 1

#: The name under which the material itself is kept, beside those of the targets.
OWN = "material"

#: Files that a data folder keeps.
MAX_KEPT = 400

#: Largest file that is read, in bytes, and the longest side of a ball in pixels.
MAX_BYTES, MAX_SIDE = 1 << 20, 512

_NAME = "loss-"

#: Figures of an entry that are numbers or not known, and further look-ups of which an entry may state the errors.
FIGURES = ("rmse_rel", "rmse_rel_reference", "flip", "bytes", "bytes_per_texel")
OWN_FIGURES = ("brdf_fit_rmse_rel", "rmse_rel_power_law")
LOOK_UPS = ("slices", "power_law", "power_law_alone")
ENVIRONMENT_FIGURES = ("rmse_rel", "flip")


def keys_of(project: Project, names: Sequence[str]) -> Steps[dict[str, str]]:
    """The name of the file of each target, by target; none for a material that is not a value of the document.

    Hashing takes about 1 s for 1 GB of maps in memory; those that are mapped from their files are not hashed.
    """
    yield Step(0.0, "looking for errors that were measured before")
    exporting, stack = project.exporting, project.stack
    bare = replace(project.material, name="", health=Health())
    photographs = stack.folder / RECORD if stack is not None and stack.folder is not None else stack
    try:
        subject = key_of(bare, photographs, sorted(project.excluded), project.white)
        choices = {"textures": exporting.of_textures}
        return {name: f"{_NAME}{key_of(FORMAT, subject, name, choices.get(name, ()))}.json" for name in names}
    except (TypeError, ValueError, OSError) as error:
        log.info("errors of exports are not kept: %s", error)
        return {}


def find_kept(keys: Mapping[str, str], folders: Sequence[Path]) -> dict[str, Offer]:
    """Errors that were measured before, by target; a file that is damaged is left out, and the log names it."""
    found = {}
    for name, key in keys.items():
        for place in (folder / key for folder in folders):
            if not place.exists():
                continue
            try:
                found[name] = _read(place, name)
                use(place)
                break
            except InputError as error:
                log.warning("%s", error)
    return found


def keep(key: str, offer: Offer, folder: Path) -> None:
    """Write what was measured of a target. Where that is not possible, a line of the log says so."""
    sphere = offer.sphere
    pixels = None if sphere is None else base64.b64encode(zlib.compress(sphere.tobytes())).decode()
    names = (*FIGURES, *OWN_FIGURES, *LOOK_UPS, "by_environment", "warnings")
    content = {
        "lightarc_loss": FORMAT,
        "entry": {name: offer.entry[name] for name in names if name in offer.entry},
        "why_not": offer.why_not,
        "size": None if sphere is None else sphere.shape[:2],
        "ball": pixels,
    }
    try:
        make_folder(folder)
        write_json(folder / key, content)
    except (FileError, OSError) as error:
        log.warning("The error of %s is not kept: %s", offer.target, error)
        return
    keep_newest(folder, f"{_NAME}*.json", MAX_KEPT)


def _read(place: Path, target: str) -> Offer:
    from engine.exchange.export import Offer

    try:
        said = json.loads(read_bytes(place, MAX_BYTES))
        if said["lightarc_loss"] != FORMAT:
            raise ValueError("another format")
        why_not = str(said["why_not"])[:400]
        sphere = None if said["ball"] is None else _sphere(said["ball"], *said["size"])
        return Offer(target, {} if why_not else _entry(said["entry"]), sphere, why_not)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, zlib.error) as error:
        raise InputError(place, f"is damaged ({error})", "The error is measured again when you ask for it") from None


def _entry(said: Mapping[str, Any]) -> dict[str, Any]:
    """The entry of a record as far as it is kept; ValueError for what none can be."""
    entry: dict[str, Any] = {name: _figure(said[name]) for name in (*FIGURES, *OWN_FIGURES) if name in said}
    entry |= {name: _entry(said[name]) for name in LOOK_UPS if name in said}
    if "by_environment" in said:
        entry["by_environment"] = {
            str(light)[:40]: {name: _figure(errors[name]) for name in ENVIRONMENT_FIGURES}
            for light, errors in said["by_environment"].items()
        }
    if "warnings" in said:
        entry["warnings"] = [str(words)[:400] for words in said["warnings"]]
    return entry


def _figure(value: object) -> float | int | None:
    if value is None or (isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < np.inf):
        return value
    raise ValueError(f"no figure: {value!r:.40}")


def _sphere(text: str, height: int, width: int) -> NDArray[np.uint8]:
    """(H, W, 4) codes; ValueError for another size than the file says."""
    if not (type(height) is type(width) is int and 0 < height <= MAX_SIDE and 0 < width <= MAX_SIDE):
        raise ValueError("a ball of no size")
    size = 4 * height * width
    pixels = zlib.decompressobj().decompress(base64.b64decode(text, validate=True), size + 1)
    if len(pixels) != size:
        raise ValueError("a ball of another size")
    return np.frombuffer(pixels, np.uint8).reshape(height, width, 4)
