"""Labels of plots and scales."""

from __future__ import annotations

import pytest

from app.widgets.plots import scale_labels


@pytest.mark.parametrize(
    ("low", "high", "labels"),
    [
        (-0.82, 2.54, ["-0.82", "0.02", "0.86", "1.70", "2.54"]),
        (0.0, 96.0, ["0", "24", "48", "72", "96"]),
        (-75.0, 22.0, ["-75", "-51", "-26", "-2", "22"]),
        (0.0, 10.0, ["0.0", "2.5", "5.0", "7.5", "10.0"]),
        (0.0, 0.004, ["0.000", "0.001", "0.002", "0.003", "0.004"]),
    ],
)
def test_labels_of_a_scale_have_equal_decimals(low: float, high: float, labels: list[str]) -> None:
    assert scale_labels(low, high) == labels
