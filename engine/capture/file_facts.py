"""What all files of a capture tell together: bits of their samples, and how the camera was held.

Programs store 8 to 14 bits in files of 16 without saying so. Floating-point files state no white level, but keep the
plateau at which a converter or the sensor clipped. A camera that looks down tags some photographs as turned
by chance. Neither can be seen in one file, so that the import begins anew where the files together say otherwise.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from engine.capture.import_plan import Plan
from engine.capture.lights.file_names import printable
from engine.capture.photograph.decode import Photograph
from engine.core.errors import InputError
from engine.core.health import Finding, Verdict
from engine.images.exif import orient

#: Bits that are stored in files of 16, and the share of their full scale that a sample has to reach.
NARROW, REACHED = (8, 10, 12, 14), 0.25

#: Elevations of lamps under which photographs share a plateau, so that it is where samples are clipped; one is enough
#: at 1, where programs clip. Decimals of elevations, in radians, that differ.
MIN_PLATEAUS, ELEVATION_DIGITS = 2, 3

#: Part of a photograph that a plateau has at most, but at 1: what shows nothing else is evenly bright, not clipped.
MAX_PLATEAU_SHARE = 0.5

#: Correlation by which photographs that were turned as tagged have to fit the others better than as they are.
CLEARLY_TURNED = 0.1


def decide_files(plan: Plan, lights: Sequence[Sequence[Photograph]], thumbnails: Sequence[NDArray[np.float32]]) -> Plan:
    """The plan with the white level and the orientation of all files; itself where they are as each file says.

    `thumbnails` are those of lights of one size. Raises InputError where photographs were turned indeed.
    """
    files = [photograph for light in lights for photograph in light]
    if plan.options.get("orientation"):
        _refuse_turned(plan, lights, thumbnails)
        return plan
    options, said = dict(plan.options), []
    bits = _narrow_bits(files)
    if bits and not options.get("white_code"):
        options["white_code"] = (1 << bits) - 1
        text = (
            f"No sample of these 16-bit files is above {options['white_code']}: they are taken to hold {bits} bits, "
            f"with {options['white_code']} as the white level"
        )
        said.append(Finding(Verdict.WARNING, text))
    white = _white_of_floats(lights, plan.sources.elevation)
    if white and not options.get("white_samples"):
        options["white_samples"] = white
        text = _about_plateaus(files, white)
        said.append(Finding(Verdict.WARNING, text))
    if len(thumbnails) and all(each.largest_samples for each in files):
        said += [each for each in _about_scale(files, thumbnails) if each not in plan.sources.findings]
    tags = Counter(photograph.orientation for photograph in files)
    if len(tags) > 1 and plan.still_camera:
        options["orientation"], number = tags.most_common(1)[0]
        text = (
            f"EXIF orientations differ ({number} of {len(files)} photographs have {options['orientation']}), as "
            f"cameras that look down tag them by chance: {options['orientation']} is taken for all"
        )
        said.append(Finding(Verdict.WARNING, text))
    if not said:
        return plan
    sources = replace(plan.sources, findings=(*plan.sources.findings, *said))
    return replace(plan, options=options, sources=sources)


def _narrow_bits(files: Sequence[Photograph]) -> int:
    """The fewest of `NARROW` that integer files of 16 bits hold; 0 where they hold more."""
    if any(each.bit_depth != 16 or each.container not in ("TIFF", "PNG") or not each.largest_code for each in files):
        return 0
    largest = max(each.largest_code for each in files)
    return next((bits for bits in NARROW if REACHED * (1 << bits) <= largest < 1 << bits), 0)


def _white_of_floats(lights: Sequence[Sequence[Photograph]], elevation: NDArray[np.float64]) -> tuple[float, ...]:
    """Samples of red, green and blue at which floating-point files are clipped, infinite for a channel that is not;
    empty where none is.

    An even patch is as bright under all lamps of one elevation, so that photographs count once for each elevation.
    """
    floats = [each for light in lights for each in light if each.largest_samples]
    if not floats:
        return ()
    tops = [max(each.largest_samples[channel] for each in floats) for channel in range(3)]
    clipped = set()
    for channel, top in enumerate(tops):
        places = {
            round(float(rise), ELEVATION_DIGITS)
            for light, rise in zip(lights, elevation, strict=True)
            for each in light
            if each.largest_samples and _clipped_at(each, channel, top)
        }
        if len(places) >= (1 if top == 1.0 else MIN_PLATEAUS):
            clipped.add(top)
    return tuple(top if top in clipped else np.inf for top in tops) if clipped else ()


def _clipped_at(photograph: Photograph, channel: int, top: float) -> bool:
    share = photograph.plateaus[channel]
    return photograph.largest_samples[channel] == top and 0.0 < share <= (1.0 if top == 1.0 else MAX_PLATEAU_SHARE)


def _about_plateaus(files: Sequence[Photograph], white: Sequence[float]) -> str:
    floats = [each for each in files if each.largest_samples]
    number = sum(any(_clipped_at(each, channel, white[channel]) for channel in range(3)) for each in floats)
    if len(set(white)) == 1:
        where = f"{white[0]:.4g}"
    else:
        names = zip(("red", "green", "blue"), white, strict=True)
        where = ", ".join(f"{name} {value:.4g}" for name, value in names if value < np.inf)
    return (
        f"Many samples of {number} of {len(files)} floating-point photographs are exactly the largest value ({where}), "
        "and none is above it: they are taken as clipped"
    )


def _about_scale(files: Sequence[Photograph], thumbnails: Sequence[NDArray[np.float32]]) -> list[Finding]:
    """A warning where half of all floating-point samples are above their white level: they may be integer levels."""
    if np.median(np.concatenate([each.ravel() for each in thumbnails])) <= 1.0:
        return []
    largest = max(max(each.largest_samples) for each in files)
    text = (
        f"Most samples of these floating-point photographs are above their white level of 1, up to {largest:.4g}: "
        "where they are 8- or 16-bit levels, divide them by 255 or 65535"
    )
    return [Finding(Verdict.WARNING, text)]


def _refuse_turned(
    plan: Plan, lights: Sequence[Sequence[Photograph]], thumbnails: Sequence[NDArray[np.float32]]
) -> None:
    """InputError where photographs of another tag fit the others clearly better when they are turned by it."""
    common = plan.options["orientation"]
    if len(thumbnails) != len(lights):
        return
    grey = [_middle_square(each.mean(axis=-1)) for each in thumbnails]
    mean = np.mean([each for each, light in zip(grey, lights, strict=True) if light[0].orientation == common], axis=0)
    odd: dict[int, list[float]] = {}
    for each, light in zip(grey, lights, strict=True):
        tag = light[0].orientation
        if tag == common:
            continue
        turned = orient(_undo(each, common), tag)
        odd.setdefault(tag, []).append(_correlate(turned, mean) - _correlate(each, mean))
    for tag, gains in odd.items():
        if np.median(gains) > CLEARLY_TURNED:
            names = [printable(light[0].path) for light in lights if light[0].orientation == tag]
            problem = f"was turned during the capture: EXIF orientation {tag}, and the others have {common}"
            raise InputError(names[0], problem, "Leave it out, or turn its pixels and remove the tag")


def _undo(image: NDArray[np.float32], orientation: int) -> NDArray[np.float32]:
    """The image as it is stored, of an upright one."""
    return orient(image, {6: 8, 8: 6}.get(orientation, orientation))


def _middle_square(image: NDArray[np.float32]) -> NDArray[np.float32]:
    side = min(image.shape)
    top, left = (image.shape[0] - side) // 2, (image.shape[1] - side) // 2
    return image[top : top + side, left : left + side]


def _correlate(one: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    return float(np.corrcoef(np.sqrt(np.maximum(one, 0.0)).ravel(), np.sqrt(np.maximum(other, 0.0)).ravel())[0, 1])
