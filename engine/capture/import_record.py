"""Record of an import: the state of each photograph, contradictions between them, and the processing.

Cost: none worth mentioning; all figures were taken while the pixels were read and written.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.capture.lights.file_names import as_text, printable
from engine.capture.photograph.decode import Photograph
from engine.capture.photograph.exposures import group
from engine.capture.registration.pair_motion import Alignment
from engine.capture.report import Quality
from engine.capture.tally import Tally
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict

Light = Sequence[Photograph]

#: Photographs from which the same remark about each is one.
MANY = 4


def refuse_different_sizes(photographs: Sequence[Path], sizes: Sequence[tuple[int, int]]) -> None:
    """InputError that names the photographs whose (width, height) is not the usual one."""
    (usual, usual_count), *others = Counter(sizes).most_common()
    if not others:
        return
    names = [printable(path) for path in photographs]
    odd = [f"{name} has {w} × {h}" for name, (w, h) in zip(names, sizes, strict=True) if (w, h) != usual]
    more = f" and {len(odd) - 8} more differ" if len(odd) > 8 else ""
    problem = (
        f"{usual_count} of {len(names)} photographs have {usual[0]} × {usual[1]} px, but {', '.join(odd[:8])}{more}"
    )
    raise InputError(photographs[0].parent, problem, "Leave these out, or crop them to the size of the others")


def refuse_equal_images(photographs: Sequence[Path], images: Sequence[NDArray[np.float32]]) -> None:
    """Two lights never give the same pixels, unless these are all alike (black, or white)."""
    seen: dict[Hashable, str] = {}
    for path, image in zip(photographs, images, strict=True):
        if image.size and image.min() < image.max():
            first = seen.setdefault(image.tobytes(), printable(path))
            if first != printable(path):
                problem = f"{first} and {printable(path)} are the same image"
                raise InputError(path.parent, problem, "Leave one of them out")


def contradictions(lights: Sequence[Light]) -> list[Finding]:
    """Differences between photographs that should be alike, and the decoder's warnings."""
    photographs = [photograph for light in lights for photograph in light]
    findings = [finding for warning, names in _by_warning(photographs).items() for finding in _about(warning, names)]
    findings += [Finding(Verdict.NOTE, f"Colour profile {name} was applied") for name in profiles(lights)]
    findings += [
        Finding(
            Verdict.NOTE,
            f"Colours of {camera} were converted to linear Rec.709 by the camera matrix of {source}, without a profile",
        )
        for camera, source in sorted(
            {(one.camera or "the camera", one.matrix_source) for one in photographs if one.matrix_source}
        )
    ]
    for text, key in (
        ("Bit depths differ: {}. Each is scaled by its own white level", lambda p: f"{p.bit_depth} bit"),
        ("Cameras differ: {}. Leave out those that do not belong", lambda p: p.camera or "unknown"),
        ("Transfer functions differ: {}. State transfer in capture.toml", lambda p: p.transfer),
        ("Colour profiles differ: {}. Each was applied", lambda p: p.profile or "none"),
        ("White balances differ: {}. Give one for all with --white-balance", _balance),
    ):
        table = _table(photographs, key)
        if ";" in table:
            findings.append(Finding(Verdict.WARNING, text.format(table)))
    return findings


def profiles(lights: Sequence[Light]) -> list[str]:
    """The names of the colour spaces that files of the lights state and that were applied."""
    return sorted({photograph.profile for light in lights for photograph in light if photograph.profile})


def _by_warning(photographs: Sequence[Photograph]) -> dict[str, list[str]]:
    """The names of the photographs of which each warning is said."""
    found: dict[str, list[str]] = {}
    for photograph in photographs:
        for warning in photograph.warnings:
            found.setdefault(warning, []).append(printable(photograph.path))
    return found


def _about(warning: str, names: list[str]) -> list[Finding]:
    """One finding for each photograph of a few, and one of many."""
    if len(names) < MANY:
        return [Finding(Verdict.WARNING, warning, name) for name in names]
    return [Finding(Verdict.WARNING, f"{warning} ({len(names)} photographs, {names[0]} first)")]


def _balance(photograph: Photograph) -> str:
    return " : ".join(f"{value:.2f}" for value in photograph.white_balance)


def _table(photographs: Sequence[Photograph], key: Callable[[Photograph], str]) -> str:
    return group([(key(photograph), printable(photograph.path)) for photograph in photographs])


def qualities(
    tallies: Sequence[Tally],
    pixels: int,
    noise_and_sharpness: Sequence[tuple[float, float]],
    alignment: Alignment,
    errors: Sequence[float | None],
) -> list[Quality]:
    """The figures of each light."""
    residuals = [None if np.isnan(residual) else float(residual) for residual in alignment.residual_px]
    return [
        Quality(one.clipped / pixels, one.black / pixels, noise, sharpness, residual, error)
        for one, (noise, sharpness), residual, error in zip(
            tallies, noise_and_sharpness, residuals, errors, strict=True
        )
    ]


def about_lights(
    lights: Sequence[Light], alignment: Alignment, members: Mapping[str, str], crossed: Collection[Path] = ()
) -> list[dict[str, Any]]:
    """JSON values: what was assumed of the photographs of each light, and how they were moved.

    `members` are the places of files in the archive that they come from, `crossed` those under crossed polarisers.
    """
    return [
        {
            "file": printable(light[0].path),
            **_member(light[0].path, members),
            "camera": light[0].camera,
            "container": light[0].container,
            "bit_depth": light[0].bit_depth,
            "transfer": light[0].transfer,
            "profile": light[0].profile or None,
            "exposure_s": light[0].exposure_s,
            "iso": light[0].iso,
            "aperture": light[0].aperture,
            "black_level": list(light[0].black_level),
            "white_level": list(light[0].white_level),
            "white_balance": list(light[0].white_balance),
            "camera_matrix": list(light[0].camera_matrix) or None,
            "matrix_source": light[0].matrix_source or None,
            "exposures": [
                {"file": printable(one.path), **_member(one.path, members), "exposure_s": one.exposure_s}
                for one in light
                if one.path not in crossed
            ],
            "crossed": next(
                (
                    {"file": printable(one.path), **_member(one.path, members), "exposure_s": one.exposure_s}
                    for one in light
                    if one.path in crossed
                ),
                None,
            ),
            "alignment_matrix": [float(value) for value in matrix.ravel()],
        }
        for light, matrix in zip(lights, alignment.matrix, strict=True)
    ]


def _member(path: Path, members: Mapping[str, str]) -> dict[str, str]:
    return {"member": as_text(members[path.name])} if path.name in members else {}
