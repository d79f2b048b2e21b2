"""Charts as SVG: a page with them needs nothing from elsewhere."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from typing import Any

from sceneq_tools.bench.report import figures

INK, FAINT, GRID = "#26282c", "#787c82", "#e3e5e8"
COLOURS = ("#2f6db3", "#c8742a", "#4b8a5a", "#8a5fa8")
SIDE, LEFT, BOTTOM, MARGIN = 212, 52, 40, 12
LEGEND_ROW = 16
TICKS = (0.0, 0.25, 0.5, 0.75, 1.0)
COUNT_SHARE = 0.25
"""Of the height: the tallest bar of how many predictions a bin holds."""

Bins = Sequence[Mapping[str, Any]]
Curve = tuple[Sequence[float], Sequence[float]]


def reliability(bins: Bins) -> str:
    """Return a reliability diagram: share right against mean confidence, a dot a bin.

    The diagonal is what calibrated means; the faint bars say how many predictions a bin holds.
    """
    most = max((one["count"] for one in bins), default=1)
    bars = (
        _rect(one["low"], one["high"], COUNT_SHARE * one["count"] / most, one["count"])
        for one in bins
    )
    points = [(one["confidence"], one["accuracy"]) for one in bins]
    dots = (
        f'<circle cx="{_x(x):.1f}" cy="{_y(y):.1f}" r="{3 + 4 * one["count"] / most:.1f}" '
        f'fill="{COLOURS[0]}" fill-opacity=".85"><title>{one["count"]}: mean p {x:.2f}, '
        f"right {y:.2f}</title></circle>"
        for one, (x, y) in zip(bins, points, strict=True)
    )
    diagonal = _polyline([(0, 0), (1, 1)], FAINT, dash=True)
    body = (*bars, diagonal, _polyline(points, COLOURS[0]), *dots)
    return _square(body, "probability of the first guess", "share of them right")


def risk_coverage(curves: Mapping[str, Curve]) -> str:
    """Return risk against coverage, a line each: lower is better, and 0 on the left is best."""
    lines = [
        _polyline(zip(coverage, risk, strict=True), colour)
        for (coverage, risk), colour in zip(curves.values(), COLOURS, strict=False)
    ]
    legend = [
        f'<text x="{LEFT}" y="{MARGIN + SIDE + BOTTOM + 12 + LEGEND_ROW * row}" fill="{colour}">'
        f"{escape(name)}</text>"
        for row, (name, colour) in enumerate(zip(curves, COLOURS, strict=False))
    ]
    titles = "share answered, the surest first", "share of them wrong"
    return _square((*lines, *legend), *titles, LEGEND_ROW * len(legend))


def bars(values: Mapping[str, float], unit: str) -> str:
    """Return horizontal bars with their values."""
    width, row_px, label_px, value_px = 820, 22, 190, 200
    most = max([*values.values(), 1e-12])
    rows = []
    for row, (name, value) in enumerate(values.items()):
        y, long = row * row_px, (width - label_px - value_px) * value / most
        middle = f'y="{y + 15}"'
        rows += [
            f'<text x="{label_px - 8}" {middle} text-anchor="end" fill="{INK}">{escape(name)}'
            "</text>",
            f'<rect x="{label_px}" y="{y + 4}" width="{long:.1f}" height="{row_px - 8}" '
            f'fill="{COLOURS[0]}"/>',
            f'<text x="{label_px + long + 6:.1f}" {middle} fill="{FAINT}">{figures(value)} '
            f"{escape(unit)}</text>",
        ]
    return _svg(width, row_px * len(values) + 4, rows)


def _square(body: Iterable[str], x_title: str, y_title: str, below: int = 0) -> str:
    """Return axes from 0 to 1 around ``body``, with so many pixels ``below`` them."""
    middle_x, middle_y = LEFT + SIDE / 2, MARGIN + SIDE / 2
    parts = [
        *(_grid(value) for value in TICKS),
        *body,
        f'<text x="{middle_x}" y="{MARGIN + SIDE + 34}" text-anchor="middle" fill="{INK}">'
        f"{escape(x_title)}</text>",
        f'<text transform="translate(12 {middle_y}) rotate(-90)" text-anchor="middle" '
        f'fill="{INK}">{escape(y_title)}</text>',
    ]
    return _svg(LEFT + SIDE + MARGIN, MARGIN + SIDE + BOTTOM + below, parts)


def _grid(value: float) -> str:
    x, y = _x(value), _y(value)
    return (
        f'<path d="M{x} {_y(0)}V{_y(1)}M{_x(0)} {y}H{_x(1)}" stroke="{GRID}"/>'
        f'<text x="{x}" y="{_y(0) + 15}" text-anchor="middle" fill="{FAINT}">{value:g}</text>'
        f'<text x="{LEFT - 6}" y="{y + 4}" text-anchor="end" fill="{FAINT}">{value:g}</text>'
    )


def _rect(low: float, high: float, height: float, count: int) -> str:
    return (
        f'<rect x="{_x(low) + 1:.1f}" y="{_y(height):.1f}" width="{SIDE * (high - low) - 2:.1f}" '
        f'height="{SIDE * height:.1f}" fill="{GRID}"><title>{count} guesses</title></rect>'
    )


def _polyline(points: Iterable[tuple[float, float]], colour: str, dash: bool = False) -> str:
    path = " ".join(f"{_x(x):.1f},{_y(y):.1f}" for x, y in points)
    dashed = ' stroke-dasharray="4 4"' if dash else ""
    return f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="1.6"{dashed}/>'


def _x(value: float) -> float:
    return LEFT + SIDE * value


def _y(value: float) -> float:
    return MARGIN + SIDE * (1 - value)


def _svg(width: float, height: float, parts: Iterable[str]) -> str:
    size = f'width="{width:g}" height="{height:g}" viewBox="0 0 {width:g} {height:g}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{"".join(parts)}</svg>'
