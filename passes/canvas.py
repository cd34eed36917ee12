"""What the air is drawn into: our own picture, which knows where it is not black, or a host's texture."""

import ctypes
from contextlib import contextmanager

import moderngl

from shadowatmo.passes.gl.functions import GL_TEXTURE_2D, gl_functions
from shadowatmo.passes.gl.textures import Target
from shadowatmo.screen import holds

GL_MAX_DUAL_SOURCE_DRAW_BUFFERS, GL_SRC1_COLOR = 0x88FC, 0x88F9
GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE, GL_FLOAT, GL_LINEAR = 0x8D40, 0x8CE0, 0x1702, 0x1406, 0x2601
# factors of what is drawn and of what is there, of light and of alpha; the air's transmittance is the second output
IN_PLACE = 1, GL_SRC1_COLOR, 1, 0
IN_HOST = 1, GL_SRC1_COLOR, 0, 1
ADDED = 1, 1, 0, 1
# of an attachment: what it is, its name, its level, the type of its components, its encoding
ATTACHMENT_QUERIES = (0x8CD0, 0x8CD1, 0x8CD2, 0x8211, 0x8210)


class Canvas:
    """A picture of our own. Only what was drawn into it is cleared.

    Parameters
    ----------
    ctx : moderngl.Context
    size : (int, int)
        Pixels.
    depth : moderngl.Texture, optional
        Of somebody else, for tests against it.
    """

    keeps_alpha = False  # alpha is how much of the background the air hides

    def __init__(self, ctx, size, depth=None):
        self.size = size
        self._target = Target(ctx, size, color=("rgba32f",), depth=depth)
        self.framebuffer, self.color = self._target.framebuffer, self._target.color[0]
        self._drawn = [(0, 0, *size)]

    def clear(self, kept=None) -> None:
        """Make it black, but for a window (left, bottom, right, top) that will be written whole."""
        self.framebuffer.use()
        for left, bottom, right, top in self._drawn:
            if kept is None or not holds(kept, (left, bottom, right, top)):
                self.framebuffer.clear(viewport=(left, bottom, right - left, top - bottom))
        self._drawn = []

    def mark(self, *windows) -> None:
        """Remember that windows, or None, are drawn into."""
        self._drawn += [window for window in windows if window is not None and window not in self._drawn]

    def release(self) -> None:
        """Release the texture."""
        self._target.release()


class HostCanvas:
    """A host's texture, for as long as a frame takes: a framebuffer that has nothing else attached.

    Parameters
    ----------
    framebuffer : moderngl.Framebuffer
        Ours.
    color : moderngl.Texture
        The host's.
    """

    keeps_alpha = True

    def __init__(self, framebuffer, color):
        self.framebuffer, self.color = framebuffer, color

    def mark(self, *windows) -> None:
        """Nothing of a host's is ever cleared."""


def has_dual_source(ctx) -> bool:
    """Return whether a shader can hand the blending a factor of its own for what is there."""
    return gl_functions(ctx).integer(GL_MAX_DUAL_SOURCE_DRAW_BUFFERS) > 0


def draws_into(ctx, target, color) -> bool:
    """Return whether the whole of a host's framebuffer has a texture as its color, in linear floats."""
    whole = tuple(target.viewport) == (0, 0, *target.size) and target.scissor in (None, (0, 0, *target.size))
    if target.glo == 0 or not whole or not all(color_mask(target)):
        return False
    return attachment(ctx, target.glo) == (GL_TEXTURE, color.glo, 0, GL_FLOAT, GL_LINEAR)


def color_mask(target) -> tuple[bool, ...]:
    """Return which channels of a framebuffer's first color are written."""
    mask = target.color_mask
    return tuple(mask[0] if isinstance(mask[0], (tuple, list)) else mask)


def shares(ctx, target, color) -> bool:
    """Return whether the first color of a host's framebuffer is a texture, of whatever format."""
    return target.glo != 0 and attachment(ctx, target.glo)[:2] == (GL_TEXTURE, color.glo)


def attachment(ctx, name) -> tuple[int, ...]:
    """Return what ATTACHMENT_QUERIES say of the first color of a framebuffer, given by its OpenGL name."""
    gl = gl_functions(ctx)
    gl.BindFramebuffer(GL_FRAMEBUFFER, name)
    first = GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0
    kind = gl.attachment(*first, ATTACHMENT_QUERIES[0])
    return kind, *(gl.attachment(*first, query) for query in ATTACHMENT_QUERIES[1:] if kind == GL_TEXTURE)


@contextmanager
def host_canvas(ctx, color):
    """Yield a HostCanvas of a texture; its framebuffer is gone afterwards."""
    gl = gl_functions(ctx)
    names = (ctypes.c_uint * 1)()
    gl.GenFramebuffers(1, names)
    try:
        gl.BindFramebuffer(GL_FRAMEBUFFER, names[0])
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, color.glo, 0)
        yield HostCanvas(ctx.detect_framebuffer(names[0]), color)
    finally:
        ctx.detect_framebuffer(0).use()
        gl.DeleteFramebuffers(1, names)


@contextmanager
def drawing_in(framebuffer, window):
    """Draw into a window (left, bottom, right, top) of a framebuffer, and give the framebuffer its viewport back."""
    left, bottom, right, top = window
    before = framebuffer.viewport
    framebuffer.viewport = left, bottom, right - left, top - bottom
    framebuffer.use()
    try:
        yield
    finally:
        framebuffer.viewport = before


@contextmanager
def blended(ctx, factors):
    """Blend by factors as above, or not at all (None), and leave blending off again."""
    if factors is not None:
        ctx.enable(moderngl.BLEND)
        ctx.blend_func = factors
    try:
        yield
    finally:
        ctx.disable(moderngl.BLEND)
        ctx.blend_func = moderngl.ONE, moderngl.ZERO
