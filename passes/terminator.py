"""A sun's finite disc behind the planet's limb: what terminator.glsl needs of it, and where a point does as well.

Single scattering and sunlight on the ground know the disc. Light scattered more than once keeps a point sun: its source
is smooth over distances that are long beside the penumbra.
"""

import math

from shadowatmo.passes.constants import cone_uniforms, glsl_array
from shadowatmo.passes.terminator_moons import terminator_moons_inputs
from shadowatmo.shadow import cylinder
from shadowatmo.terminator import angular_radius, night_cone, strip_polynomials

# by terms of the closed form: strips of the visible part; 2 leave 0.4 % in the 95th percentile of lit points, 3 0.1 %
STRIPS = {4: 2, 6: 3}
# Angular radii above the horizontal beyond which the mean over the disc is its center's light: to 5e-4 of the brightest
# channel in the Earth's air and on Mars, to 3e-3 in a thick haze.
HIGH_SUN = 20.0
# The same where moons shade the air: they may leave the upper or the lower half of the disc, whose light differs more.
HIGH_SUN_UNDER_MOONS = 80.0


def terminator_defines(sun, quality) -> dict:
    """Return the features of terminator.glsl; empty for a sun that is taken for a point."""
    if not sun.disc_at_terminator:
        return {}
    count = STRIPS[quality.terms]
    nodes, weights = strip_polynomials(count)
    return {
        "HAS_TERMINATOR": True,
        "STRIPS": count,
        "STRIP_NODE_VALUES": glsl_array(nodes.T.ravel()),
        "STRIP_WEIGHT_VALUES": glsl_array(weights.T.ravel()),
    }


def terminator_uniforms(sun) -> dict:
    """Return the uniforms of terminator.glsl; empty for a sun that is taken for a point."""
    return {"u_sun_angle": angular_radius(sun)} if sun.disc_at_terminator else {}


def terminator_inputs(view, sun, textures) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers of terminator.glsl for a frame, those of moons before the disc included.

    Empty where the sun is a point.
    """
    if not view.has_terminator(sun):
        return {}, {}, {}
    moons = terminator_moons_inputs(sun, textures)
    return {**terminator_defines(sun, view.quality), **moons[0]}, {**terminator_uniforms(sun), **moons[1]}, moons[2]


def night_uniforms(atmosphere, sun) -> dict:
    """Return where the planet hides the whole disc, as the cone u_night."""
    return cone_uniforms("u_night", night_cone(atmosphere.bottom_radius, sun))


def dusk_uniforms(atmosphere) -> dict:
    """Return where the planet hides half of the disc or more, as the cone u_dusk."""
    return cone_uniforms("u_dusk", cylinder(atmosphere.bottom_radius))


def high_sun(atmosphere, sun, moons=False) -> float:
    """Return the height [m] above the terminator plane from which a sun's disc may be taken for a point."""
    radii = HIGH_SUN_UNDER_MOONS if moons else HIGH_SUN
    return atmosphere.top_radius * math.sin(min(radii * angular_radius(sun), 0.5 * math.pi))
