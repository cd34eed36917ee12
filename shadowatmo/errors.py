"""The exceptions of shadowatmo.

Every error the caller can mend says what was wrong, what was expected, what was given and, where there is
one, the remedy. All derive from `ShadowAtmoError`, so one `except` catches the lot.
"""


class ShadowAtmoError(Exception):
    """Base of every exception that shadowatmo raises on purpose."""


class ParameterError(ShadowAtmoError, ValueError):
    """A parameter has a value outside its allowed range.

    Parameters
    ----------
    name : str
        Name of the parameter, as the caller wrote it.
    value : object
        The value that was given.
    allowed : str
        The allowed range, with its unit, in words: ``"finite and > 0 m"``.
    """

    def __init__(self, name, value, allowed):
        self.name = name
        self.value = value
        self.allowed = allowed
        super().__init__(name, value, allowed)

    def __str__(self):
        return f"{self.name} = {self.value!r} is not allowed; expected {self.allowed}"


class ContextError(ShadowAtmoError):
    """There is no usable OpenGL context; the message names the remedy."""


class ShaderError(ShadowAtmoError):
    """A shader could not be composed, compiled, linked or fed; the message names file and line."""


class PassError(ShadowAtmoError):
    """A pass or its inputs do not fit together."""
