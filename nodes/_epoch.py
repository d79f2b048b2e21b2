"""The name of one run of a writer of state."""

import time


def new_epoch() -> int:
    """Return the milliseconds since 1970: new for every start of a process, and below 2**53.

    Beyond 2**53 a JSON reader that keeps numbers as doubles would round it.
    """
    return time.time_ns() // 1_000_000
