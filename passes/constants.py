"""Scene and quality as the shaders' uniforms and defines: one place that knows both vocabularies."""

from functools import lru_cache

import numpy as np

from shadowatmo.extremes import (
    closed_form_holds,
    dominant_layer,
    has_curved_ozone,
    has_dense_top,
    has_opaque_ozone,
    is_deep,
    is_small,
    is_thick,
    reach_altitude,
)
from shadowatmo.quadrature import cumulative_matrix, gauss_legendre
from shadowatmo.ray import k_of
from shadowatmo.segments import gap_nodes_for, nodes_for
from shadowatmo.shadow import cylinder, umbra_cone
from shadowatmo.transmittance import COLUMN_NODES, ozone_altitudes, ozone_levels, ozone_ramps

# by terms of the closed form: relative density at the top above which the column beyond it is worth subtracting
TOP_DENSITY = {4: 1e-3, 6: 1e-5}


def air_uniforms(atmosphere) -> dict:
    """Return the uniforms of ray.glsl."""
    return {
        "u_bottom_radius": atmosphere.bottom_radius,
        "u_thickness": atmosphere.thickness,
        "u_top_k": k_of(atmosphere, atmosphere.thickness),
    }


def medium_uniforms(atmosphere) -> dict:
    """Return the uniforms of ray.glsl and medium.glsl."""
    uniforms = {
        **air_uniforms(atmosphere),
        "u_scale_height": (atmosphere.rayleigh_scale_height, atmosphere.mie_scale_height),
        "u_falloff": (1.0 / atmosphere.rayleigh_scale_height, 1.0 / atmosphere.mie_scale_height),
        "u_rayleigh_scattering": atmosphere.rayleigh_scattering,
        "u_mie_scattering": atmosphere.mie_scattering,
        "u_mie_extinction": atmosphere.mie_extinction,
    }
    if not closed_form_holds(atmosphere):
        uniforms |= column_uniforms(COLUMN_NODES)
    if is_deep(atmosphere):
        uniforms["u_reach_k"] = k_of(atmosphere, reach_altitude(atmosphere))
    if has_ozone(atmosphere):
        uniforms["u_ozone_extinction"] = atmosphere.ozone.extinction
        uniforms["u_ozone_k"] = ozone_levels(atmosphere)
        uniforms["u_ozone_ramps"] = ozone_ramps(atmosphere)
        if has_curved_ozone(atmosphere):
            uniforms["u_ozone_altitude"] = ozone_altitudes(atmosphere)
    return uniforms


def segment_uniforms(atmosphere) -> dict:
    """Return the uniforms that segments.glsl and phase.glsl add."""
    return {"u_dominant": dominant_layer(atmosphere), "u_mie_g": atmosphere.mie_g}


def medium_defines(atmosphere) -> dict:
    """Return the features of medium.glsl and segments.glsl that an atmosphere asks for."""
    features = {
        "HAS_OZONE": has_ozone(atmosphere),
        "HAS_CURVED_OZONE": has_ozone(atmosphere) and has_curved_ozone(atmosphere),
        "HAS_NO_AEROSOLS": not any(atmosphere.mie_extinction),
        "HAS_DEEP_SHELL": is_deep(atmosphere),
        "HAS_SMALL_PLANET": is_small(atmosphere),
        "HAS_THICK_AIR": is_thick(atmosphere),
        "HAS_DENSE_TOP": has_dense_top(atmosphere),
        "HAS_OPAQUE_OZONE": has_ozone(atmosphere) and has_opaque_ozone(atmosphere),
    }
    count = {} if closed_form_holds(atmosphere) else {"COLUMN_COUNT": COLUMN_NODES}
    return {name: True for name, wanted in features.items() if wanted} | count


def has_ozone(atmosphere) -> bool:
    """Whether there is an absorbing layer that absorbs."""
    return atmosphere.ozone is not None and any(atmosphere.ozone.extinction)


def transmittance_defines(atmosphere, quality) -> dict:
    """Return the features of transmittance.glsl that a quality asks for."""
    if quality.column_table:
        return {"HAS_TABLE": True, "HAS_TABLE_MAPPING": True}
    scale_height = max(atmosphere.rayleigh_scale_height, atmosphere.mie_scale_height)
    dense_top = np.exp(-atmosphere.thickness / scale_height) > TOP_DENSITY[quality.terms]
    return {"TERMS": quality.terms, **({"HAS_TOP": True} if dense_top else {})}


def column_uniforms(count) -> dict:
    """Return the rule of transmittance.glsl's quadrature, for COLUMN_COUNT = count."""
    return {"u_column_rule": np.stack(gauss_legendre(count), axis=1), "u_column_count": count}


def segment_defines(quality, atmosphere=None) -> dict:
    """Return the quadrature constants of segments.glsl; an atmosphere may ask for more nodes than the quality."""
    counts = quality.nodes, quality.gap_nodes
    if atmosphere is not None:
        counts = nodes_for(atmosphere, counts[0]), gap_nodes_for(atmosphere, counts[1])
    return dict(_quadrature_defines(*counts))


@lru_cache(maxsize=64)
def _quadrature_defines(count, gap_count):
    nodes, weights = gauss_legendre(count)
    gap_nodes, gap_weights = gauss_legendre(gap_count)
    return {
        "NODE_COUNT": count,
        "GAP_COUNT": gap_count,
        "NODE_VALUES": glsl_array(nodes),
        "WEIGHT_VALUES": glsl_array(weights),
        "CUMULATIVE_VALUES": glsl_array(cumulative_matrix(count).ravel()),
        "GAP_NODE_VALUES": glsl_array(gap_nodes),
        "GAP_WEIGHT_VALUES": glsl_array(gap_weights),
    }


def glsl_array(values) -> str:
    """Return a float32 array constructor."""
    return f"float[{len(values)}](" + ", ".join(f"{np.float32(v):.9e}" for v in values) + ")"


def shadow_cone(atmosphere, sun, shape):
    """Return the planet's shadow as a Cone: "cylinder" or "cone" (the umbra)."""
    if shape == "cylinder":
        return cylinder(atmosphere.bottom_radius)
    return umbra_cone(atmosphere.bottom_radius, sun.radius, sun.distance)


def cone_uniforms(name, cone) -> dict:
    """Return a Cone as the uniform struct `name`."""
    return {f"{name}.{field}": getattr(cone, field) for field in ("radius", "slope", "excess", "near", "far")}
