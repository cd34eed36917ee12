"""Checks that every public parameter goes through: one value in, the validated value out, or a ParameterError.

Each function takes the parameter's name first, so that the message can say which one was wrong, what was given and
what would have been right.
"""

import math

import numpy as np

from shadowatmo.errors import ParameterError


def number(name, value, *, low=-math.inf, high=math.inf, open_low=False, open_high=False) -> float:
    """Return `value` as a finite float inside the range; bools and strings are refused."""
    left, right = ("(" if open_low or math.isinf(low) else "["), (")" if open_high or math.isinf(high) else "]")
    allowed = f"a finite number in {left}{low:g}, {high:g}{right}"
    if isinstance(value, (bool, str, bytes)):
        raise ParameterError(name, value, allowed)
    try:
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(name, value, allowed) from None
    below = result <= low if open_low else result < low
    above = result >= high if open_high else result > high
    if not math.isfinite(result) or below or above:
        raise ParameterError(name, value, allowed)
    return result


def vector(name, value, *, low=-math.inf, high=math.inf, nonzero=False) -> tuple[float, float, float]:
    """Return `value` as a tuple of three finite floats, each inside [low, high]; `nonzero` refuses the null vector."""
    bounds = "" if math.isinf(low) and math.isinf(high) else f", each in [{low:g}, {high:g}]"
    allowed = f"3 finite numbers{bounds}" + (", not all zero" if nonzero else "")
    try:
        result = tuple(float(v) for v in value)
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(name, value, allowed) from None
    inside = all(math.isfinite(v) and low <= v <= high for v in result)
    if len(result) != 3 or not inside or (nonzero and not any(result)):
        raise ParameterError(name, value, allowed)
    return result


def unit_vector(name, value) -> tuple[float, float, float]:
    """Return `value` normalized in float64; any length but zero is accepted."""
    v = np.array(vector(name, value, nonzero=True))
    v = v / np.abs(v).max()  # keeps the square root away from overflow and underflow
    return tuple((v / math.sqrt(v @ v)).tolist())


def choice(name, value, allowed):
    """Return `value` if it is one of `allowed`."""
    if not any(value == a for a in allowed):
        raise ParameterError(name, value, "one of " + ", ".join(repr(a) for a in allowed))
    return value


def instance(name, value, kind, what):
    """Return `value` if it is an instance of `kind`; `what` describes the kind in the message."""
    if not isinstance(value, kind):
        raise ParameterError(name, value, what)
    return value


def integer(name, value, *, low, high) -> int:
    """Return `value` as an int inside [low, high]; floats are refused even where they are whole."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or not low <= value <= high:
        raise ParameterError(name, value, f"an integer in [{low}, {high}]")
    return int(value)
