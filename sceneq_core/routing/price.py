"""The price of a reasoner's answer: it rises as the hour's budget empties and falls with time."""

from dataclasses import dataclass

from sceneq_core.checks import need_positive, need_within
from sceneq_core.routing.budget import HOUR_S


@dataclass(frozen=True, slots=True)
class PriceParams:
    """``first``: the price before anything is known, in probability gained by one answer.

    ``swing``: how much the price rises when a whole hour's budget is spent at once, and falls in
    an hour without spending. 1 takes it from free to prohibitive: no answer gains more than 1.
    """

    first: float = 0.1
    swing: float = 1.0

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "first")
        need_positive(self, "swing")


class Price:
    """The dual variable of "spend no faster than the budget comes in", by subgradient steps.

    Every answer moves it by swing x (share of the budget spent - share of the hour passed), so it
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
        return max(0.0, self._price - self._params.swing * passed_s / HOUR_S)

    def spend(self, share: float, now_s: float) -> None:
        """Raise it: ``share`` of an hour's budget was spent."""
        self._price = min(1.0, self.at(now_s) + self._params.swing * share)
        self._at_s = now_s
