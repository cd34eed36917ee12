"""The report as pictures, by matplotlib: speed against error, and maps of where a frame is wrong."""

import numpy as np

from shadowatmo.report import front, mean_cost, plotted_error

COLORS = {
    "segments": "#0072b2", "march": "#d55e00", "table3d": "#009e73", "table3d-multiple": "#56b4e9",
    "table4d": "#cc79a7", "widths": "#999999",
}  # fmt: skip
MARKERS = {"analytic": "o", "textures": "s", "24 bits": "^"}
LEAST, LARGEST = 1e-5, 10.0  # errors that are drawn at the edge: 0.001 and 1000 percent


def figure_class():
    """Return matplotlib's Figure; it needs neither a display nor the state of pyplot.

    Raises
    ------
    ModuleNotFoundError
        If matplotlib is not installed; the command line says what to install.
    """
    from matplotlib.figure import Figure

    return Figure


def speed_error_figure(report, statistic="p99"):
    """Return the figure of all candidates: mean cost of a frame across, error of the light up, the best front drawn."""
    figure = figure_class()(figsize=(8.0, 5.2), layout="constrained")
    axes = figure.add_subplot()
    points = []
    for c in report["candidates"]:
        method = c["fields"].get("method", "segments")
        depth = "24 bits" if c["fields"].get("depth_bits") == 24 else c["fields"].get("depth", "textures")
        x, y = mean_cost(c), float(np.clip(plotted_error(c, statistic), LEAST, LARGEST))
        points.append((x, y))
        axes.plot(x, 100 * y, MARKERS[depth], color=COLORS[method], markersize=6, alpha=0.85)
        if c["name"] in ("fast", "balanced", "accurate"):
            axes.annotate(c["name"], (x, 100 * y), (6, 5), textcoords="offset points", fontsize=10, weight="bold")
    best = front(points)
    line = [points[i][0] for i in best], [100 * points[i][1] for i in best]
    axes.step(*line, "-", where="post", color="#444444", lw=1)
    methods = {c["fields"].get("method", "segments") for c in report["candidates"]}
    for method in (m for m in COLORS if m in methods):
        axes.plot([], [], "o", color=COLORS[method], label=method)
    for depth, marker in MARKERS.items():
        axes.plot([], [], marker, color="black", fillstyle="none", label=f"depth: {depth}")
    axes.plot([], [], "-", color="#444444", lw=1, label="best")
    axes.set(xscale="log", yscale="log", xlabel="cost of a frame [full-screen copies, mean of the cameras]")
    axes.set_ylabel(f"error of single + multiple [%, {statistic} in the middle set of rays or frame]", fontsize=9)
    axes.set_xticks([m * d for d in (0.1, 1, 10, 100, 1000) for m in (1, 2, 3, 5)], minor=False)
    axes.minorticks_off()
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter("{x:g}")
    axes.set_xlim(0.9 * min(x for x, _ in points), 1.25 * max(x for x, _ in points))
    axes.grid(which="both", alpha=0.2)
    axes.legend(fontsize=8, ncols=2)
    size = "x".join(map(str, report["options"]["size"]))
    axes.set_title(f"{report['machine']['renderer'].split('(')[0].strip()}, {size}")
    return figure


def map_figure(errors, title, aspect):
    """Return the figure of relative errors (rows, columns) of a frame, on a logarithmic scale; nan stays gray."""
    figure = figure_class()(figsize=(8.0, 8.0 / aspect + 0.6), layout="constrained")
    axes = figure.add_subplot()
    axes.set_facecolor("#777777")
    decades = np.log10(np.clip(100.0 * errors, 1e-3, 100.0))
    image = axes.imshow(decades, cmap="magma", vmin=-3, vmax=2, interpolation="nearest", extent=(0, aspect, 0, 1))
    axes.set(xticks=[], yticks=[], title=title)
    bar = figure.colorbar(image, ax=axes, fraction=0.025, ticks=range(-3, 3))
    bar.ax.set_yticklabels([f"{10.0**d:g} %" for d in range(-3, 3)])
    return figure


def save(figure, path) -> None:
    """Write a figure as PNG."""
    figure.savefig(path, format="png", dpi=110)
