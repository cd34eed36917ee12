"""The method "march": uniform steps over the whole path and a table of columns, the usual practice."""

from shadowatmo.passes.constants import cone_uniforms, medium_defines, medium_uniforms, transmittance_defines
from shadowatmo.shadow import cylinder

# by class: no air, one lit piece, one lit piece and a shadow, a shadow between two lit pieces
CLASS_FEATURES = ({}, {"HAS_AIR": True}, *[{"HAS_AIR": True, "HAS_SHADOW": True}] * 2)


def march_defines(atmosphere, quality) -> dict:
    """Return the defines of march.glsl."""
    return {**medium_defines(atmosphere), **transmittance_defines(atmosphere, quality), "STEPS": quality.steps}


def march_uniforms(atmosphere) -> dict:
    """Return the uniforms of march.glsl, apart from the table's."""
    return {**medium_uniforms(atmosphere), "u_mie_g": atmosphere.mie_g}


def march_method(view):
    """Return defines, uniforms and the features of each class of pixels for the method "march"."""
    atmosphere = view.scene.atmosphere
    return {"HAS_MARCH": True, **march_defines(atmosphere, view.quality)}, march_uniforms(atmosphere), CLASS_FEATURES


def march_light(atmosphere, quality, draw, textures, table, moons):
    """Return transmittance and single scattering (N, 4) of rays for one sun of irradiance 1.

    Parameters
    ----------
    atmosphere, quality : Atmosphere, Quality
    draw : callable
        (fragment, defines, uniforms, textures, outputs) -> list of (N, 4) arrays, one ray per row.
    textures : dict
        u_ray, u_axis, u_limits of march_probe.frag, and u_base and u_direction where moons shade the air.
    table : tuple of dict
        Samplers and uniforms of the table of columns.
    moons : tuple of dict
        Defines, uniforms and samplers of eclipse.glsl.
    """
    defines = {**march_defines(atmosphere, quality), "HAS_SHADOW": True, **moons[0]}
    uniforms = {**march_uniforms(atmosphere), **table[1], **moons[1]}
    uniforms |= cone_uniforms("u_shadow", cylinder(atmosphere.bottom_radius))
    return draw("march_probe.frag", defines, uniforms, {**textures, **table[0], **moons[2]}, 2)
