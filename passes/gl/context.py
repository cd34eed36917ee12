"""Open, describe and check OpenGL contexts.

A host that draws already has a context, and we never make a second one beside it: `open_context` is for
headless use only. On Linux it asks EGL for its devices, takes the first one that is not a software renderer,
and falls back to the software renderer. At most one context is alive at any moment of that search: two live
contexts in a process confuse drivers, and ending one EGL display can end the other.
"""

import logging
import os
import re
import sys

import moderngl

from shadowatmo.errors import ContextError, ParameterError

logger = logging.getLogger("shadowatmo")

SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "software", "swiftshader", "lavapipe", "gdi generic",
                      "basic render")

_APT_LINE = "sudo apt-get install -y libegl1 libgl1 libgl1-mesa-dri"
_CHECK_LINE = "run `python -m shadowatmo check` for the whole picture"
_UNREACHABLE_DEVICE = 1 << 20  # asking EGL for it makes no context, and the refusal tells how many there are

# (pattern in the raw message, what it means and how to mend it); the first match wins
_REMEDIES = (
    (r"libEGL.*(not loaded|not found|cannot open)|support library libEGL|(libGL|libGL\.so).*not loaded"
     r"|cannot detect OpenGL",
     f"the EGL or GL library is missing; on Debian or Ubuntu: {_APT_LINE}"),
    (r"found 0 devices",
     f"EGL has no vendor driver; on Debian or Ubuntu: {_APT_LINE} libegl-mesa0; in an NVIDIA container set "
     "NVIDIA_DRIVER_CAPABILITIES=graphics"),
    (r"requested device index \d+, but found",
     "there is no such device; leave `device` out to take the best one"),
    (r"eglInitialize failed \(0x3001\)|eglInitialize failed",
     f"EGL found the device but no driver for it; on Debian or Ubuntu: {_APT_LINE}"),
    (r"eglCreateContext failed|Requested OpenGL version",
     "the driver's OpenGL version is too low for `require`; OpenGL 3.3 (330) is enough for shadowatmo, "
     "else update the driver"),
    (r"XOpenDisplay|cannot open display",
     "there is no X display; unset DISPLAY or use the headless context"),
)


def explain_failure(raw, require=330):
    """Turn the raw text of a failed context creation into one line with its remedy.

    Parameters
    ----------
    raw : str
        The message as the backend gave it.
    require : int
        The OpenGL version that was asked for, as in 330.

    Returns
    -------
    str
        What, where, got and remedy in one line.
    """
    text = " ".join(str(raw).split()) or "no message"
    for pattern, remedy in _REMEDIES:
        if re.search(pattern, text, re.IGNORECASE):
            return f"no OpenGL {require / 100:.1f} context: {text}; {remedy}"
    return f"no OpenGL {require / 100:.1f} context: {text}; {_CHECK_LINE}"


def is_software(renderer):
    """Whether a GL_RENDERER string names a renderer that runs on the CPU."""
    return any(word in renderer.lower() for word in SOFTWARE_RENDERERS)


def open_context(require=330, device=None):
    """Open a headless OpenGL context.

    Parameters
    ----------
    require : int
        Lowest OpenGL version, as in 330 for 3.3 core; 330 to 460.
    device : int, optional
        Index of the EGL device, >= 0 (Linux only). Without it the first hardware device is taken, else the
        first software one. The environment variable GLCONTEXT_DEVICE_INDEX decides before either.

    Returns
    -------
    moderngl.Context
        Current on the calling thread. The caller releases it.

    Raises
    ------
    ParameterError
        `require` or `device` out of range.
    ContextError
        No context could be made; the message names the remedy.
    """
    if isinstance(require, bool) or not isinstance(require, int) or not 330 <= require <= 460:
        raise ParameterError("require", require, "an integer from 330 (OpenGL 3.3) to 460")
    if device is not None and (isinstance(device, bool) or not isinstance(device, int) or device < 0):
        raise ParameterError("device", device, "None or an integer >= 0")
    if not sys.platform.startswith("linux"):
        ctx = _create(require)
    elif device is not None or os.environ.get("GLCONTEXT_DEVICE_INDEX"):
        ctx = _create(require, backend="egl", device_index=device)
    else:
        ctx = _open_best_device(require)
    renderer = ctx.info["GL_RENDERER"]
    logger.info("OpenGL %s on %s", ctx.info["GL_VERSION"], renderer)
    if is_software(renderer):
        logger.warning("%s draws on the CPU: expect seconds, not milliseconds, at large sizes", renderer)
    return ctx


def _create(require, **settings):
    """`moderngl.create_context` with every failure mapped to a `ContextError`."""
    settings = {key: value for key, value in settings.items() if value is not None}
    try:
        return moderngl.create_context(require=require, standalone=True, **settings)
    except Exception as error:  # the backends raise bare Exception, ImportError, OSError and ValueError
        raise ContextError(explain_failure(str(error), require)) from error


def _count_devices():
    """Number of EGL devices, or None where the backend does not say."""
    try:
        moderngl.create_context(require=330, standalone=True, backend="egl", device_index=_UNREACHABLE_DEVICE)
    except Exception as error:  # bare Exception from the backend
        found = re.search(r"found (\d+) devices", str(error))
        return int(found.group(1)) if found else None
    return None


def _open_best_device(require):
    """First hardware EGL device, else the first software one; never two contexts alive at once."""
    count = _count_devices()
    if count is None or count <= 1:
        return _create(require, backend="egl")
    software, first_error = None, None
    for index in range(count):
        try:
            ctx = _create(require, backend="egl", device_index=index)
        except ContextError as error:
            logger.debug("EGL device %d: %s", index, error)
            first_error = first_error or error
            continue
        if not is_software(ctx.info["GL_RENDERER"]):
            return ctx
        ctx.release()
        software = index if software is None else software
    if software is None:
        raise first_error
    return _create(require, backend="egl", device_index=software)


def check_alive(ctx):
    """Raise `ContextError` unless `ctx` is a moderngl context that has not been released.

    Parameters
    ----------
    ctx : moderngl.Context
        The context to look at; nothing is called on the driver.
    """
    if ctx is None:
        raise ContextError("ctx is None; expected a moderngl.Context, as from shadowatmo.open_context()")
    if not isinstance(ctx, moderngl.Context):
        raise ContextError(f"ctx is a {type(ctx).__name__}; expected a moderngl.Context")
    if not hasattr(ctx.mglo, "fbo"):  # release() swaps the native object for an empty one
        raise ContextError("ctx has been released; open a new one and build the renderer again")


def context_store(ctx):
    """Our own dictionary that lives exactly as long as `ctx`: programs, samplers, entry points.

    It sits on the context object, not in a table keyed by it: the values hold the context, so a table would
    keep every context alive for ever, and an `id` may come back for another context.
    """
    check_alive(ctx)
    return ctx.__dict__.setdefault("_shadowatmo", {})


def describe_context(ctx):
    """What a context is and can do.

    Parameters
    ----------
    ctx : moderngl.Context
        A live context.

    Returns
    -------
    dict
        ``vendor``, ``renderer``, ``version`` (str), ``version_code`` (int), ``software`` (bool) and the
        capabilities ``compute``, ``clip_control``, ``timer`` (bool), ``max_texture_size`` (int, texels),
        ``max_viewport`` (pair of int, pixels).
    """
    check_alive(ctx)
    info, extensions, version = ctx.info, ctx.extensions, ctx.version_code
    return {
        "vendor": info["GL_VENDOR"],
        "renderer": info["GL_RENDERER"],
        "version": info["GL_VERSION"],
        "version_code": version,
        "software": is_software(info["GL_RENDERER"]),
        "compute": version >= 430 or "GL_ARB_compute_shader" in extensions,
        "clip_control": version >= 450 or "GL_ARB_clip_control" in extensions,
        "timer": version >= 330 or "GL_ARB_timer_query" in extensions,
        "max_texture_size": int(info["GL_MAX_TEXTURE_SIZE"]),
        "max_viewport": tuple(int(n) for n in info["GL_MAX_VIEWPORT_DIMS"]),
    }
