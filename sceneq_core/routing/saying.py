"""A report as one sentence of plain English."""

from collections.abc import Sequence

from sceneq_core.mapping.delta import REMOVED
from sceneq_core.reasoning.english import counted, listed, ordinal, relation_words
from sceneq_core.reasoning.reasoner import Constraint
from sceneq_core.reasoning.superlatives import COMPARED_TO_ANCHOR, SIDEWAYS, SUPERLATIVES
from sceneq_core.routing.answer import FOUND, NOT_FOUND, Match
from sceneq_core.routing.forms import COUNT, EXISTS, PICTURE, WHAT, WHEN
from sceneq_core.routing.labels import TAUGHT
from sceneq_core.routing.phrase import Phrase
from sceneq_core.routing.report import NO, YES, Report
from sceneq_core.teaching.wording import INDIVIDUAL, kind_of, spoken

CLEAR = 0.5
"""From this margin on the doubt is not which one it is, but whether it is such a thing."""

SPOKEN = 5
"""So many things are listed by name; of the rest the number."""


def say(report: Report, now_ns: int) -> str:
    """Return the sentence; ages count up to ``now_ns``, the stamp of the newest keyframe."""
    if report.kind == COUNT:
        return _how_many(report)
    if report.kind == WHAT:
        return _what(report)
    if report.kind == EXISTS:
        return _whether(report) + _gone(report, now_ns)
    if report.kind == PICTURE:
        return _like(report)
    if report.kind == WHEN:
        return _when(report, now_ns)
    return _which(report, now_ns)


def described(phrase: Phrase) -> str:
    """Return what is asked for in words, such as "largest cup on the table"."""
    before = [_superlative(c) for c in phrase.constraints if _is_adjective(c)]
    behind = [_relation(c) for c in phrase.constraints if not _is_adjective(c)]
    return " ".join([*before, phrase.target or "thing", *behind])


def age(seconds: float) -> str:
    """Return such as "12 s", "5 min" or "3 h"."""
    for unit, name in ((86_400, "days"), (3600, "h"), (60, "min")):
        if seconds >= 2 * unit:
            return f"{seconds / unit:.0f} {name}"
    return f"{max(seconds, 0):.0f} s"


def _which(report: Report, now_ns: int) -> str:
    best, wanted = report.best, described(report.question.phrase)
    if best is None:
        return f"There is no {wanted}: nothing in the map can be answered with yet."
    if report.answer.status == NOT_FOUND:
        return _nothing(report) + _gone(report, now_ns)
    if report.answer.status == FOUND:
        return f"{_the(best, wanted)} ({best.instance.instance_id}) is {_place(report)}."
    number, after = best.instance.instance_id, _gone(report, now_ns)
    if report.answer.confidence.margin >= CLEAR:
        return f"Perhaps {_place(report)}: {number} stands out, but may be no {wanted}.{after}"
    likeliest = f"the likeliest ({number}), with p {best.p:.2f}"
    return f"Not sure which {wanted}: {likeliest}, is {_place(report)}.{after}"


def _the(best: Match, wanted: str) -> str:
    """Name what is meant; a taught name of one thing is said as it was taught."""
    name = best.instance.label.name
    own = best.instance.label.source == TAUGHT and spoken(name) == wanted
    return _capital(name) if own and kind_of(name) == INDIVIDUAL else f"The {wanted}"


def _like(report: Report) -> str:
    best = report.best
    if best is None or report.answer.status == NOT_FOUND:
        return "Nothing in the map looks like the picture."
    sure = "Most like the picture" if report.answer.status == FOUND else "Perhaps"
    return f"{sure}, with p {best.p:.2f}: {_at(report)}."


def _how_many(report: Report) -> str:
    tally, phrase = report.tally, report.question.phrase
    if tally is None or report.missing:
        return _nothing(report)
    noun = phrase.target or "thing"
    place = "".join(f" {_relation(c)}" for c in phrase.constraints if not _is_adjective(c))
    possible = len(tally.possible)
    if not tally.matches:
        return f"No {noun}{place}, as far as the map shows."
    if not tally.sure:
        return f"No {noun}{place} for sure, possibly up to {possible}."
    more = f", and possibly {possible} more" if possible else ""
    return f"{_capital(counted(len(tally.sure), noun))}{place}{more}."


def _what(report: Report) -> str:
    tally, phrase = report.tally, report.question.phrase
    place = " and ".join(_relation(c) for c in phrase.constraints)
    if report.missing:
        return _nothing(report)
    if tally is None or not tally.matches:
        return f"Nothing {place}, as far as the map shows."
    parts = [_names(tally.sure)] if tally.sure else []
    if tally.possible:
        parts.append(f"possibly {_names(tally.possible)}")
    return f"{_capital(place)}: {'; '.join(parts)}."


def _whether(report: Report) -> str:
    if report.exists == NO:
        return _nothing(report)
    if report.exists == YES:
        return f"Yes: the likeliest {described(report.question.phrase)} is {_at(report)}."
    best = report.best
    doubt = f": the best fit is {_at(report)}" if best else ""
    return f"Perhaps there is a {described(report.question.phrase)}{doubt}."


def _when(report: Report, now_ns: int) -> str:
    best, wanted = report.best, described(report.question.phrase)
    if best is None or report.answer.status == NOT_FOUND:
        return f"No {wanted} was ever seen, as far as this map remembers."
    one = best.instance.geometry
    seen = age((now_ns - one.last_seen_ns) / 1e9)
    sure = ""
    if report.answer.status != FOUND:
        clear = report.answer.confidence.margin >= CLEAR
        sure = " (if it is one)" if clear else f" (not sure which, p {best.p:.2f})"
    gone = ""
    if one.state == REMOVED:
        gone = f"; it is gone since {age((now_ns - one.state_since_ns) / 1e9)}"
    return f"The {wanted}{sure} was last seen {seen} ago, {_place(report)}{gone}."


def _gone(report: Report, now_ns: int) -> str:
    """Say that what is asked for was there once."""
    if report.gone is None:
        return ""
    one = report.gone.instance.geometry
    seen, since = (age((now_ns - ns) / 1e9) for ns in (one.last_seen_ns, one.state_since_ns))
    wanted = described(report.question.phrase)
    return f" The {wanted} was last seen {seen} ago and is gone since {since}."


def _nothing(report: Report) -> str:
    """Say what is missing, and what comes nearest to it."""
    phrase = report.question.phrase
    wanted = report.missing or described(phrase)
    if report.best is None or (report.missing and report.missing != phrase.target):
        return f"There is no {wanted}."
    if report.best.instance.label.name == wanted:
        return f"There is probably no {wanted}; {_at(report)} is a doubtful one."
    return f"There is no {wanted}; the nearest miss is {_at(report)}."


def _at(report: Report) -> str:
    """Return the best match and where it is, such as "the cup (7) on the table"."""
    if report.best is None:
        return "nowhere"
    where = report.where.said() if report.where else ""
    return f"{_name(report.best)} {where}".strip()


def _place(report: Report) -> str:
    """Return where the best match is, or its id where the map knows no place in words."""
    where = report.where.said() if report.where else ""
    return where or f"instance {report.best.instance.instance_id if report.best else 0}"


def _name(match: Match) -> str:
    return f"the {match.instance.label.name} ({match.instance.instance_id})"


def _names(matches: Sequence[Match]) -> str:
    named = [_name(match) for match in matches[:SPOKEN]]
    more = len(matches) - len(named)
    return listed([*named, f"{more} more"] if more else named)


def _is_adjective(constraint: Constraint) -> bool:
    """Superlatives go before the noun, relations behind it."""
    return not constraint.anchor and constraint.relation in {*SUPERLATIVES, *SIDEWAYS}


def _superlative(constraint: Constraint) -> str:
    rank = f"{ordinal(constraint.rank)} " if constraint.rank > 1 else ""
    return f"{rank}{constraint.relation}"


def _relation(constraint: Constraint) -> str:
    words = relation_words(constraint.relation)
    if constraint.relation in COMPARED_TO_ANCHOR:
        rank = f"{ordinal(constraint.rank)} " if constraint.rank > 1 else ""
        words = f"{rank}{words} {'to' if constraint.relation == 'nearest' else 'from'}"
    words = f"not {words}" if constraint.negated else words
    other = f" and the {constraint.other}" if constraint.other else ""
    return f"{words} the {constraint.anchor or 'viewer'}{other}"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
