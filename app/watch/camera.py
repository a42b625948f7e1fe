"""A camera on a cable, by libgphoto2: its photographs are downloaded into a folder as they are taken.

The camera says what it has written; one that says nothing (as a card reader) is looked through, and a file counts that
is as large as before. Photographs that it
held before stay on it, and so do all others: they are copied. In the folder they arrive whole, by a name that nothing
there has.
"""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Collection, Iterator
from pathlib import Path, PurePosixPath
from typing import Any

from engine.capture.photograph.kinds import photograph_suffixes
from engine.core.errors import InputError, MissingCapability
from engine.storage.atomic import write_bytes

#: Seconds between two looks through a camera that says nothing, and milliseconds that one is asked for news.
LOOK_S, ASK_MS = 1.0, 200

#: The most folders of a camera that are looked through.
MAX_FOLDERS = 1000


def find_lack() -> MissingCapability | None:
    """Name what a camera on a cable needs and is missing; None where nothing is."""
    if importlib.util.find_spec("gphoto2") is not None:
        return None
    remedy = "Install it with: pip install 'lightarc[camera]'"
    return MissingCapability("Photographs from a camera need the library gphoto2", remedy)


class Camera:
    """A camera at `port` (`usb:001,004`, `disk:/folder`), or the one that is found, whose photographs go into `folder`.

    It is to be closed. Raises MissingCapability without the library, InputError where there is no camera.
    """

    def __init__(self, folder: Path, port: str = "") -> None:
        if (lack := find_lack()) is not None:
            raise lack
        import gphoto2

        self._library: Any = gphoto2
        self._folder, self._port = folder, port
        try:
            self._camera = self._open()
            self._known = set(self._list())
        except gphoto2.GPhoto2Error as error:
            raise self._failure(error) from None
        self._speaks, self._looked_s = True, time.monotonic()
        self._sizes: dict[tuple[str, str], int] = {}

    @property
    def name(self) -> str:
        """Name of the camera."""
        return str(self._camera.get_abilities().model)

    def wait(self, seconds: float) -> Collection[Path]:
        """Wait for at most `seconds` for a photograph, and download it; the files that have been written.

        Raises InputError where the camera is gone.
        """
        until_s = time.monotonic() + seconds
        try:
            while True:
                found = [self._download(*each) for each in self._find_new()]
                if found or time.monotonic() >= until_s:
                    return [path for path in found if path is not None]
        except self._library.GPhoto2Error as error:
            raise self._failure(error) from None

    def close(self) -> None:
        """Let go of the camera."""
        self._camera.exit()

    def _open(self) -> Any:
        camera = self._library.Camera()
        if self._port:
            ports = self._library.PortInfoList()
            ports.load()
            camera.set_port_info(ports[ports.lookup_path(self._port)])
            if self._port.startswith("disk:"):
                cameras = self._library.CameraAbilitiesList()
                cameras.load()
                camera.set_abilities(cameras[cameras.lookup_model("Directory Browse")])
        camera.init()
        return camera

    def _find_new(self) -> Iterator[tuple[str, str]]:
        """Folder and name of the files that the camera has written since the last time."""
        if self._speaks:
            try:
                kind, event = self._camera.wait_for_event(ASK_MS)
            except self._library.GPhoto2Error as error:
                if error.code != self._library.GP_ERROR_NOT_SUPPORTED:
                    raise
                self._speaks = False
                return
            if kind == self._library.GP_EVENT_FILE_ADDED:
                place = event.folder, event.name
                if place not in self._known:
                    self._known.add(place)
                    yield place
            return
        time.sleep(ASK_MS / 1000.0)
        if time.monotonic() - self._looked_s >= LOOK_S:
            self._looked_s = time.monotonic()
            self._camera.exit()  # it begins again by itself, and forgets what it knew of its files
            unknown = [place for place in self._list() if place not in self._known]
            sizes = {place: self._camera.file_get_info(*place).file.size for place in unknown}
            new = [place for place, size in sizes.items() if size and self._sizes.get(place) == size]
            self._sizes = sizes
            self._known.update(new)
            yield from new

    def _list(self) -> Iterator[tuple[str, str]]:
        """Folder and name of all files of the camera."""
        folders = ["/"]
        for _ in range(MAX_FOLDERS):
            if not folders:
                return
            folder = folders.pop()
            yield from ((folder, name) for name, _ in self._camera.folder_list_files(folder).items())
            folders += [
                str(PurePosixPath(folder) / name) for name, _ in self._camera.folder_list_folders(folder).items()
            ]

    def _download(self, folder: str, name: str) -> Path | None:
        """The file that was written; None for what is no photograph."""
        own = PurePosixPath(name.replace("\\", "/")).name
        if own.startswith(".") or Path(own).suffix.lower() not in photograph_suffixes():
            return None
        file = self._camera.file_get(folder, name, self._library.GP_FILE_TYPE_NORMAL)  # which its content lives in
        target = _free(self._folder / own)
        write_bytes(target, bytes(memoryview(file.get_data_and_size())))
        return target

    def _failure(self, error: Any) -> InputError:
        remedy = "Check that it is switched on, connected, and not in use by another program (as a file manager)"
        return InputError(self._port or "the camera", f"cannot be used ({error})", remedy)


def _free(path: Path) -> Path:
    """The path itself, or with a number where there is a file by that name."""
    number, found = 1, path
    while found.exists():
        number += 1
        found = path.with_stem(f"{path.stem}-{number}")
    return found
