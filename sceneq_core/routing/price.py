"""The price of a reasoner's answer: it rises as the hour's budget empties and falls with time."""

from dataclasses import dataclass

from sceneq_core.checks import need_positive, need_within
from sceneq_core.routing.budget import HOUR_S


@dataclass(frozen=True, slots=True)
class PriceParams:
    """``first``: the price before anything is known, in probability gained by one answer.

    ``swing``: how much the price rises when a whole hour's budget is spent at once. 1 takes it
    from free to prohibitive: no answer gains more than 1. ``aim``: the share of the budget that it
    steers for. Above 0.9, chance empties the budget now and then, and who comes next is refused,
    however much it was worth.
    """

    first: float = 0.1
    swing: float = 1.0
    aim: float = 0.9

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "first", "aim")
        need_positive(self, "swing", "aim")


class Price:
    """The dual variable of "spend no faster than the budget comes in", by subgradient steps.

    Every answer moves it by swing x (share of the budget spent - aim x hours passed), so it
    settles where the questions that are worth it use the budget up, whatever they are like and
    however many come. S. Balseiro, Y. Gur, Learning in Repeated Auctions with Budgets (adaptive
    pacing), Management Science 2019, DOI 10.1287/mnsc.2018.3174.
    """

    def __init__(self, params: PriceParams) -> None:
        self._params = params
        self._price = params.first
        self._at_s: float | None = None

    def at(self, now_s: float) -> float:
        """Return the price now, 0 to 1; it begins to fall when it is first looked at."""
        if self._at_s is None:
            self._at_s = now_s
        passed_s = max(0.0, now_s - self._at_s)
        fallen = self._params.swing * self._params.aim * passed_s / HOUR_S
        return max(0.0, self._price - fallen)

    def spend(self, share: float, now_s: float) -> None:
        """Raise it: ``share`` of an hour's budget was spent."""
        self._price = min(1.0, self.at(now_s) + self._params.swing * share)
        self._at_s = now_s
