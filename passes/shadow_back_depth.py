"""Pass 1: depth of the back side of the planet's shadow."""

import numpy as np

from shadowatmo.passes.base import RenderPass, depth_test
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.proxy import Proxy, cone_mesh


class ShadowDepth(RenderPass):
    """Depth of one side of the shadow volume: coverage by a proxy, distance by the closed form.

    The nearest depth stands for "no shadow here" on either side, so that a ray without a shadow has one of no width.
    """

    faces: str

    def __init__(self, ctx, size, depth_format):
        super().__init__(ctx, size)
        self.target = self.own(Target(ctx, size, color=(), depth=depth_format))
        self.proxy = self.own(Proxy(ctx))
        self.nearest = 1.0 if depth_format == "d32f" else 0.0

    def draw(self, view, textures, sun):
        atmosphere = view.scene.atmosphere
        cone, rasterized = view.shadow_cone(sun), view.quality.depth_bits == 24
        axis = -np.array(sun.direction)
        self.proxy.update(
            (cone, sun.direction, atmosphere.top_radius, rasterized),
            lambda: cone_mesh(cone, axis, atmosphere.top_radius, circumscribed=not rasterized),
        )
        framebuffer = self.target.framebuffer
        framebuffer.use()
        framebuffer.clear(depth=self.nearest)
        uniforms = {**view.depth_uniforms(), **view.shadow_uniforms(sun)}
        with depth_test(self.ctx, "1"):
            self.proxy.draw(f"{self.name}.frag", view.defines(), uniforms, view, self.faces)
        textures[self.outputs[0]] = self.target.depth


class ShadowBackDepth(ShadowDepth):
    """Where rays leave the planet's shadow."""

    name = "shadow_back_depth"
    outputs = ("shadow_back",)
    faces = "back"
