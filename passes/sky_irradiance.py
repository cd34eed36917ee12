"""Skylight on the ground: irradiance by singly scattered light over the sun's height, so that shade is not black."""

import math

from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import (
    cone_uniforms,
    glsl_array,
    medium_defines,
    medium_uniforms,
    segment_defines,
    segment_uniforms,
    shadow_cone,
    transmittance_defines,
)
from shadowatmo.passes.gl.textures import Target
from shadowatmo.quadrature import gauss_legendre
from shadowatmo.quality import Quality

TEXELS = 64
WIDTH = 0.06  # of mu_s around the horizon that gets most texels
DIRECTIONS = (8, 8)  # zenith angles, azimuths over half the sky
EFFORT = Quality(nodes=8, gap_nodes=4)


class SkyIrradiance(RenderPass):
    """A row of irradiances per unit solar irradiance, made anew when the air changes."""

    name = "sky_irradiance"
    outputs = ("sky_irradiance",)

    def __init__(self, ctx):
        super().__init__(ctx, (TEXELS, 1))
        self.target = self.own(Target(ctx, self.size, color=("rgba32f",)))
        self.target.color[0].filter = (ctx.LINEAR, ctx.LINEAR)
        self._atmosphere = None

    def draw(self, atmosphere, textures):
        if atmosphere != self._atmosphere:
            nodes, weights = gauss_legendre(DIRECTIONS[0])
            defines = {
                "HAS_SHADOW": True,
                "HAS_TWO_PIECES": True,
                **medium_defines(atmosphere),
                **transmittance_defines(atmosphere, EFFORT),
                **segment_defines(EFFORT),
                "SKY_COUNT": DIRECTIONS[0],
                "AZIMUTHS": DIRECTIONS[1],
                "SKY_NODE_VALUES": glsl_array(nodes),
                "SKY_WEIGHT_VALUES": glsl_array(weights),
            }
            uniforms = {
                **medium_uniforms(atmosphere),
                **segment_uniforms(atmosphere),
                **cone_uniforms("u_shadow", shadow_cone(atmosphere, None, "cylinder")),
                **irradiance_mapping(atmosphere),
            }
            self.target.framebuffer.use()
            self.fullscreen("sky_irradiance.frag", defines, uniforms)
            self._atmosphere = atmosphere
        textures["sky_irradiance"] = self.target.color[0]


def irradiance_mapping(atmosphere) -> dict:
    """Return the uniforms of sky_irradiance.glsl: the row ends where the whole visible sky is in shadow."""
    dip = 2.2 * math.acos(atmosphere.bottom_radius / atmosphere.top_radius)
    lowest = -math.sin(min(math.radians(85.0), dip))
    return {"u_irradiance_mapping": (WIDTH, lowest), "u_irradiance_texels": float(TEXELS)}
