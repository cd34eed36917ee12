"""Pass 4: depth of the back side of the atmosphere."""

from shadowatmo.passes.base import RenderPass, depth_test
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.proxy import Proxy, sphere_mesh


class AtmosphereBackDepth(RenderPass):
    """Where rays leave the air through its top, whatever stands before; the nearest depth where they miss it."""

    name = "atmosphere_back_depth"
    outputs = ("atmosphere_back",)

    def __init__(self, ctx, size, depth_format):
        super().__init__(ctx, size)
        self.target = self.own(Target(ctx, size, color=(), depth=depth_format))
        self.proxy = self.own(Proxy(ctx))
        self.nearest = 1.0 if depth_format == "d32f" else 0.0

    def draw(self, view, textures):
        top, rasterized = view.scene.atmosphere.top_radius, view.quality.depth_bits == 24
        self.proxy.update((top, rasterized), lambda: sphere_mesh(top, circumscribed=not rasterized))
        framebuffer = self.target.framebuffer
        framebuffer.use()
        framebuffer.clear(depth=self.nearest)
        with depth_test(self.ctx, "1"):
            self.proxy.draw("atmosphere_back_depth.frag", view.defines(), view.depth_uniforms(), view, "back")
        textures["atmosphere_back"] = self.target.depth
