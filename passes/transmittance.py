"""The table of columns to the top of the air, for `Quality(transmittance="table")`."""

from shadowatmo.passes.base import RenderPass
from shadowatmo.passes.constants import column_uniforms, medium_defines, medium_uniforms
from shadowatmo.passes.gl.textures import Target

TABLE_SIZE = (256, 64)  # zenith angle, altitude
NODES = 40


class TransmittanceTable(RenderPass):
    """Columns of molecules, aerosols and ozone over altitude and zenith angle, made anew when the air changes."""

    name = "transmittance"
    outputs = ("column_table",)

    def __init__(self, ctx, size=TABLE_SIZE):
        super().__init__(ctx, size)
        self.target = self.own(Target(ctx, size, color=("rgba32f",)))
        self.target.color[0].filter = (ctx.LINEAR, ctx.LINEAR)
        self._atmosphere = None

    def draw(self, atmosphere, textures):
        if atmosphere != self._atmosphere:
            defines = {"HAS_TABLE_MAPPING": True, **medium_defines(atmosphere), "TERMS": 6, "COLUMN_COUNT": NODES}
            self.target.framebuffer.use()
            uniforms = {**medium_uniforms(atmosphere), **column_uniforms(NODES), "u_table_size": self.size}
            self.fullscreen("transmittance.frag", defines, uniforms)
            self._atmosphere = atmosphere
        textures["column_table"] = self.target.color[0]


def table_samplers(uniforms, textures) -> dict:
    """Return the table's sampler where there is a table, and add its size to `uniforms`."""
    if "column_table" not in textures:
        return {}
    uniforms["u_table_size"] = textures["column_table"].size
    return {"u_column_table": textures["column_table"]}
