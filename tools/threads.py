"""One thread for each numerical library in a process."""

import os

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "NUMEXPR_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}
"""Several processes, or nodes in one, share the cores; pools of one thread per core in each would
fight for them: mapping a keyframe takes twice as long with them."""


def use_one_thread() -> None:
    """Say so to the libraries that are not loaded yet; what the environment says goes first."""
    for name, count in ONE_THREAD.items():
        os.environ.setdefault(name, count)
