"""Moons before a sun whose disc the planet's limb hides in part: what terminator_moons.glsl needs."""

import numpy as np

from shadowatmo.passes.eclipse import eclipse_inputs
from shadowatmo.quadrature import gauss_legendre

RULE = 16  # strips above the horizon, and as many below it


def terminator_moons_inputs(sun, textures) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers beside those of terminator.glsl and eclipse.glsl.

    Empty where no moon shades the air or the sun is a point at the planet's limb.
    """
    moons = eclipse_inputs(sun, textures)[0]
    count = moons.get("NARROW_MOONS", 0) + moons.get("WIDE_MOONS", 0)
    if not sun.disc_at_terminator or not count:
        return {}, {}, {}
    defines = {"HAS_TERMINATOR_MOONS": True, "DISC_MOONS": count, "STRIP_RULE": RULE}
    rule = np.column_stack(gauss_legendre(RULE))
    return defines, {"u_limb_darkening": sun.limb_darkening, "u_strip_count": RULE, "u_strip_rule": rule}, {}
