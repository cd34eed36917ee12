"""How the report judges light: errors of rays, and their statistics.

A ray's light has three channels. Its relative error is the largest difference in a channel over its own brightest
channel; its error against the frame's maximum takes the brightest ray of the same scene instead. Rays whose brightest
channel is below FLOOR of that maximum have no relative error: they are counted, and said to be left out.
"""

import numpy as np

FLOOR = 1e-4
PERCENTILES = {"median": 50.0, "p95": 95.0, "p97": 97.0, "p99": 99.0, "max": 100.0}
BUDGET_PERCENTILE = "p97"  # of rays, what a budget of p95 is chosen by: the difference is the margin for other rays
FRAMES_PERCENTILE = "p95"  # of the pixels of the report's own frames


def ray_errors(got, truth) -> tuple[np.ndarray, np.ndarray]:
    """Return relative errors (N,), nan where left out, and errors against the frame's maximum (N,).

    Parameters
    ----------
    got, truth : (N, 3) float
        Light of the rays of one scene.
    """
    brightest = truth.max(axis=1)
    frame = max(float(brightest.max(initial=0.0)), 1e-30)
    difference = np.abs(got - truth).max(axis=1)
    seen = brightest > FLOOR * frame
    return np.where(seen, difference / np.where(seen, brightest, 1.0), np.nan), difference / frame


def statistics(errors) -> dict:
    """Return count, median, p95, p97, p99 and max of errors, and how many are nan, that is left out."""
    errors = np.asarray(errors, np.float64)
    judged = errors[~np.isnan(errors)]
    values = {name: float(np.percentile(judged, p)) if judged.size else 0.0 for name, p in PERCENTILES.items()}
    return {"rays": int(judged.size), "left_out": int(errors.size - judged.size), **values}


def budget_errors(relative, transmittance) -> np.ndarray:
    """Return what a budget counts of each ray (N,): the larger of its light's error and its transmittance's."""
    return np.fmax(relative, transmittance)
