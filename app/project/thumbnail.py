"""A small image of a project, beside its file: the material as its photographs show it under the highest light.

It stands for the project in lists of recent ones and after a crash, and is written anew when the material changes.
So is its title, the name of the material: lists show both without opening the project, which may be damaged or large.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.document.document import Project
from app.project.pixels import are_there
from app.project.project_file import data_folder
from engine.core.colour import srgb_encode
from engine.core.errors import FileError
from engine.core.steps import Step, Steps
from engine.storage.atomic import write_bytes
from engine.storage.untrusted import read_bytes

#: Width and height in pixels.
SIZE = (96, 72)

#: The share of texels that are darker than white.
WHITE = 0.98

#: Direction of the light of a directional map: from the upper left, at 45°.
UPPER_LEFT = np.array([-0.5, 0.5, np.sqrt(0.5)])


#: Letters of a title, and bytes of the file that has it, at most.
MAX_TITLE, MAX_TITLE_BYTES = 80, 4096


def title_of(path: Path) -> str:
    """The title of the project at `path`, on one line; empty where none is kept, or none that can be shown."""
    try:
        content = read_bytes(_title_file(path), MAX_TITLE_BYTES)
    except (FileError, OSError):
        return ""
    title = "".join(letter if letter.isprintable() else " " for letter in content.decode("utf-8", "replace"))
    return " ".join(title.split())[:MAX_TITLE]


def _title_file(path: Path) -> Path:
    return data_folder(path) / "title.txt"


def thumbnail_of(path: Path) -> Path:
    """The file of the image of the project at `path`; it may not exist."""
    return data_folder(path) / "thumbnail.png"


def list_image_parts(project: Project) -> tuple[object, ...]:
    """Parts of a document that its image is made of."""
    material = project.material
    return (material.shading_map, material.power_law, material.directional, project.stack)


def image_of(project: Project) -> NDArray[np.uint8] | None:
    """(72, 96, 3) uint8, sRGB-coded: the middle of the brightest slice, of planes lit from the upper left, or of the
    brightest photograph.

    None where the project has neither.
    """
    shading_map, power_law, stack = project.material.shading_map, project.material.power_law, project.stack
    directional = project.material.directional
    if shading_map is not None:
        radiance = shading_map.slices[-1]
    elif power_law is not None:
        radiance = power_law.scale
    elif directional is not None:
        radiance = directional.image(UPPER_LEFT)
    elif stack is not None and are_there(stack):
        radiance = stack.radiance[int(np.argmax(stack.mean_radiance))]
    else:
        return None
    height, width = radiance.shape[:2]
    step = max(1, min(width // SIZE[0], height // SIZE[1]))
    across, down = min(width, step * SIZE[0]) // step, min(height, step * SIZE[1]) // step
    left, top = (width - step * across) // 2, (height - step * down) // 2
    cut = np.asarray(radiance[top : top + step * down, left : left + step * across], np.float32)
    small = np.nan_to_num(cut.reshape(down, step, across, step, 3).mean(axis=(1, 3)), posinf=0.0)
    white = float(np.quantile(small, WHITE)) or 1.0
    image = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
    rows, columns = (SIZE[1] - down) // 2, (SIZE[0] - across) // 2
    coded = np.round(255.0 * srgb_encode(np.clip(small / white, 0.0, 1.0)))
    image[rows : rows + down, columns : columns + across] = coded.astype(np.uint8)
    return image


def keep_thumbnail(path: Path, project: Project) -> Steps[None]:
    """Write image and title of `project` next to its file. Raises OutputError where that cannot be done."""
    yield Step(0.0, "making a small image")
    from engine.images.encode import encode_png

    write_bytes(_title_file(path), project.name[:MAX_TITLE].encode())

    image = image_of(project)
    if image is not None:
        write_bytes(thumbnail_of(path), encode_png(image))
