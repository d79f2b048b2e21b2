"""Libraries of the system, which pip cannot bring."""

import ctypes
import os
from collections.abc import Callable, Mapping

from sceneq_tools.doctor.finding import Finding, ok, problem

LIBRARIES = {
    "libusb-1.0.so.0": "libusb-1.0-0",
    "libGL.so.1": "libgl1",
    "libEGL.so.1": "libegl1",
    "libX11.so.6": "libx11-6",
    "libudev.so.1": "libudev1",
    "libidn2.so.0": "libidn2-0",
    "libgomp.so.1": "libgomp1",
}
"""What Open3D (and torch: libgomp) load, and Debian's packages; deploy/system-libraries too."""


def system_libraries(
    libraries: Mapping[str, str] = LIBRARIES,
    load: Callable[[str], object] = ctypes.CDLL,
) -> Finding:
    """Load every library, as the packages that need them will."""
    missing = [name for name in libraries if not _loads(name, load)]
    if not missing:
        return ok(f"all {len(libraries)} load")
    packages = " ".join(libraries[name] for name in missing)
    return problem(f"cannot load {', '.join(missing)}", as_root(f"apt-get install {packages}"))


def as_root(command: str) -> str:
    """Return ``command`` as this user has to type it."""
    return command if os.geteuid() == 0 else f"sudo {command}"


def _loads(name: str, load: Callable[[str], object]) -> bool:
    try:
        load(name)
    except OSError:
        return False
    return True
