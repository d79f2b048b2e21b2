"""The name of one run of a writer of state."""

import time

RUN_BITS = 32


def new_epoch() -> int:
    """Return the milliseconds since 1970: new for every start of a process, and below 2**53.

    Beyond 2**53 a JSON reader that keeps numbers as doubles would round it.
    """
    return time.time_ns() // 1_000_000


def first_seq(run: int) -> int:
    """Return the number before that of the first delta of a writer that came back ``run`` times.

    More than any run before can have told, whatever of it did not reach the disk. 2**21 runs fit
    into the 2**53 of a JSON reader.
    """
    return run << RUN_BITS
