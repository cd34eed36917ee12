"""The 4D table of one camera: two of its axes are the same for all pixels, and are mixed once and not per pixel."""

from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.table4d import LAYOUTS, PUBLISHED, axis_uniforms, table4d_sizes
from shadowatmo.passes.table_build import inscatter_samplers

VIEW_TEXTURES = tuple(f"view_{name}" for name in LAYOUTS["packed"])


class Table4DView(RenderPass):
    """The table at the camera's height and under one sun, over nu and mu; for cameras inside the air."""

    name = "table4d_view"
    inputs = LAYOUTS["packed"]
    outputs = VIEW_TEXTURES

    def __init__(self, ctx):
        super().__init__(ctx, (PUBLISHED.cosines, PUBLISHED.views))
        self.target = self.own(Target(ctx, self.size, color=("rgba32f", "rgba32f")))
        for texture in self.target.color:
            texture.filter = (ctx.LINEAR, ctx.LINEAR)

    def draw(self, view, textures, sun):
        for name in VIEW_TEXTURES:
            textures.pop(name, None)
        if not view.is_inside or "inscatter" not in textures:
            return
        uniforms = {**view.camera_uniforms(), **axis_uniforms(view.scene.atmosphere), **view.axis_uniforms(sun)}
        defines = table4d_sizes(PUBLISHED)
        if view.is_far:
            defines["HAS_FAR_CAMERA"] = True
        self.target.framebuffer.use()
        self.fullscreen("table4d_view.frag", defines, uniforms, inscatter_samplers(textures))
        textures |= dict(zip(VIEW_TEXTURES, self.target.color, strict=True))
