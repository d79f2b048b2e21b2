"""Limits of parameters, checked where the parameters are made.

Every check takes the parameters and the names of the fields to look at, and raises ``ValueError``
with the first field that is out of its limits. NaN is out of all limits.
"""


def need_positive(params: object, *names: str) -> None:
    """Refuse fields that are not above 0."""
    for name in names:
        value = getattr(params, name)
        if not value > 0:
            raise ValueError(f"{name}: must be positive, got {value}")


def need_at_least(params: object, low: float, *names: str) -> None:
    """Refuse fields below ``low``."""
    for name in names:
        value = getattr(params, name)
        if not value >= low:
            raise ValueError(f"{name}: must be at least {low}, got {value}")


def need_within(params: object, low: float, high: float, *names: str) -> None:
    """Refuse fields outside ``low`` to ``high``; both ends are allowed."""
    for name in names:
        value = getattr(params, name)
        if not low <= value <= high:
            raise ValueError(f"{name}: must be from {low} to {high}, got {value}")


def need_between(params: object, low: float, high: float, *names: str) -> None:
    """Refuse fields outside ``low`` to ``high``; neither end is allowed."""
    for name in names:
        value = getattr(params, name)
        if not low < value < high:
            raise ValueError(f"{name}: must be between {low} and {high}, got {value}")
