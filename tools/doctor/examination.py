"""All checks, one after the other."""

from collections.abc import Callable, Iterator, Mapping

from sceneq_tools.doctor import folders, libraries, machine, network, packages
from sceneq_tools.doctor.finding import Finding, problem
from sceneq_tools.errors import UserError

Check = Callable[[], Finding]

CHECKS: Mapping[str, Check] = {
    "python": packages.python_version,
    "packages": packages.package_versions,
    "torch": packages.torch_build,
    "rerun": packages.rerun_viewer,
    "system libraries": libraries.system_libraries,
    "weights": packages.weights,
    "encoder": folders.encoder_files,
    "cores": machine.cores,
    "memory": machine.memory,
    "disk": folders.disk,
    "writing": folders.writable,
    "shared memory": folders.shared_memory,
    "clock": machine.clock,
    "ports": network.ports,
    "zenoh": network.round_trip,
    # After zenoh: each start removes what it can of what others left behind.
    "left behind": folders.leftovers,
    "furniture": machine.furniture,
}


def examine(checks: Mapping[str, Check] = CHECKS) -> Iterator[tuple[str, Finding]]:
    """Yield what every check finds; one that fails is a problem of its own."""
    for name, check in checks.items():
        yield name, _finding(name, check)


def _finding(name: str, check: Check) -> Finding:
    try:
        return check()
    except UserError as error:
        return problem(str(error).splitlines()[0], "sceneq check")
    # Of a sick machine anything may be expected, and the other checks are to be told as well.
    except Exception as error:
        said = f"the check failed: {type(error).__name__}: {error}"
        return problem(said, f"sceneq doctor '{name}' --trace")
