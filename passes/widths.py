"""Pass 5, first half: linearized depths, the cuts of the view path, lit and shadowed widths."""

from shadowatmo.depth import CONVENTIONS
from shadowatmo.errors import ParameterError
from shadowatmo.passes.base import RenderPass, depth_test
from shadowatmo.passes.canvas import drawing_in
from shadowatmo.passes.gl.textures import Target
from shadowatmo.passes.multiple_view import is_high
from shadowatmo.passes.terminator import dusk_uniforms, high_sun
from shadowatmo.passes.terminator_moons import terminator_moons_inputs
from shadowatmo.screen import area

KINDS_OF_BUFFER = ("standard", "reversed", "logarithmic")  # what a depth attachment can hold
# weights of distance, shadow's begin, shadow's end and far end in each field
FIELDS = {"depth": (1.0, 0.0, 0.0, 0.0), "lit_width": (0.0, 1.0, -1.0, 1.0), "shadow_width": (0.0, -1.0, 1.0, 0.0)}
DEPTH_TEXTURES = ("shadow_back", "shadow_front", "atmosphere_back")
CONVENTION_DEFINES = {f"CONVENTION_{name.upper()}": number for number, name in enumerate(CONVENTIONS)}


class Widths(RenderPass):
    """Cuts the path of every pixel through the air by the depths of the passes before it, or by closed forms."""

    name = "widths"
    outputs = ("cuts", "class")

    def __init__(self, ctx, size):
        super().__init__(ctx, size)
        self.target = self.own(Target(ctx, size, color=("rgba32f",), depth="d32f"))

    def draw(self, view, textures, sun, window=None):
        """Draw a frame, or a window (left, bottom, right, top) of it; an empty one means nothing."""
        window = window or (0, 0, *self.size)
        textures["cuts"], textures["class"] = self.target.color[0], self.target.depth
        if not area(window):
            return
        defines, uniforms, samplers = cuts_inputs(view, textures, sun)
        if view.quality.method == "table4d" and "inscatter" in textures:
            defines["HAS_OPEN_CLASS"] = True
        if has_long_paths(view):
            defines["HAS_LONG_PATHS"] = True
        if view.has_terminator(sun):
            moons = bool(terminator_moons_inputs(sun, textures)[0])
            uniforms["u_high_sun"] = high_sun(view.scene.atmosphere, sun, moons)
        with drawing_in(self.target.framebuffer, window), depth_test(self.ctx, "1"):
            self.fullscreen("widths.frag", defines, uniforms, samplers)


def has_long_paths(view) -> bool:
    """Return whether lit paths about their tangent point in dense air are drawn as two pieces, see widths.frag."""
    return view.quality.method == "segments" and is_high(view)


def cuts_inputs(view, textures, sun) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers of cuts.glsl for one sun."""
    defines, samplers = view.defines(), {}
    uniforms = {**view.depth_uniforms(), **view.shadow_uniforms(sun)}
    if view.has_terminator(sun):
        defines["HAS_TERMINATOR"] = True
        uniforms |= dusk_uniforms(view.scene.atmosphere)
    if view.quality.depth == "textures" and not view.is_remote:
        defines["HAS_DEPTH_TEXTURES"] = True
        samplers |= {f"u_{name}": textures[name] for name in DEPTH_TEXTURES}
    if "planet_depth" in textures and not view.is_remote:
        defines["HAS_PLANET_DEPTH"] = True
        samplers["u_planet_depth"] = textures["planet_depth"]
    if "host_depth" in textures:
        host = host_depth_inputs(view, textures)
        defines, uniforms, samplers = {**defines, **host[0]}, {**uniforms, **host[1]}, {**samplers, **host[2]}
    return defines, uniforms, samplers


def host_depth_inputs(view, textures) -> tuple[dict, dict, dict]:
    """Return defines, uniforms and samplers that depth.glsl needs to read a host's depth."""
    depth = view.camera.depth
    defines = {"HAS_HOST_DEPTH": True, "CONVENTION": CONVENTIONS.index(depth.kind), **CONVENTION_DEFINES}
    convention = (depth.near, min(depth.far, 3e38), depth.coefficient, depth.meters_per_unit)
    return defines, {"u_host_convention": convention}, {"u_host_depth": textures["host_depth"]}


class Field(RenderPass):
    """One field of the cuts as a texture of its own; drawn when somebody asks for it."""

    def __init__(self, ctx, size, name):
        super().__init__(ctx, size)
        self.weights = FIELDS[name]
        self.target = self.own(Target(ctx, size, color=("r32f",)))

    def draw(self, textures):
        self.target.framebuffer.use()
        self.fullscreen("field.frag", {}, {"u_weights": self.weights}, {"u_cuts": textures["cuts"]})
        return self.target.color[0]


def check_convention(texture, convention) -> None:
    """Raise ParameterError where a host's texture cannot hold what its convention says."""
    if texture.depth and convention.kind not in KINDS_OF_BUFFER:
        raise ParameterError(
            "camera.depth",
            convention.kind,
            f"one of {', '.join(KINDS_OF_BUFFER)} for a depth texture: Camera(depth=DepthConvention('standard', ...))",
        )
    if convention.kind == "position" and texture.components < 3:
        raise ParameterError("depth", f"a texture of {texture.components} components", "3 or 4 for positions")
