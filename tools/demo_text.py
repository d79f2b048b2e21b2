"""What the demo prints: calm, aligned, and the same on a terminal and in a file."""

import os
import shlex
import sys
import textwrap
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from sceneq_tools.console import coloured
from sceneq_tools.demo_truth import Question, Verdict
from sceneq_tools.progress import Advance, progress

INDENT = "  "
WIDTH = 96
STATE = 28
RESERVED = "&;%#?"
"""A selector's parameters cannot hold these: such a text goes in as payload."""

Answer = Mapping[str, Any]


def say(text: str = "", tone: str = "") -> None:
    """Print one line."""
    print(coloured(sys.stdout)(text, tone), flush=True)


def waiting(title: str) -> AbstractContextManager[Advance]:
    """Show on a terminal that something takes its time; a file has no need to know."""
    return progress(title, None, quiet=not sys.stderr.isatty())


def heading(text: str) -> None:
    """Print a line with a rule under it."""
    say()
    say(text)
    say("─" * len(text))


def facts(rows: Sequence[tuple[str, str]]) -> None:
    """Print names and values in two columns."""
    width = max(len(name) for name, _ in rows)
    for name, value in rows:
        say(f"{INDENT}{name:<{width}}  {value}")


def command(endpoint: str, scene: str, question: str) -> str:
    """Return what to type to ask the same with the third-party Zenoh command line."""
    selector = f"sceneq/query/{scene}/ask"
    said = ""
    if any(letter in RESERVED for letter in question):
        said = f" -v {shlex.quote(question)}"
    else:
        selector += f"?q={question}"
    where = f"zenoh --mode client --connect {endpoint} get"
    return f"{where} -s {shlex.quote(selector)}{said} --decoder sceneq"


def answer_line(answer: Answer) -> str:
    """Return ``found 12 sofa  p 0.41  fast route  9 ms``."""
    status = str(answer.get("status", "")).replace("_", " ")
    best = (answer.get("instances") or [None])[0]
    if best is None or answer.get("status") == "not_found":
        return f"{status}  {how(answer)}"
    return f"{status}: {best['id']} {best['label']}  p {best['p']:.2f}  {how(answer)}"


def how(answer: Answer) -> str:
    """Return the route of an answer and its time."""
    return f"{answer.get('route', '?')} route, {answer.get('took_ms', 0):.0f} ms"


def in_growing_map(shell: str, state: str, answer: Answer, verdict: Verdict) -> None:
    """Print a question to the growing map as it is typed, and its answer."""
    say()
    say(f"{INDENT}$ {shell}")
    say(f"{INDENT}  {state:<{STATE}}  {answer_line(answer)}")
    if verdict.right is not None:
        missing = not verdict.right and answer.get("status") == "not_found"
        words = "not yet: more of the room is to be seen" if missing else verdict.words
        say(f"{INDENT}  {'':<{STATE}}  {words}", "" if missing else verdict.tone)


def in_whole_map(
    number: int, question: Question, answer: Answer, verdict: Verdict, evidence: Path | None
) -> None:
    """Print all there is to say about an answer."""
    say()
    bucket = f"  ({question.bucket})" if question.bucket else ""
    say(f"{number}. “{question.text}”{bucket}")
    rows = [("answer", answer_line(answer))]
    if answer.get("status") != "not_found" and answer.get("instances"):
        rows.append(("place", _place(answer["instances"][0])))
    if reason := answer.get("reason"):
        rows.append(("reason", _wrapped(str(reason))))
    if evidence is not None:
        rows.append(("views", str(evidence)))
    facts([(f"{name:<7}", value) for name, value in rows])
    if verdict.right is not None:
        say(f"{INDENT}{'truth':<7}  {verdict.words}", verdict.tone)


def score(verdicts: Sequence[Verdict]) -> str:
    """Return how many answers were right."""
    known = [verdict.right for verdict in verdicts if verdict.right is not None]
    return f"{sum(known)} of {len(known)} right" if known else "no truth to compare with"


def activation() -> str:
    """Return what puts the commands on the path of another shell, '' when they are there."""
    folder = Path(sys.executable).parent
    if str(folder) in os.environ.get("PATH", "").split(os.pathsep):
        return ""
    script = folder / "activate"
    return f"source {os.path.relpath(script)}" if script.is_file() else f"PATH={folder}:$PATH"


def _place(instance: Mapping[str, Any]) -> str:
    centre = " ".join(f"{value:.2f}" for value in instance["centre"])
    size = " x ".join(f"{value:.2f}" for value in instance["box_oriented"]["size"])
    return f"{centre} m, {size} m large"


def _wrapped(text: str) -> str:
    hanging = " " * (len(INDENT) + 9)
    return textwrap.fill(text, WIDTH, initial_indent=hanging, subsequent_indent=hanging).strip()
