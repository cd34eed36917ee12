"""Raw OpenGL entry points for what moderngl has no call for: queries, 32-bit float depth, the state guard.

The functions come from the loader of the context itself, so no other GL binding is needed, and they are right
for detected windows as for headless contexts. Every function is typed once and kept per context.
"""

import ctypes
import sys

from _moderngl import DefaultLoader

from shadowatmo.errors import ContextError
from shadowatmo.passes.gl.context import check_alive, context_store

_FUNCTYPE = ctypes.WINFUNCTYPE if sys.platform.startswith("win") else ctypes.CFUNCTYPE

_E = ctypes.c_uint  # GLenum, GLuint, GLbitfield
_I = ctypes.c_int  # GLint, GLsizei
_F = ctypes.c_float
_D = ctypes.c_double
_B = ctypes.c_ubyte  # GLboolean
_P = ctypes.c_void_p  # any pointer

# name without gl -> (result, arguments); all are in OpenGL 3.3 core unless listed in _OPTIONAL
_SIGNATURES = {
    "GetIntegerv": (None, _E, _P), "GetFloatv": (None, _E, _P), "GetDoublev": (None, _E, _P),
    "GetIntegeri_v": (None, _E, _E, _P), "GetInteger64i_v": (None, _E, _E, _P),
    "GetBooleani_v": (None, _E, _E, _P),
    "IsEnabled": (_B, _E), "IsEnabledi": (_B, _E, _E), "GetError": (_E,),
    "Enable": (None, _E), "Disable": (None, _E), "Enablei": (None, _E, _E), "Disablei": (None, _E, _E),
    "UseProgram": (None, _E), "BindVertexArray": (None, _E),
    "BindFramebuffer": (None, _E, _E), "BindRenderbuffer": (None, _E, _E), "BindBuffer": (None, _E, _E),
    "BindBufferBase": (None, _E, _E, _E),
    "BindBufferRange": (None, _E, _E, _E, ctypes.c_ssize_t, ctypes.c_ssize_t),
    "ActiveTexture": (None, _E), "BindTexture": (None, _E, _E), "BindSampler": (None, _E, _E),
    "Viewport": (None, _I, _I, _I, _I), "Scissor": (None, _I, _I, _I, _I),
    "ViewportArrayv": (None, _E, _I, _P), "ScissorArrayv": (None, _E, _I, _P),
    "DepthRangeArrayv": (None, _E, _I, _P), "GetFloati_v": (None, _E, _E, _P),
    "GetDoublei_v": (None, _E, _E, _P),
    "PolygonOffsetClamp": (None, _F, _F, _F), "IsTexture": (_B, _E), "IsProgram": (_B, _E),
    "BlendFuncSeparate": (None, _E, _E, _E, _E), "BlendEquationSeparate": (None, _E, _E),
    "BlendFuncSeparatei": (None, _E, _E, _E, _E, _E), "BlendEquationSeparatei": (None, _E, _E, _E),
    "BlendColor": (None, _F, _F, _F, _F),
    "DepthFunc": (None, _E), "DepthMask": (None, _B), "DepthRange": (None, _D, _D),
    "CullFace": (None, _E), "FrontFace": (None, _E),
    "StencilFuncSeparate": (None, _E, _E, _I, _E), "StencilMaskSeparate": (None, _E, _E),
    "StencilOpSeparate": (None, _E, _E, _E, _E),
    "ColorMask": (None, _B, _B, _B, _B), "ColorMaski": (None, _E, _B, _B, _B, _B),
    "ClearColor": (None, _F, _F, _F, _F), "ClearDepth": (None, _D), "ClearStencil": (None, _I),
    "PolygonMode": (None, _E, _E), "PolygonOffset": (None, _F, _F),
    "PrimitiveRestartIndex": (None, _E), "SampleCoverage": (None, _F, _B), "SampleMaski": (None, _E, _E),
    "LogicOp": (None, _E), "PixelStorei": (None, _E, _I), "LineWidth": (None, _F), "PointSize": (None, _F),
    "ProvokingVertex": (None, _E), "ClipControl": (None, _E, _E), "ClampColor": (None, _E, _E),
    "BeginConditionalRender": (None, _E, _E), "EndConditionalRender": (None,),
    "TexImage2D": (None, _E, _I, _I, _I, _I, _I, _E, _E, _P), "TexParameteri": (None, _E, _E, _I),
    "GetTexLevelParameteriv": (None, _E, _I, _E, _P), "ReadBuffer": (None, _E), "DrawBuffers": (None, _I, _P),
    "ReadPixels": (None, _I, _I, _I, _I, _E, _E, _P),
    "GenTextures": (None, _I, _P), "DeleteTextures": (None, _I, _P),
    "GenSamplers": (None, _I, _P), "DeleteSamplers": (None, _I, _P),
    "GenBuffers": (None, _I, _P), "DeleteBuffers": (None, _I, _P),
    "BufferData": (None, _E, ctypes.c_ssize_t, _P, _E),
    "GenVertexArrays": (None, _I, _P), "DeleteVertexArrays": (None, _I, _P),
    "GenFramebuffers": (None, _I, _P), "DeleteFramebuffers": (None, _I, _P),
    "FramebufferTexture2D": (None, _E, _E, _E, _E, _I), "GetFramebufferAttachmentParameteriv": (None, _E, _E, _E, _P),
    "GenRenderbuffers": (None, _I, _P), "DeleteRenderbuffers": (None, _I, _P),
}
# name -> (version that has it in core, extension that brings it); drivers hand out addresses for any name at
# all, so only the version and the extensions tell whether a call is safe
_OPTIONAL = {
    "ClipControl": (450, "GL_ARB_clip_control"),
    "BlendFuncSeparatei": (400, "GL_ARB_draw_buffers_blend"),
    "BlendEquationSeparatei": (400, "GL_ARB_draw_buffers_blend"),
    "ViewportArrayv": (410, "GL_ARB_viewport_array"), "ScissorArrayv": (410, "GL_ARB_viewport_array"),
    "DepthRangeArrayv": (410, "GL_ARB_viewport_array"), "GetFloati_v": (410, "GL_ARB_viewport_array"),
    "GetDoublei_v": (410, "GL_ARB_viewport_array"),
    "PolygonOffsetClamp": (460, "GL_ARB_polygon_offset_clamp"),
}

GL_TEXTURE_2D = 0x0DE1
GL_TEXTURE_DEPTH_SIZE = 0x884A


class GLFunctions:
    """Entry points as attributes without their prefix: ``gl.BindTexture(target, name)``.

    Parameters
    ----------
    ctx : moderngl.Context
        The context they belong to; it must be current when one is called.
    """

    def __init__(self, ctx):
        self._version = ctx.version_code
        self._extensions = ctx.extensions
        native = getattr(ctx.mglo, "_context", None)
        self._load = getattr(native, "load_opengl_function", None) or DefaultLoader().load_opengl_function
        self._scratch = (ctypes.c_int * 16)()
        self._float_scratch = (ctypes.c_float * 16)()

    def __getattr__(self, name):
        if name.startswith("_") or name not in _SIGNATURES:
            raise AttributeError(name)
        if not self.has(name):
            version, extension = _OPTIONAL[name]
            raise ContextError(f"gl{name} needs OpenGL {version / 100:.1f} or {extension}; "
                               f"this context has {self._version / 100:.1f}")
        address = self._load("gl" + name)
        if not address:
            raise ContextError(f"the driver has no gl{name}; OpenGL 3.3 core is needed")
        function = _FUNCTYPE(*_SIGNATURES[name])(ctypes.cast(address, _P).value)
        setattr(self, name, function)
        return function

    def has(self, name):
        """Whether the context offers the entry point `name` (written without its prefix)."""
        version, extension = _OPTIONAL.get(name, (0, ""))
        return self._version >= version or extension in self._extensions

    def supports(self, version, extension):
        """Whether a feature is there: by core version, as in 450, or by extension."""
        return self._version >= version or extension in self._extensions

    def integers(self, name, count=1):
        """`count` values of glGetIntegerv as a tuple of int."""
        self.GetIntegerv(name, self._scratch)
        return tuple(self._scratch[:count])

    def integer(self, name):
        """The first value of glGetIntegerv."""
        self.GetIntegerv(name, self._scratch)
        return self._scratch[0]

    def floats(self, name, count=1):
        """`count` values of glGetFloatv as a tuple of float."""
        self.GetFloatv(name, self._float_scratch)
        return tuple(self._float_scratch[:count])

    def attachment(self, target, point, query):
        """One value of glGetFramebufferAttachmentParameteriv."""
        self.GetFramebufferAttachmentParameteriv(target, point, query, self._scratch)
        return self._scratch[0]

    def bound_texture_has_depth(self):
        """Whether the 2D texture of the active unit has a depth format."""
        self.GetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_DEPTH_SIZE, self._scratch)
        return self._scratch[0] > 0


def gl_functions(ctx):
    """The entry points of `ctx`, loaded on first use and kept with the context."""
    check_alive(ctx)
    store = context_store(ctx)
    if "functions" not in store:
        store["functions"] = GLFunctions(ctx)
    return store["functions"]
