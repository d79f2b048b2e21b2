"""Tables on the terminal."""

from collections.abc import Iterable, Sequence

WIDE = 200
"""Columns of a table that nobody looks at but a program: lines must not wrap."""


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], title: str = "") -> None:
    """Print rows under bold column names; numbers are the caller's to format."""
    import sys

    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console(width=None if sys.stdout.isatty() else WIDE)
    table = Table(*columns, title=escape(title) or None, box=box.SIMPLE_HEAD, title_justify="left")
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    console.print(table)
