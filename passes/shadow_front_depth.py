"""Pass 2: depth of the front side of the planet's shadow."""

from shadowatmo.passes.shadow_back_depth import ShadowDepth


class ShadowFrontDepth(ShadowDepth):
    """Where rays enter the planet's shadow; the near plane for a camera inside it."""

    name = "shadow_front_depth"
    outputs = ("shadow_front",)
    faces = "front"
