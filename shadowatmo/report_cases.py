"""Files of reference rays (tests/data/README.md has the format): their cases as scenes and rays, and the verdict.

A kind of case asks for certain values; the errors of each metric have a bar. Metrics: "abs", absolute, of
transmittance; "rel", relative by channel with a floor of 1e-4 of the case's brightest; "ref", relative to the brightest
channel without moons; "m", lengths in units of what float32 input allows; "gdir" and "gmul", like "rel", of the
ground's direct light and skylight. Three standard errors of a Monte Carlo value are taken off first.
"""

import json
import math
from dataclasses import dataclass

import numpy as np

from shadowatmo.errors import ParameterError
from shadowatmo.parameters import Atmosphere, Occluder, Sun, TentLayer
from shadowatmo.scene import Scene

# kind -> (metric, percentile, limit)
BARS = {
    "transmittance": (("abs", 95, 1e-4), ("abs", 100, 1e-3)),
    "single": (("rel", 95, 2e-3), ("rel", 99, 1e-2), ("rel", 100, 0.1)),
    "single_disc": (("rel", 95, 2e-2),),
    "lengths_planet_shadow": (("m", 95, 1.0), ("m", 100, 20.0)),
    "lengths_umbra": (("m", 95, 1.0), ("m", 100, 20.0)),
    "lengths_penumbra": (("m", 95, 1.0), ("m", 100, 20.0)),
    "eclipse_single": (("ref", 95, 2e-3), ("ref", 100, 2e-2)),
    "multiple": (("rel", 50, 1e-2), ("rel", 95, 5e-2), ("gdir", 95, 5e-3), ("gmul", 50, 1e-2), ("gmul", 95, 4e-2)),
    "eclipse_multiple": (("rel", 50, 0.03), ("rel", 95, 0.12), ("gmul", 95, 0.15)),
}
LENGTHS = {  # field of the probe: field of the case
    "lengths_planet_shadow": {"lit": "lit", "shadow": "shadow"},
    "lengths_umbra": {"planet_umbra": "umbra", "planet_penumbra": "penumbra"},
    "lengths_penumbra": {"umbra": "umbra", "antumbra": "antumbra", "penumbra": "penumbra"},
}
GROUND = {  # metric: field of the probe, of the case, and its standard error
    "gdir": ("ground_direct", "ground_direct", None),
    "gmul": ("ground_multiple", "ground_multi", "ground_multi_se"),
}
DISC_DISTANCE = 1.496e11  # m, of a disc sun whose case gives its angular radius alone
RELATIVE_FLOOR, LEAST = 1e-4, 1e-12
NOT_FINITE = 1e30  # the error of a value that is not; percentiles cannot pass between infinities


@dataclass(frozen=True, eq=False)
class Group:
    """Cases that share a scene, and their rays."""

    scene: Scene
    cases: tuple[dict, ...]
    origins: np.ndarray
    directions: np.ndarray
    t_max: np.ndarray


def read_cases(path) -> list[Group]:
    """Return the groups of a reference file.

    Raises
    ------
    ParameterError
        If it is not such a file.
    """
    try:
        data = json.loads(path.read_text("utf-8"))
        presets, cases = data["presets"], [c for c in data["cases"] if c["kind"] in BARS]
        together = {}
        for case in cases:
            key = json.dumps([case["preset"], case.get("sun"), case.get("occluders")], sort_keys=True)
            together.setdefault(key, []).append(case)
        return [_group(presets, members) for members in together.values()]
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        what = f"a file of reference cases ({type(error).__name__}: {error})"
        raise ParameterError("--reference", str(path), what) from None


def _group(presets, cases) -> Group:
    first = cases[0]
    limits = [math.inf if c.get("t_max") is None else c["t_max"] for c in cases]
    rays = (np.array([c[name] for c in cases], np.float64) for name in ("origin", "direction"))
    return Group(_scene(presets[first["preset"]], first), tuple(cases), *rays, np.array(limits))


def _scene(preset, case) -> Scene:
    ozone = preset["ozone"]
    tent = None if ozone is None else TentLayer(ozone["centre"], ozone["half_width"], tuple(ozone["peak"]))
    colors = (tuple(np.broadcast_to(preset[name], 3).tolist()) for name in ("beta_R", "beta_M", "beta_Me"))
    rayleigh, mie, extinction = colors
    air = Atmosphere(
        bottom_radius=preset["Rb"], top_radius=preset["Rt"], rayleigh_scattering=rayleigh,
        rayleigh_scale_height=preset["H_R"], mie_scattering=mie, mie_extinction=extinction,
        mie_scale_height=preset["H_M"], mie_g=preset["g"], ozone=tent, ground_albedo=tuple(preset["albedo"]),
    )  # fmt: skip
    sun = case.get("sun") or {"dir": (0.0, 0.0, 1.0)}
    more = {name: sun[name] for name in ("distance", "radius") if name in sun}
    if sun.get("model") == "disc":
        radius = DISC_DISTANCE * math.sin(sun["angular_radius"])
        more = {"distance": DISC_DISTANCE, "radius": radius, "disc_at_terminator": True}
    moons = tuple(Occluder(tuple(o["centre"]), o["radius"]) for o in case.get("occluders", ()))
    return Scene(air, Sun(tuple(sun["dir"]), limb_darkening=float(sun.get("limb_u", 0.0)), **more), moons)


def judge_cases(groups, probe) -> dict[str, dict[str, np.ndarray]]:
    """Return errors by kind and metric.

    Parameters
    ----------
    groups : sequence of Group
    probe : callable
        (scene, origins, directions, t_max) -> ProbeResult.
    """
    errors = {}
    for group in groups:
        result = probe(group.scene, group.origins, group.directions, group.t_max)
        for index, case in enumerate(group.cases):
            for metric, error in _case_errors(case, group.scene.atmosphere.top_radius, result, index):
                errors.setdefault(case["kind"], {}).setdefault(metric, []).append(error)
    return {kind: {name: np.array(values) for name, values in found.items()} for kind, found in errors.items()}


def missed_bars(errors) -> list[str]:
    """Return one line for every bar that is not met, and for every kind with rays that end elsewhere."""
    lines = []
    for kind, found in errors.items():
        for metric, percentile, limit in BARS[kind]:
            value = float(np.percentile(found[metric], percentile)) if metric in found else 0.0
            if not value <= limit:
                lines.append(f"{kind}: {metric}, {percentile} % of the values: {value:.3g} is above {limit:g}")
        wrong = int(found["end"].sum())
        if wrong > 0.01 * len(found["end"]):
            lines.append(f"{kind}: {wrong} of {len(found['end'])} rays end elsewhere")
    return lines


def _case_errors(case, top, result, index):
    """Yield metric and error of one case; top = radius of the top of its air [m]."""
    kind, expected = case["kind"], case["expected"]
    yield "end", float(str(result.end[index]) != expected["end"])
    if case.get("ill") or expected["end"] == "miss":  # 1e-7 of the input would change the answer, or there is none
        return
    if kind in LENGTHS:
        allowed = min(2.0, 2e-4 * top) + 3e-7 * float(np.linalg.norm(case["origin"]))
        for field, name in LENGTHS[kind].items():
            value = np.atleast_1d(getattr(result, field)[index])[0]
            yield "m", _finite(abs(value - expected[name]) / allowed)
    elif kind == "transmittance":
        for got, want in zip(result.transmittance[index], expected["transmittance"], strict=True):
            yield "abs", _finite(abs(got - want))
    else:
        name = "multi" if "multiple" in kind else "single"
        got = (result.multiple if name == "multi" else result.single)[index]
        base = np.array(expected["single_no_moon"] if kind == "eclipse_single" else expected[name])
        spread = np.array(expected.get(f"{name}_se", (0.0, 0.0, 0.0)))
        floor = max(RELATIVE_FLOOR * base.max(), LEAST)
        for error, want in zip(_beyond(got, expected[name], spread), expected[name], strict=True):
            yield "rel", error / max(abs(want), floor)
            yield "ref", error / max(base.max(), LEAST)
        yield from _ground_errors(kind, expected, result, index)


def _ground_errors(kind, expected, result, index):
    for metric, (field, name, spread) in GROUND.items():
        if name not in expected or (metric == "gdir" and kind == "eclipse_multiple"):
            continue
        want = np.array(expected[name])
        errors = _beyond(getattr(result, field)[index], want, np.array(expected[spread]) if spread else np.zeros(3))
        for error, value in zip(errors, want, strict=True):
            yield metric, error / max(abs(value), RELATIVE_FLOOR * want.max(), LEAST)


def _beyond(got, want, spread):
    """Return absolute errors (3,) beyond three standard errors."""
    return [_finite(max(error, 0.0)) for error in np.abs(got - np.array(want)) - 3.0 * spread]


def _finite(error) -> float:
    return float(error) if np.isfinite(error) else NOT_FINITE
