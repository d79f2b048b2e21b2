"""Text files of numbers, as recordings keep their matrices in; all errors are ``ValueError``."""

from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float64


def read_matrix(path: Path, rows: int = 4, columns: int = 4) -> Float64:
    """Return the matrix (rows, columns) in a text file; more of either is cut off."""
    values = read_rows(path, columns)
    if len(values) < rows:
        raise ValueError(f"{path}: expected {rows} rows of {columns} numbers, got {len(values)}")
    return values[:rows]


def read_rows(path: Path, columns: int) -> Float64:
    """Return all rows (R, columns) of a text file; empty lines and # comments do not count."""
    lines = enumerate(read_lines(path), 1)
    rows = [_row(path, n, line, columns) for n, line in lines if _content(line)]
    return np.array(rows, np.float64).reshape(-1, columns)


def read_lines(path: Path) -> list[str]:
    """Return the lines of a text file."""
    try:
        return path.read_text().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: {getattr(error, 'strerror', None) or 'no text file'}") from error


def _row(path: Path, number: int, line: str, columns: int) -> list[float]:
    try:
        values = [float(word) for word in _content(line).split()]
    except ValueError as error:
        raise ValueError(f"{path}, line {number}: {error}") from error
    if len(values) < columns:
        raise ValueError(f"{path}, line {number}: expected {columns} numbers, got {len(values)}")
    return values[:columns]


def _content(line: str) -> str:
    return line.partition("#")[0].strip()
