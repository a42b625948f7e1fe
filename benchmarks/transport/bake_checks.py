"""Default bakes of generated scenes: how many differ from the reference, and how many of these without a warning.

The bake knows neither the environment of its scene nor the views: it is checked under the program's own lights
(`engine.accuracy.bake_check`), and the image is judged from three other sides. A wrong image without a warning is
silent; a warning of an image that is right is a false alarm.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.measure import Accuracy
from benchmarks.transport.generated_scenes import generate
from benchmarks.transport.predictions import check_campaign
from engine.accuracy.bake_check import check_bake, compare_views, find_fronts
from engine.core.directions import world_direction
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, drain
from engine.geometry.camera import frame
from engine.render.reference import reference
from engine.render.transported import image_of
from engine.scene.scene import Scene
from engine.transport.baking.check import BakeCheck, LightCheck, warnings_at_render
from engine.transport.method import Method, Subject, method_of, names
from engine.transport.relight import light_of

#: Angles of the views in radians, pixels along a side of an image, and paths in each.
VIEWS = ((1.0, 1.2), (1.3, 3.6), (0.7, 5.3))
EDGE, PATHS = 64, 128

#: Vertices of the largest model that is baked in Gaussians.
FEW = 3000

#: Scenes where nobody says how many, and the share of wrong images that may be silent.
SCENES, SILENT = 10, 0.0


@dataclass(frozen=True)
class Judged:
    """One image of a default bake of a scene, and the warnings at its render, without and with the scene known."""

    seed: int
    scene: str
    mode: str
    found: LightCheck
    warned: bool
    warned_knowing: bool

    @property
    def is_wrong(self) -> bool:
        return not self.found.passes


def bake_checks(
    _folder: Path, *, scenes: int = SCENES, seed: int = 0, data: Path | None = None, modes: Sequence[str] | None = None
) -> Steps[list[Accuracy]]:
    """Judge default bakes of so many scenes, from `seed` on; files of the folder `data` join models and BRDFs."""
    check_campaign(scenes, data)
    found: list[Judged] = []
    for number in range(scenes):
        yield Step(number / scenes, f"baking scene {seed + number}")
        name, scene = generate(seed + number, data)
        for mode in modes or names():
            if mode in names() and (mode != "gaussian" or len(scene.mesh.positions) <= FEW):
                found += judge(seed + number, name, scene, method_of(mode))
    if not found:
        raise UsageError(f"none of these {scenes} scenes can be baked: ask for more")
    return summary(found)


def judge(seed: int, name: str, scene: Scene, method: Method) -> list[Judged]:
    """The image of a default bake; nothing where the method refuses the BRDF."""
    subject, settings = Subject(scene.mesh, scene.brdf), method.settings()
    assert scene.environment is not None
    with tempfile.TemporaryDirectory(prefix="lightarc-") as folder:
        try:
            work = drain(method.baking.prepare(subject, settings))
        except UsageError:
            return []
        transport = drain(method.baking.bake(Path(folder) / "bench.transport", work)).transport
        check = drain(check_bake(transport, method, subject, settings))
        knowing = drain(check_bake(transport, method, subject, settings, [scene.environment]))
        relit = method.baking.relight_transport(transport, light_of(scene), method.light())
        cameras = [frame(scene.mesh.positions, direction=world_direction(*angles)) for angles in VIEWS]
        truths = [drain(reference(replace(scene, camera=camera), (EDGE, EDGE), samples=PATHS)) for camera in cameras]
        images = [drain(image_of(relit, camera, (EDGE, EDGE))).image for camera in cameras]
    light = scene.environment.name
    return [
        Judged(
            seed,
            name,
            method.name,
            compare_views(images, truths, light, [find_fronts(scene.surface, each, EDGE) for each in cameras]),
            _is_warned(check, method, light),
            _is_warned(knowing, method, light),
        )
    ]


def _is_warned(check: BakeCheck | None, method: Method, light: str) -> bool:
    return bool(warnings_at_render(check, method.name, light))


def summary(found: Sequence[Judged]) -> list[Accuracy]:
    """The figures of a campaign, all modes together and each by itself."""
    said = []
    for mode in ("all", *dict.fromkeys(each.mode for each in found)):
        mine = [each for each in found if mode in ("all", each.mode)]
        wrong = [each for each in mine if each.is_wrong]
        silent = [each for each in wrong if not each.warned]
        alarms = sum(each.warned for each in mine if not each.is_wrong)
        count = f"{len(mine)} default bakes ({mode})"
        said.append(
            Accuracy(f"bake-checks-wrong-{mode}", len(wrong) / len(mine), f"share of {count} whose image is wrong")
        )
        worst = max(silent, key=lambda each: abs(each.found.mean_rel), default=None)
        where = (
            "" if worst is None else f"; the worst {percent(worst.found.mean_rel)} at seed {worst.seed}, {worst.scene}"
        )
        what = f"share of {count} whose image is wrong without a warning{where}"
        said.append(Accuracy(f"bake-checks-silent-{mode}", len(silent) / len(mine), what, SILENT))
        knowing = sum(not each.warned_knowing for each in wrong) / len(mine)
        what = f"the same where the bake is checked under the environment of the scene, share of {count}"
        said.append(Accuracy(f"bake-checks-silent-knowing-{mode}", knowing, what, SILENT))
        said.append(Accuracy(f"bake-checks-alarm-{mode}", alarms / len(mine), f"share of {count} right and warned of"))
    return said
