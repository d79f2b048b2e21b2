"""The numbers of an OBJ file: read all at once, one by one only to find a bad one."""

import warnings
from dataclasses import dataclass, field

import numpy as np

from sceneq_core.arrays import Array, Float64, Int64

_FIELDS = 3  # a corner: position/texture/normal


@dataclass(slots=True)
class NumberRows:
    """Lines of one kind; the first ``width`` numbers of each count.

    ``padding`` is put behind lines that may be shorter.
    """

    width: int
    padding: str = ""
    texts: list[str] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    def append(self, text: str, line: int) -> None:
        """Take one line of the file."""
        self.texts.append(text + self.padding)
        self.lines.append(line)

    def array(self) -> Float64:
        """Return (rows, width); raise ``ValueError`` that names the line of a bad number."""
        if not self.texts:
            return np.zeros((0, self.width))
        columns = {len(text.split()) for text in self.texts}
        numbers = _all_numbers(" ".join(self.texts), np.float64) if len(columns) == 1 else None
        if numbers is not None and min(columns) >= self.width:
            return np.asarray(numbers.reshape(len(self.texts), -1)[:, : self.width])
        rows = zip(self.texts, self.lines, strict=True)
        return np.array([self._row(text, line) for text, line in rows])

    def _row(self, text: str, line: int) -> list[float]:
        words = text.split()[: self.width]
        try:
            if len(words) < self.width:
                raise ValueError(words)
            return [float(word) for word in words]
        except ValueError:
            raise ValueError(
                f"line {line}: expected {self.width} numbers, got {' '.join(words)!r}"
            ) from None


@dataclass(slots=True)
class CornerTokens:
    """The corners of all faces, such as ``3/2/5``, ``3//5``, ``3/2`` or ``3``."""

    tokens: list[str] = field(default_factory=list)
    sizes: list[int] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)

    def append(self, tokens: list[str], line: int) -> None:
        """Take one face."""
        self.tokens += tokens
        self.sizes.append(len(tokens))
        self.lines.append(line)

    def array(self) -> Int64:
        """Return (corners, 3), as written, 0 where absent; raise ``ValueError`` naming the line."""
        if not self.tokens:
            return np.zeros((0, _FIELDS), dtype=np.int64)
        text = " ".join(self.tokens).replace("//", "/0/")
        per_corner, rest = divmod(text.count("/"), len(self.tokens))
        numbers = _all_numbers(text.replace("/", " "), np.int64) if rest == 0 else None
        if numbers is None or len(numbers) != len(self.tokens) * (per_corner + 1):
            rows = [self._row(token, at) for at, token in enumerate(self.tokens)]
            return np.array(rows, dtype=np.int64).reshape(-1, _FIELDS)
        corners = np.zeros((len(self.tokens), _FIELDS), dtype=np.int64)
        corners[:, : per_corner + 1] = numbers.reshape(len(self.tokens), -1)[:, :_FIELDS]
        return corners

    def line(self, corner: int) -> int:
        """Return the line of the face that a corner belongs to."""
        return self.lines[int(np.searchsorted(np.cumsum(self.sizes), corner, side="right"))]

    def _row(self, token: str, corner: int) -> list[int]:
        words = [*token.split("/"), "", ""][:_FIELDS]
        try:
            return [int(word) if word else 0 for word in words]
        except ValueError:
            raise ValueError(f"line {self.line(corner)}: {token!r} is no corner") from None


def whole_number(word: str, line: int) -> int:
    """Read an index, 0 for an empty one; raise ``ValueError`` that names the line."""
    try:
        return int(word) if word else 0
    except ValueError:
        raise ValueError(f"line {line}: {word!r} is no index") from None


def _all_numbers(text: str, kind: type[np.float64] | type[np.int64]) -> Array | None:
    """Return the blank-separated numbers of a text, ``None`` when something else is among them."""
    if not text:
        return np.zeros(0, dtype=kind)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DeprecationWarning)  # numpy's word for unparsed rest
        try:
            return np.fromstring(text, dtype=kind, sep=" ")
        except (DeprecationWarning, ValueError):
            return None
