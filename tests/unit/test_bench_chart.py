"""The picture of a bench: bars as long as their ratios, and curves as high as their values."""

import numpy as np

from sceneq_core.arrays import UInt8
from sceneq_tools.bench.chart import BAR_LEFT, BAR_RIGHT, BLUE, WIDTH, chart
from sceneq_tools.bench.measurement import Measurement
from sceneq_tools.bench.stopwatch import Stopwatch


def is_blue(image: UInt8) -> np.ndarray:
    return (image == BLUE).all(axis=2)


def test_bars_begin_at_1x_and_follow_the_logarithm() -> None:
    measured = [
        Measurement("slow", 100.0, "ms", "copy", 1.0),
        Measurement("ten", 1.0, "ms", "c", 10),
    ]
    image = chart({"codec": measured})
    assert image.shape[1:] == (WIDTH, 3)
    lengths = [int(row.sum()) for row in is_blue(image)]
    longer, shorter = (max(part) for part in np.array_split(lengths, [_middle(lengths)]))
    quarter = (BAR_RIGHT - BAR_LEFT) / 4
    assert abs(longer - 2 * quarter) <= 2  # 100x on a scale to 100x
    assert abs(shorter - quarter) <= 2  # 0.1x


def _middle(lengths: list[int]) -> int:
    rows = np.flatnonzero(lengths)
    return int(rows[np.argmax(np.diff(rows))]) + 1


def test_what_has_no_ratio_and_no_series_is_not_drawn() -> None:
    assert not is_blue(chart({"codec": [Measurement("size", 3.0, "MB")]})).any()
    assert not is_blue(chart({})).any()


def test_a_series_is_a_curve_from_0() -> None:
    grown = Measurement("memory at most", 8.0, "MiB", series=(0.0, 4.0, 8.0))
    rows, columns = np.nonzero(is_blue(chart({"stages": [grown]})))
    first, last = rows[columns == columns.min()].max(), rows[columns == columns.max()].min()
    middle = rows[np.abs(columns - (columns.min() + columns.max()) / 2) < 1].mean()
    assert first > last
    assert abs(middle - (first + last) / 2) < 3


def test_a_stopwatch_says_what_was_called() -> None:
    heard: list[str] = []
    with Stopwatch(heard.append).watching({"plan": "sceneq_tools.bench.measurement:median"}):
        from sceneq_tools.bench import measurement

        assert measurement.median([1.0, 3.0]) == 2.0
    assert heard == ["plan"]
    measurement.median([1.0])
    assert heard == ["plan"]
