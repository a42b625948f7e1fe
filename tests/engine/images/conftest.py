"""Pictures written to a temporary folder and read back through the child."""

import pytest

from engine.images.decode import read_image


@pytest.fixture
def read(tmp_path):
    def write_and_read(content, name="picture", **options):
        path = tmp_path / name
        path.write_bytes(content)
        return read_image(path, **options)

    return write_and_read
