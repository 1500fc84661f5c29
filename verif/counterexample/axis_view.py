"""The decision on one axis: the projections of A and B, the gap, and what the margin demands."""

from dataclasses import dataclass
from textwrap import wrap

from matplotlib.axes import Axes

from triaxis.golden.axes import axis_name, axis_vector
from triaxis.golden.exact import Triangle, dot
from triaxis.host.figure_style import GAP, MARGIN, NORMAL, SMALL, STYLES
from triaxis.verif.counterexample.labels import Label, place_labels

# A decision narrower than this part of the picture is zoomed in on, until it takes this part of it.
_NARROW, _ZOOMED = 0.03, 0.12
_HEIGHTS = (1.0, 0.0)
# Characters in a line of the title.
_LONGEST = 74


@dataclass(frozen=True)
class Projection:
    """Exact projections on an axis.

    ``values`` are those of the vertices of A and of B; ``gap`` is positive where the intervals are
    apart, negative where they overlap; ``inner`` are the two ends that face each other, the lower one
    of the two in the picture first; ``demanded`` is margin * |c|1.
    """

    axis: tuple[int, ...]
    values: tuple[tuple[int, ...], tuple[int, ...]]
    gap: int
    inner: tuple[int, int]
    demanded: int

    @property
    def separates(self) -> bool:
        """Return whether the axis separates by more than the margin."""
        return self.gap > self.demanded


def project(number: int, a: Triangle, b: Triangle, margin: int) -> Projection:
    """Project integer triangles on axis ``number``."""
    vector = axis_vector(number, a, b)
    on_a = tuple(int(dot(vector, vertex)) for vertex in a)
    on_b = tuple(int(dot(vector, vertex)) for vertex in b)
    up, down = (max(on_a), min(on_b)), (max(on_b), min(on_a))
    inner = up if up[1] - up[0] >= down[1] - down[0] else down
    demanded = margin * sum(abs(int(x)) for x in vector)
    return Projection(tuple(int(x) for x in vector), (on_a, on_b), inner[1] - inner[0], inner, demanded)


def draw_axis(axes: Axes, number: int, a: Triangle, b: Triangle, margin: int, whose: str) -> None:
    """Draw the projections of integer triangles on axis ``number``; ``whose``: who named it."""
    found = project(number, a, b, margin)
    # Exact before anything becomes a float: values may have a hundred bits.
    origin = found.inner[0]
    for style, height, values in zip(STYLES, _HEIGHTS, found.values, strict=True):
        low, high = (float(end - origin) for end in (min(values), max(values)))
        axes.plot([low, high], [height, height], style.line, color=style.colour, lw=5, alpha=0.5)
        axes.plot(
            [float(value - origin) for value in values], [height] * 3, style.marker, color=style.colour,
            ms=style.marker_size, mfc="white" if style.hollow else style.colour, zorder=3,
        )  # fmt: skip
    _draw_decision(axes, found)
    _frame(axes, found, float(origin))
    relation = ">" if found.separates else "\N{LESS-THAN OR EQUAL TO}"
    verb = "separates" if found.separates else "does not separate"
    c1 = sum(map(abs, found.axis))
    lines = [
        f"{whose}: axis {number} ({axis_name(number)}), c = {found.axis}",
        f"gap {found.gap} {relation} margin \N{MULTIPLICATION SIGN} |c|1 = {margin} \N{MULTIPLICATION SIGN} "
        f"{c1} = {found.demanded}: {verb}",
    ]
    wrapped = [part for line in lines for part in wrap(line, _LONGEST)]
    axes.set_title("\n".join(wrapped), fontsize=NORMAL if wrapped == lines else SMALL, loc="left")
    _label(axes, found, origin)


def _draw_decision(axes: Axes, found: Projection) -> None:
    """Draw the gap (or the overlap) as a band, and what the margin demands as a bar."""
    low, high = sorted((0.0, float(found.gap)))
    overlap = found.gap < 0
    if not found.gap:
        axes.axvline(0, color=GAP, lw=2, zorder=0)
    axes.axvspan(
        low, high, color=MARGIN if overlap else GAP, alpha=0.18, hatch="xx" if overlap else "", lw=1, zorder=0
    )
    if found.demanded:
        axes.annotate(
            "", xy=(float(found.demanded), 0.5), xytext=(0, 0.5),
            arrowprops={"arrowstyle": "|-|", "color": MARGIN, "lw": 1.5, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip


def _frame(axes: Axes, found: Projection, origin: float) -> None:
    """Set the range that is shown: everything, or the neighbourhood of a narrow decision."""
    ends = [float(v - found.inner[0]) for values in found.values for v in values]
    low, high = min(*ends, 0.0), max(*ends, float(found.demanded))
    decision = float(max(abs(found.gap), found.demanded))
    whole = high - low
    zoomed = 0 < decision < _NARROW * whole
    if zoomed:
        centre = found.gap / 2
        low, high = centre - decision / _ZOOMED / 2, centre + decision / _ZOOMED / 2
    room = 0.12 * (high - low) or 1.0
    axes.set_xlim(low - room, high + room)
    axes.set_ylim(-1.1, 2.1)
    axes.set_yticks(_HEIGHTS, [style.name for style in STYLES], fontsize=NORMAL)
    axes.set_xticks([])
    what = "overlap" if found.gap < 0 else "gap"
    text = (f"band: {what}" if found.gap else "line: touching") + (
        "; bar: what the margin demands" if found.demanded else ""
    )
    if zoomed:
        text += f"; zoomed: all spans {whole:.4g}"
    axes.set_xlabel(text, fontsize=SMALL)
    for side in ("top", "right", "left"):
        axes.spines[side].set_visible(False)


def _label(axes: Axes, found: Projection, origin: int) -> None:
    """Label the vertices that are in view with their exact projections."""
    low, high = axes.get_xlim()
    labels: list[Label] = []
    for style, height, values in zip(STYLES, _HEIGHTS, found.values, strict=True):
        for value in sorted(set(values)):
            x = float(value - origin)
            if not low <= x <= high:
                continue
            names = ", ".join(f"{style.name}{i + 1}" for i, other in enumerate(values) if other == value)
            pixel = axes.transData.transform((x, height))
            side = 1 if height > 0 else -1
            labels.append(Label((pixel[0], pixel[1]), f"{names}: {value}", style.colour, side))
    place_labels(axes, labels)
