"""How hypothesis looks for examples: the same way every time, however slow the machine is.

``HYPOTHESIS_PROFILE=default pytest`` looks for others each time. And no test leaves files open.
"""

import os
from collections.abc import Iterator

import pytest
from hypothesis import settings

from support.open_nodes import close_all

settings.register_profile("steady", deadline=None, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))


@pytest.fixture(autouse=True)
def nodes_end_with_their_test() -> Iterator[None]:
    """Close the nodes that a test opened and left."""
    yield
    close_all()
