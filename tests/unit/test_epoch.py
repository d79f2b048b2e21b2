"""The epoch survives a reader with doubles and differs from run to run."""

import pytest

from sceneq_nodes import _epoch
from sceneq_nodes._epoch import new_epoch


def test_an_epoch_is_the_same_as_a_double() -> None:
    epoch = new_epoch()
    assert int(float(epoch)) == epoch < 2**53


def test_a_later_start_has_a_later_epoch(monkeypatch: pytest.MonkeyPatch) -> None:
    now_ns = 1_795_328_658_136_000_000
    monkeypatch.setattr(_epoch.time, "time_ns", lambda: now_ns)
    first = new_epoch()
    monkeypatch.setattr(_epoch.time, "time_ns", lambda: now_ns + 100_000_000)
    assert (first, new_epoch()) == (1_795_328_658_136, 1_795_328_658_236)
