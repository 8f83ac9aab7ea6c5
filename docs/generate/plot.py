"""What the generated curves share: size and colours of a panel, its ticks, the SVG around it."""

from __future__ import annotations

WIDTH, HEIGHT, LEFT, TOP, GAP = 330, 250, 56, 44, 84  # of a panel, its place, and the room between two
COLOURS = ("#3f51b5", "#00897b", "#8e24aa", "#ef6c00", "#6d4c41", "#1e88e5")


def round_numbers(most: float) -> list[float]:
    """Three to six round numbers up to `most`."""
    step = next(s * 10.0**e for e in range(-3, 3) for s in (1.0, 2.0, 5.0) if most / (s * 10.0**e) <= 6.0)
    return [step * i for i in range(int(most / step) + 1)]


def tick_x(x: float, y: float, value: float) -> str:
    """A number below the frame at a place on it."""
    return f'<text x="{x:.1f}" y="{y + 17:.1f}" class="middle">{value:g}</text>'


def tick_y(x: float, y: float, value: float) -> str:
    """A number beside the frame, and a line across it."""
    return (
        f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{x + WIDTH:.1f}" y2="{y:.1f}" class="grid"/>'
        f'<text x="{x - 7:.1f}" y="{y + 4:.1f}" class="end">{value:g}</text>'
    )


SVG = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" aria-label="{label}">
<style>
.frame {{ fill: none; stroke: #90a4ae; }}
.grid {{ stroke: #eceff1; }}
.title {{ font: bold 14px sans-serif; fill: #37474f; }}
.label {{ font: 12px sans-serif; fill: #37474f; }}
.middle {{ font: 12px sans-serif; fill: #37474f; text-anchor: middle; }}
.end {{ font: 12px sans-serif; fill: #37474f; text-anchor: end; }}
</style>
<rect width="{width}" height="{height}" fill="#ffffff"/>
{shapes}
</svg>
"""
