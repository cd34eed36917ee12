"""Our own render targets: float colour textures and a 24-bit or 32-bit float depth texture.

moderngl makes 24-bit depth textures only, and imported textures cannot be attached. We therefore let it make
its 24-bit texture, give that texture new 32-bit float storage by one raw glTexImage2D before it is attached,
and let moderngl build the framebuffer: it then knows of the depth attachment, so clearing and masks work as
usual.
"""

from numbers import Integral

import moderngl
import numpy as np

from shadowatmo.errors import ContextError, ParameterError
from shadowatmo.passes.gl.context import check_alive
from shadowatmo.passes.gl.functions import GL_TEXTURE_2D, gl_functions

# format -> (components, moderngl dtype, bytes per texel)
COLOR_FORMATS = {"r32f": (1, "f4", 4), "rg32f": (2, "f4", 8), "rgba16f": (4, "f2", 8),
                 "rgba32f": (4, "f4", 16), "rgba8": (4, "f1", 4)}
DEPTH_FORMATS = {"d32f": 4, "d24": 4}  # bytes per texel

_GL_DEPTH_COMPONENT = 0x1902
_GL_DEPTH_COMPONENT32F = 0x8CAC
_GL_FLOAT = 0x1406
_GL_READ_FRAMEBUFFER = 0x8CA8
_GL_READ_FRAMEBUFFER_BINDING = 0x8CAA
_GL_PIXEL_PACK_BUFFER = 0x88EB
_GL_PIXEL_PACK_BUFFER_BINDING = 0x88ED
_GL_MAX_TEXTURE_SIZE = 0x0D33
_GL_MAX_VIEWPORT_DIMS = 0x0D3A
_GL_OUT_OF_MEMORY = 0x0505
# alignment, row length, skipped rows and pixels, swapped bytes
_GL_PACK_DEFAULTS = ((0x0D05, 1), (0x0D02, 0), (0x0D03, 0), (0x0D04, 0), (0x0D00, 0))


def check_size(ctx, size, name="size"):
    """`size` as two ints, or `ParameterError`.

    Parameters
    ----------
    ctx : moderngl.Context
        Its limits decide what is too large.
    size : (int, int)
        Width and height in pixels.
    name : str
        Name of the parameter for the message.

    Returns
    -------
    (int, int)
    """
    gl = gl_functions(ctx)
    limit = gl.integer(_GL_MAX_TEXTURE_SIZE)
    widest, highest = (min(limit, n) for n in gl.integers(_GL_MAX_VIEWPORT_DIMS, 2))
    allowed = f"(width, height) in whole pixels from (1, 1) to ({widest}, {highest})"
    try:
        width, height = size
    except (TypeError, ValueError):
        raise ParameterError(name, size, allowed) from None
    for value, most in ((width, widest), (height, highest)):
        if isinstance(value, (bool, np.bool_)) or not isinstance(value, Integral) or not 1 <= value <= most:
            raise ParameterError(name, size, allowed)
    return int(width), int(height)


class Target:
    """A framebuffer with its own colour textures and, if asked for, a depth texture.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context.
    size : (int, int)
        Width and height in pixels, from 1x1 to the driver's limit.
    color : sequence of str
        Formats of the colour attachments: "r32f", "rg32f", "rgba16f", "rgba32f", "rgba8". May be empty where
        there is depth.
    depth : str or moderngl.Texture, optional
        "d32f" (32-bit float, made for reversed depth) or "d24" (24-bit normalized), None for no depth; or the
        depth texture of another target, which stays that target's and is not written here.

    Attributes
    ----------
    framebuffer : moderngl.Framebuffer
        For use(), clear(depth=...) and viewport.
    color : tuple of moderngl.Texture
        NEAREST filter, CLAMP_TO_EDGE.
    depth : moderngl.Texture or None
        Comparison off, so that a sampler2D reads the stored value in red.

    Raises
    ------
    ParameterError
        A bad size or format.
    ContextError
        The context is gone, or the driver has no memory for it.
    """

    def __init__(self, ctx, size, color=("rgba32f",), depth=None):
        check_alive(ctx)
        self.ctx = ctx
        self.size = check_size(ctx, size)
        self.formats = (color,) if isinstance(color, str) else tuple(color)
        self._borrowed = depth if isinstance(depth, moderngl.Texture) else None
        self.depth_format = None if self._borrowed is not None else depth
        for form in self.formats:
            if form not in COLOR_FORMATS:
                raise ParameterError("color", color, f"a sequence of {', '.join(COLOR_FORMATS)}")
        if self.depth_format is not None and depth not in DEPTH_FORMATS:
            raise ParameterError("depth", depth, f"None or one of {', '.join(DEPTH_FORMATS)}")
        if not self.formats and depth is None:
            raise ParameterError("color", color, "at least one format where there is no depth")
        self.color, self.depth, self.framebuffer = (), None, None
        self._allocate()

    def _allocate(self):
        gl = gl_functions(self.ctx)
        self.ctx.clear_errors()  # an error left by the host must not be taken for ours
        try:
            for form in self.formats:
                self.color += (self._color_texture(form),)
            if self.depth_format is not None:
                self.depth = self._depth_texture(gl)
            code = gl.GetError()
            if code == 0:
                self.framebuffer = self.ctx.framebuffer(self.color, self.depth or self._borrowed)
                self.framebuffer.depth_mask = self._borrowed is None
                code = gl.GetError()
        except moderngl.Error as error:
            self.release()
            raise ContextError(f"no framebuffer of {self._describe()}: {error}") from error
        except BaseException:
            self.release()
            raise
        if code:
            self.release()
            reason = "out of memory" if code == _GL_OUT_OF_MEMORY else f"OpenGL error {code:#06x}"
            raise ContextError(f"no target of {self._describe()}: {reason}; take a smaller size")

    def _describe(self):
        formats = [*self.formats, *([self.depth_format] if self.depth_format else [])]
        return f"{self.size[0]}x{self.size[1]} {'+'.join(formats)} ({self.bytes / 2**20:.1f} MiB)"

    def _color_texture(self, form):
        components, dtype, _ = COLOR_FORMATS[form]
        texture = self.ctx.texture(self.size, components, dtype=dtype)
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        texture.repeat_x = texture.repeat_y = False
        return texture

    def _depth_texture(self, gl):
        texture = self.ctx.depth_texture(self.size)
        if self.depth_format == "d32f":
            texture.use(self.ctx.default_texture_unit)  # the unit moderngl itself keeps for such work
            gl.TexImage2D(GL_TEXTURE_2D, 0, _GL_DEPTH_COMPONENT32F, *self.size, 0, _GL_DEPTH_COMPONENT,
                          _GL_FLOAT, None)
        texture.compare_func = ""
        texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
        texture.repeat_x = texture.repeat_y = False
        return texture

    @property
    def bytes(self):
        """GPU memory of the attachments in bytes, as the formats say."""
        texel = sum(COLOR_FORMATS[form][2] for form in self.formats) + DEPTH_FORMATS.get(self.depth_format, 0)
        return texel * self.size[0] * self.size[1]

    def read_color(self, index=0):
        """Colour attachment `index` as float32 (h, w, components), row 0 at the bottom; rgba8 as 0..1."""
        components, _, _ = COLOR_FORMATS[self.formats[index]]
        data = self.framebuffer.read(components=components, attachment=index, dtype="f4", alignment=1)
        return np.frombuffer(data, np.float32).reshape(self.size[1], self.size[0], components)

    def read_depth(self):
        """The depth attachment as float32 (h, w), row 0 at the bottom.

        moderngl's own read of a depth texture can corrupt memory when a process has had two contexts, hence
        the raw glReadPixels. The host's pack state and read framebuffer are put back.
        """
        if self.depth is None:
            raise ParameterError("depth", None, "a target with a depth format")
        gl = gl_functions(self.ctx)
        saved = [(name, gl.integer(name)) for name, _ in _GL_PACK_DEFAULTS]
        read, pack = gl.integer(_GL_READ_FRAMEBUFFER_BINDING), gl.integer(_GL_PIXEL_PACK_BUFFER_BINDING)
        out = np.empty(self.size[::-1], np.float32)
        try:
            gl.BindFramebuffer(_GL_READ_FRAMEBUFFER, self.framebuffer.glo)
            gl.BindBuffer(_GL_PIXEL_PACK_BUFFER, 0)
            for name, value in _GL_PACK_DEFAULTS:
                gl.PixelStorei(name, value)
            gl.ReadPixels(0, 0, *self.size, _GL_DEPTH_COMPONENT, _GL_FLOAT, out.ctypes.data)
        finally:
            for name, value in saved:
                gl.PixelStorei(name, value)
            gl.BindBuffer(_GL_PIXEL_PACK_BUFFER, pack)
            gl.BindFramebuffer(_GL_READ_FRAMEBUFFER, read)
        return out

    def release(self):
        """Release framebuffer and textures; a second call does nothing."""
        if self.framebuffer is not None and self.ctx.mglo.fbo is self.framebuffer.mglo:
            # moderngl goes on binding the framebuffer it last used, and GL refuses a name that is gone
            self.ctx.detect_framebuffer(0).use()
        for item in (self.framebuffer, *self.color, self.depth):
            if item is not None:
                item.release()
        self.color, self.depth, self.framebuffer = (), None, None

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self.release()
