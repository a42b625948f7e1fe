"""Images written to a temporary folder and read back through the child."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.images.decode import read_image


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., Any]:
    def write_and_read(content: Any, name: str = "picture", **options: Any) -> Any:
        path = tmp_path / name
        path.write_bytes(content)
        return read_image(path, **options)

    return write_and_read
