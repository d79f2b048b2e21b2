"""The commands, code and links of README.md and docs/, read as a person reads them."""

import re
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROGRAMS = (
    "sceneq|zenoh|python3?|pip|pipx|uv|make|bash|sh|source|cd|export|curl|wget|git|docker|kubectl|"
    "systemctl|journalctl|ssh|scp|apt|apt-get|sudo|ros2|rerun|mcap|pytest"
)
"""What a line of a block without a prompt begins with if it is to be typed."""
TYPED = re.compile(rf"(?:[A-Z_]+=\S+ )*(?:{PROGRAMS})(?: |$)")
SHELL = {"", "console", "sh", "bash", "shell", "text"}
"""Languages of blocks in which commands are looked for; '' says nothing, or is only indented."""
FENCE = re.compile(r" *```(\S*)")
SPAN = re.compile(r"`([^`]+)`")
LINK = re.compile(r"\]\(([^)\s]+)\)")


@dataclass(frozen=True)
class Block:
    """Lines of code; ``line`` is the number of the first."""

    page: str
    line: int
    language: str
    lines: tuple[str, ...]

    @property
    def text(self) -> str:
        return "\n".join(self.lines) + "\n"


@dataclass(frozen=True)
class Command:
    """One command as it stands there, with all its lines, and what is shown below it."""

    page: str
    line: int
    text: str
    shown: str = ""

    @property
    def where(self) -> str:
        return f"{self.page}:{self.line}"


def pages() -> list[str]:
    """Return every document, relative to the root."""
    found = sorted((ROOT / "docs").rglob("*.md"))
    return ["README.md", *(path.relative_to(ROOT).as_posix() for path in found)]


def blocks(page: str) -> list[Block]:
    """Return all blocks of code of a page, fenced or indented by four spaces."""
    return _split(page)[0]


def prose(page: str) -> list[tuple[int, str]]:
    """Return the numbered lines that are in no block."""
    return _split(page)[1]


def commands(page: str) -> list[Command]:
    """Return what a page tells its reader to type, in order."""
    shell = (block for block in blocks(page) if block.language in SHELL)
    return [command for block in shell for command in _typed(block)]


def mentioned(page: str) -> list[Command]:
    """Return the commands that stand within sentences and tables."""
    return [
        Command(page, line, span)
        for line, text in prose(page)
        for span in SPAN.findall(text)
        if TYPED.match(span) and " " in span
    ]


def links(page: str) -> list[tuple[int, str]]:
    """Return where a page points to, but for the rest of the world."""
    found = [(line, link) for line, text in prose(page) for link in LINK.findall(text)]
    return [(line, link) for line, link in found if "://" not in link]


def anchors(page: Path) -> set[str]:
    """Return the anchors of the headings of a page."""
    titles = re.findall(r"^#+ +(.+)$", page.read_text(), re.M)
    return {re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", t).strip().lower()) for t in titles}


def _split(page: str) -> tuple[list[Block], list[tuple[int, str]]]:
    """Return the blocks, and the numbered lines between them."""
    found: list[Block] = []
    rest: list[tuple[int, str]] = []
    lines = (ROOT / page).read_text().splitlines()
    at = 0
    while at < len(lines):
        fence = FENCE.match(lines[at])
        if fence:
            end = next(n for n in range(at + 1, len(lines)) if FENCE.match(lines[n]))
            found.append(Block(page, at + 2, fence[1], tuple(lines[at + 1 : end])))
            at = end + 1
        elif _is_indented(lines, at):
            end = at
            while end < len(lines) and lines[end].startswith("    "):
                end += 1
            found.append(Block(page, at + 1, "", tuple(line[4:] for line in lines[at:end])))
            at = end
        else:
            rest.append((at + 1, lines[at]))
            at += 1
    return found, rest


def _is_indented(lines: list[str], at: int) -> bool:
    return lines[at].startswith("    ") and (at == 0 or not lines[at - 1].strip())


def _typed(block: Block) -> Iterator[Command]:
    """Yield the commands of a block: after a prompt, or, where there is none, what looks so."""
    has_prompt = any(line.startswith("$ ") for line in block.lines)
    starts = [
        at
        for at, line in enumerate(block.lines)
        if (line.startswith("$ ") if has_prompt else TYPED.match(line))
    ]
    for at, until in pairwise([*starts, len(block.lines)]):
        end = at + 1
        while end < until and _goes_on("\n".join(block.lines[at:end])):
            end += 1
        text = "\n".join(block.lines[at:end]).removeprefix("$ ")
        yield Command(block.page, block.line + at, text, "\n".join(block.lines[end:until]))


def _goes_on(text: str) -> bool:
    """Whether a shell would wait for another line: a quote is open, or the line is not over."""
    try:
        shlex.split(text.removeprefix("$ "), comments=True)
    except ValueError:
        return True
    return False
