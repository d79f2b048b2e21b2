"""The scenarios there are. To add one: a module with its function, and a line here."""

from collections.abc import Mapping
from importlib import import_module

from sceneq_tools.chaos.scenario import Scenario

SCENARIOS: Mapping[str, str] = {
    "kill": "sceneq_tools.chaos.kills:kill",
    "blackout": "sceneq_tools.chaos.blackouts:blackout",
    "pause": "sceneq_tools.chaos.kills:pause",
    "hang": "sceneq_tools.chaos.kills:hang",
    "torn-writes": "sceneq_tools.chaos.stores:torn_writes",
    "damaged-store": "sceneq_tools.chaos.stores:damaged",
    "newer-store": "sceneq_tools.chaos.stores:newer",
    "read-only-disk": "sceneq_tools.chaos.stores:read_only",
    "full-disk": "sceneq_tools.chaos.stores:full",
    "overload": "sceneq_tools.chaos.overload:run",
    "clients": "sceneq_tools.chaos.clients:many",
    "bad-clients": "sceneq_tools.chaos.clients:bad",
    "malformed": "sceneq_tools.chaos.strangers:malformed",
    "no-model-server": "sceneq_tools.chaos.strangers:no_model_server",
    "partition": "sceneq_tools.chaos.partition:run",
    "bombs": "sceneq_tools.chaos.bombs:run",
    "fuzz": "sceneq_tools.chaos.fuzz:run",
}

SHORT = ("kill", "blackout", "clients", "malformed", "bombs", "fuzz")
"""What `--short` runs unless others are named."""


def load(name: str) -> Scenario:
    """Return the scenario of that name."""
    module, _, function = SCENARIOS[name].partition(":")
    scenario: Scenario = getattr(import_module(module), function)
    return scenario
