"""The points of the curve of speed against error: the qualities that the report measures and a budget chooses among."""

from dataclasses import fields

from shadowatmo.quality import METHODS, NAMED, Quality

FULL = (  # nodes and multiple of "segments", pixel by pixel
    (3, "balanced"), (4, "balanced"), (6, "balanced"), (8, "balanced"), (8, "accurate"), (12, "finest"), (20, "finest"),
)  # fmt: skip
TILED = (  # nodes, multiple and tolerance of frames interpolated between tiles
    (3, "balanced", 0.02), (4, "balanced", 0.02), (6, "balanced", 0.02), (6, "balanced", 0.006),
    (4, "balanced", 0.006), (8, "accurate", 0.006), (12, "accurate", 0.006), (8, "accurate", 0.002),
    (12, "finest", 0.002), (20, "finest", 0.002),
)  # fmt: skip
STEPS = (8, 16, 32, 64, 128)  # of "march"
TOLERANCE = 0.006  # of the other methods


def candidates(fast=False) -> dict[str, Quality]:
    """Return qualities by name: the presets first, then each method with its axes one at a time.

    Parameters
    ----------
    fast : bool
        Leave out what only makes the curve finer.
    """
    found = dict(NAMED)
    for nodes, multiple in FULL if not fast else FULL[1:2]:
        _add(found, _segments(nodes, multiple))
    for nodes, multiple, tolerance in TILED if not fast else ():
        _add(found, _segments(nodes, multiple, tolerance))
    if not fast:
        _add(found, Quality(nodes=8, terms=6, depth="analytic"))
        for method in METHODS[1:]:
            _add(found, Quality(method=method, depth="analytic", tolerance=TOLERANCE))
        _add(found, Quality(nodes=8, transmittance="table", depth="analytic"))
    for steps in STEPS if not fast else (32,):
        _add(found, Quality(method="march", steps=steps, depth="analytic"))
    for method in METHODS:
        if method not in ("segments", "march"):
            _add(found, Quality(method=method, depth="analytic"))
    _add(found, Quality())
    _add(found, Quality(depth_bits=24))
    if not fast:
        for method in METHODS[1:]:
            _add(found, Quality(method=method))
        _add(found, Quality(method="widths", depth_bits=24))
    return found


def _segments(nodes, multiple, tolerance=0.0) -> Quality:
    effort = {"gap_nodes": max(2, nodes // 2), "terms": 4 if nodes < 12 else 6}
    return Quality(nodes=nodes, multiple=multiple, tolerance=tolerance, depth="analytic", **effort)


def _add(found, quality):
    if quality not in found.values():
        assert describe(quality) not in found
        found[describe(quality)] = quality


def changed_fields(quality) -> dict:
    """Return the fields of a quality that differ from the defaults, as JSON can hold them."""
    plain = Quality()
    names = [field.name for field in fields(Quality) if field.init]
    return {name: getattr(quality, name) for name in names if getattr(quality, name) != getattr(plain, name)}


def from_fields(changes) -> Quality:
    """Return the quality of `changed_fields`."""
    return Quality(**changes)


def describe(quality) -> str:
    """Return a short name that tells the candidates apart."""
    parts = [quality.method]
    if quality.method == "segments":
        parts += [f"{quality.nodes}+{quality.gap_nodes} nodes", f"{quality.terms} terms"]
        parts += ["table"] if quality.transmittance == "table" else []
        parts += [f"{quality.multiple} multiple"] if quality.multiple != "balanced" else []
    if quality.method == "march":
        parts.append(f"{quality.steps} steps")
    parts += [f"tiles {quality.tolerance:g}"] if quality.tolerance else []
    parts.append(quality.depth if quality.depth_bits == 32 else "24 bits")
    return ", ".join(parts)
