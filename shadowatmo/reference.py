"""The float64 truth: what a probe has to find, straight from the definitions and converged, without OpenGL.

Radiance is integrated by adaptive Gauss-Legendre panels. A ray is cut where its integrand is not smooth: at
the edges of the planet's shadow and of the occluders' cones, at its tangent point, where it crosses the kinks
of the ozone layer, and where the path to the sun touches them; dark pieces are dropped. A panel is halved
until its halves agree with it. Optical depths along the ray and toward the sun come from
`medium.path_columns`, the first one continued inside a panel by integrating the interpolating polynomial of
the panel's own nodes.

Multiple scattering is not part of it: `multiple` and `ground_multiple` are None in every result.
"""

import functools
from dataclasses import dataclass

import numpy as np

from shadowatmo import intervals, medium
from shadowatmo.eclipse import visibility
from shadowatmo.intervals import Interval
from shadowatmo.parameters import Atmosphere
from shadowatmo.phase import mie_phase, rayleigh_phase
from shadowatmo.rays import ProbeResult, Rays
from shadowatmo.scene import Scene
from shadowatmo.terminator_moons import visibility_above_limb

_CHUNK = 128  # panels at a time
_MAX_HALVINGS = 14
_FLOOR = 1e-7  # a channel counts for the tolerance as at least this much of the ray's brightest one


@dataclass(frozen=True)
class Accuracy:
    """How far the quadratures go; the defaults agree with twice the nodes to better than 1e-9.

    Parameters
    ----------
    nodes : int
        Gauss-Legendre nodes per panel along the ray.
    column_nodes : int
        The same per panel of an optical depth.
    disc_nodes : int
        Strips of a finite sun's disc.
    tolerance : float
        A panel is done when its halves differ from it by less than this share of the ray's radiance.
    """

    nodes: int = 12
    column_nodes: int = medium.COLUMN_NODES
    disc_nodes: int = 48
    tolerance: float = 1e-10


def probe(scene: Scene, origins, directions, t_max=None) -> ProbeResult:
    """Return what rays meet in the air, computed in float64; `multiple` and `ground_multiple` are None.

    Parameters
    ----------
    scene : Scene
        Light is summed over its suns; lengths belong to the first one.
    origins, directions : (N, 3) float
        [m], planet-centered; directions of any length but zero.
    t_max : (N,) float or float, optional
        Where the scene blocks each ray [m]; inf or None for nowhere.

    Returns
    -------
    ProbeResult

    Raises
    ------
    ParameterError
        If the rays are malformed.
    """
    return _probe(scene, Rays.validated(origins, directions, t_max), Accuracy())


def lengths(scene: Scene, origins, directions, t_max=None) -> ProbeResult:
    """Return segments and lengths of `probe` alone, cheap enough for a picture's rays; colors are None.

    Parameters and errors are those of `probe`.
    """
    rays = Rays.validated(origins, directions, t_max)
    return _lengths(scene, intervals.trace(scene.atmosphere, rays))


def transmittance_to_sun(atmosphere: Atmosphere, points, direction) -> np.ndarray:
    """Return the transmittance (N, 3) from `points` (N, 3) [m] toward `direction` (3,) to the top of the air.

    0 where the half-line meets the ground; 1 where it misses the air.
    """
    points = Rays.validated(points, np.ones(np.shape(points))).origins
    rays = Rays.validated(points, np.broadcast_to(np.asarray(direction, dtype=np.float64), points.shape))
    segments = intervals.trace(atmosphere, rays)
    result = _segment_transmittance(atmosphere, segments, medium.COLUMN_NODES)
    result[segments.end == "ground"] = 0.0
    return result


def _probe(scene: Scene, rays: Rays, accuracy: Accuracy) -> ProbeResult:
    """The probe at a given accuracy."""
    atmosphere = scene.atmosphere
    segments = intervals.trace(atmosphere, rays)
    transmittance = _segment_transmittance(atmosphere, segments, accuracy.column_nodes)
    single, ground = np.zeros((len(rays), 3)), np.zeros((len(rays), 3))
    for sun in scene.suns:
        irradiance = np.array(sun.irradiance)
        single += irradiance * _single(scene, sun, segments, accuracy)
        ground += irradiance * transmittance * _ground(scene, sun, segments, accuracy)
    return _lengths(scene, segments, transmittance=transmittance, single=single, ground_direct=ground)


def _lengths(scene, segments, transmittance=None, single=None, ground_direct=None) -> ProbeResult:
    """Collect a result from segments, colors and the lengths of sun 0."""
    atmosphere, sun = scene.atmosphere, scene.suns[0]
    shadow = _extent(intervals.planet_shadow(segments, atmosphere.bottom_radius, sun.direction))
    planet = intervals.cones(segments, np.zeros(3), atmosphere.bottom_radius, sun)
    bodies = [intervals.cones(segments, body.center, body.radius, sun) for body in scene.occluders]
    umbra, antumbra, outer = (
        np.stack([_extent(getattr(body, name)) for body in bodies], axis=1)
        if bodies
        else np.zeros((len(shadow), 0))
        for name in ("umbra", "antumbra", "outer")
    )
    return ProbeResult(
        t_in=segments.t_in,
        t_out=segments.t_out,
        t_end=segments.t_end,
        end=segments.end,
        transmittance=transmittance,
        single=single,
        multiple=None,
        ground_direct=ground_direct,
        ground_multiple=None,
        lit=segments.length - shadow,
        shadow=shadow,
        planet_umbra=_extent(planet.umbra),
        planet_penumbra=np.maximum(_extent(planet.outer) - _extent(planet.umbra), 0.0),
        umbra=umbra,
        antumbra=antumbra,
        penumbra=np.maximum(outer - umbra - antumbra, 0.0),
    )


def _extent(interval: Interval) -> np.ndarray:
    return interval[1] - interval[0]


def _segment_transmittance(atmosphere, segments, nodes):
    """Return exp(-optical depth) (N, 3) of the segments."""
    result = np.ones((len(segments), 3))
    through = segments.length > 0.0
    columns = medium.path_columns(
        atmosphere, segments.power[through], segments.slope[through], segments.length[through], nodes
    )
    result[through] = np.exp(-columns @ medium.extinction(atmosphere))
    return result


def _ground(scene, sun, segments, accuracy):
    """Return the radiance (N, 3) that the ground sends toward the rays that hit it, for irradiance 1.

    Of a finite disc every visible strip shines from its own height: a half-set sun still lights level ground.
    """
    atmosphere = scene.atmosphere
    result = np.zeros((len(segments), 3))
    rays = np.flatnonzero(segments.end == "ground")
    hits = segments.points(segments.length)[rays]
    cosine = hits @ np.array(sun.direction) / np.linalg.norm(hits, axis=1)
    day = cosine > (-sun.radius / sun.distance if sun.disc_at_terminator else 0.0)
    rays, hits, cosine = rays[day], hits[day], cosine[day]
    power = np.zeros(len(rays))  # the hits lie on the datum, whatever rounding says
    slope = hits @ np.array(sun.direction)
    light = _sunlight(scene, sun, hits, power, slope, accuracy, horizontal=True)
    light *= 1.0 if sun.disc_at_terminator else cosine[:, None]
    result[rays] = np.array(atmosphere.ground_albedo) / np.pi * light
    return result


def _single(scene, sun, segments, accuracy):
    """Return the single scattering (N, 3) of one sun of irradiance 1, panels refined until they agree."""
    ray, start, stop = _lit_panels(scene, sun, segments)
    count = len(segments)
    done = np.zeros((count, 3))
    value = _integrate(scene, sun, segments, accuracy, ray, start, stop)
    joint = len(scene.occluders) > 1 or scene.rings or (scene.occluders and sun.disc_at_terminator)
    tolerance = max(accuracy.tolerance, 1e-7) if joint else accuracy.tolerance
    for halving in range(_MAX_HALVINGS):
        if not ray.size:
            break
        middle = 0.5 * (start + stop)
        halves = [
            _integrate(scene, sun, segments, accuracy, ray, a, b)
            for a, b in ((start, middle), (middle, stop))
        ]
        better = halves[0] + halves[1]
        total = done + _sum_by_ray(ray, better, count)
        scale = np.maximum(total, _FLOOR * total.max(axis=1, keepdims=True))[ray]
        open_ = (np.abs(better - value) > tolerance * scale).any(axis=1) & (halving < _MAX_HALVINGS - 1)
        done += _sum_by_ray(ray[~open_], better[~open_], count)
        ray = np.concatenate([ray[open_], ray[open_]])
        start, stop = (
            np.concatenate([start[open_], middle[open_]]),
            np.concatenate([middle[open_], stop[open_]]),
        )
        value = np.concatenate([halves[0][open_], halves[1][open_]])
    return done


def _sum_by_ray(ray, values, count):
    return np.stack([np.bincount(ray, values[:, c], minlength=count) for c in range(3)], axis=1)


def _lit_panels(scene, sun, segments):
    """Return ray, start and stop [m] of the panels outside the planet's shadow, cut where light has kinks."""
    radius = scene.atmosphere.bottom_radius
    if sun.disc_at_terminator:
        dark, partial = intervals.disc_cones(segments, radius, sun)
        cuts = [*dark, *partial]
    else:
        dark = intervals.planet_shadow(segments, radius, sun.direction)
        cuts = [*dark]
    cuts += [np.clip(-segments.slope, 0.0, segments.length), np.zeros(len(segments)), segments.length]
    for altitude in (0.0, *medium.kink_altitudes(scene.atmosphere)):
        cuts += intervals.sphere_crossings(segments, radius, altitude)
        # Where the path to the sun touches a kink from above, the sun's optical depth has a 3/2 power.
        cuts += intervals.planet_shadow(segments, radius + altitude, sun.direction)
    for body in scene.occluders:
        for interval in intervals.cones(segments, body.center, body.radius, sun):
            cuts += interval
    cuts += _coarse_cuts(scene.atmosphere, segments)
    edges = np.sort(np.stack(cuts, axis=1), axis=1)
    start, stop = edges[:, :-1], edges[:, 1:]
    middle = 0.5 * (start + stop)
    lit = (stop > start) & ~((middle > dark[0][:, None]) & (middle < dark[1][:, None]))
    ray = np.nonzero(lit)[0]
    return ray, start[lit], stop[lit]


def _coarse_cuts(atmosphere, segments):
    """Return cuts without which all nodes of a panel and of its halves might miss the light, and agree on nothing.

    Of a shell far deeper than its air only the low part sends light, of air far thicker than it is deep only the
    part next to the eye: altitudes, and lengths from the eye, that double.
    """
    thinnest = min(atmosphere.rayleigh_scale_height, atmosphere.mie_scale_height)
    levels = int(np.ceil(np.log2(max(atmosphere.thickness / (32.0 * thinnest), 1.0))))
    depth = (medium.extinction(atmosphere)[:2].sum(axis=0) * atmosphere.thickness).max()
    lengths = int(np.ceil(np.log2(max(depth / 50.0, 1.0))))
    cuts = [segments.length * 0.5**level for level in range(1, lengths + 1)]
    for level in range(1, levels + 1):
        altitude = atmosphere.thickness * 0.5**level
        cuts += intervals.sphere_crossings(segments, atmosphere.bottom_radius, altitude)
    return cuts


def _integrate(scene, sun, segments, accuracy, ray, start, stop):
    """Return the light (P, 3) that the panels [start, stop] send to the start of their rays' segments."""
    result = np.empty((ray.size, 3))
    step = max(1, _CHUNK // (accuracy.disc_nodes if sun.disc_at_terminator else 1))
    for begin in range(0, ray.size, step):
        part = slice(begin, begin + step)
        result[part] = _panels(scene, sun, segments, accuracy, ray[part], start[part], stop[part])
    return result


def _panels(scene, sun, segments, accuracy, ray, start, stop):
    """The same for one chunk of panels."""
    atmosphere, direction = scene.atmosphere, np.array(sun.direction)
    points, weights = medium.unit_gauss(accuracy.nodes)
    width = (stop - start)[:, None]
    s = start[:, None] + width * points
    power = segments.power_at(s, ray)
    density = medium.densities(atmosphere, medium.altitude_from_power(atmosphere.bottom_radius, power))

    before = medium.path_columns(
        atmosphere, segments.power[ray], segments.slope[ray], start, accuracy.column_nodes
    )
    columns = before[:, None] + width[..., None] * (_cumulative(accuracy.nodes) @ density)
    view = np.exp(-columns @ medium.extinction(atmosphere))

    nu = segments.direction[ray] @ direction
    beta = medium.scattering(atmosphere)
    source = density[..., :1] * (beta[0] * rayleigh_phase(nu)[:, None])[:, None]
    source += density[..., 1:2] * (beta[1] * mie_phase(nu, atmosphere.mie_g)[:, None])[:, None]

    slope = (segments.anchor[ray] @ direction)[:, None] + s * (segments.direction[ray] @ direction)[:, None]
    at = segments.points(s, ray).reshape(-1, 3)
    light = _sunlight(scene, sun, at, power.ravel(), slope.ravel(), accuracy).reshape(*s.shape, 3)
    return width * np.einsum("k,pkc->pc", weights, view * source * light)


def _sunlight(scene, sun, points, power, slope, accuracy, horizontal=False):
    """Return transmittance times visibility past planet, moons and rings (N, 3) at points that are known to be lit.

    `points` [m] are (N, 3), `power` is |p|^2 - Rb^2 [m^2], `slope` dot(p, direction to the sun) [m], both (N,);
    `horizontal` concerns finite discs alone.
    """
    shaded = bool(scene.occluders or scene.rings)
    if sun.disc_at_terminator:
        under = (scene, points) if shaded else None
        return _disc_light(scene.atmosphere, sun, power, slope, accuracy, horizontal, under)
    light = _to_top(scene.atmosphere, power, slope, accuracy.column_nodes)
    return light * visibility(points, sun, scene)[:, None] if shaded else light


def _to_top(atmosphere, power, slope, nodes):
    """Return the transmittance (N, 3) to the top of the air along paths of given `power` and `slope`."""
    bottom, top = atmosphere.bottom_radius, atmosphere.top_radius
    above = np.maximum((top - bottom) * (top + bottom) - power, 0.0)
    root = np.sqrt(slope * slope + above)
    rising = slope > 0.0
    length = np.where(rising, above / np.where(rising, root + slope, 1.0), root - slope)
    return np.exp(
        -medium.path_columns(atmosphere, power, slope, length, nodes) @ medium.extinction(atmosphere)
    )


def _disc_light(atmosphere, sun, power, slope, accuracy, horizontal=False, under=None):
    """Return the mean transmittance (N, 3) over a uniform solar disc, its part below the horizon dark.

    `horizontal`: times the cosine of each strip's zenith angle, the irradiance of a level plane. `under`: the scene
    whose moons and rings stand before the disc, and the points (N, 3).

    The disc is planar, its points told by their zenith angle alone: strips at the height y (-1 to 1, in
    radii) have the weight (2/pi) sqrt(1 - y^2) dy; with y = cos b that is smooth, (2/pi) sin^2 b db.
    """
    radius = np.sqrt(np.maximum(atmosphere.bottom_radius**2 + power, 0.0))
    across = np.sqrt(np.maximum((radius - slope) * (radius + slope), 0.0))
    zenith = np.arctan2(across, slope)
    horizon = np.pi / 2.0 + np.arctan2(np.sqrt(np.maximum(power, 0.0)), atmosphere.bottom_radius)
    angular_radius = np.arcsin(sun.radius / sun.distance)
    last = np.arccos(np.clip((zenith - horizon) / angular_radius, -1.0, 1.0))
    points, weights = medium.unit_gauss(accuracy.disc_nodes)
    b = last[:, None] * points
    weight = 2.0 / np.pi * last[:, None] * weights * np.sin(b) ** 2
    cosine = np.cos(zenith[:, None] - angular_radius * np.cos(b))
    strips = (radius[:, None] * cosine).ravel()
    light = _to_top(atmosphere, np.repeat(power, accuracy.disc_nodes), strips, accuracy.column_nodes)
    light = light.reshape(*b.shape, 3) * (np.maximum(cosine, 0.0)[:, :, None] if horizontal else 1.0)
    mean = np.einsum("nk,nkc->nc", weight, light)
    return mean if under is None else mean * visibility_above_limb(under[1], sun, under[0], last, light)


@functools.lru_cache(maxsize=16)
def _cumulative(nodes: int) -> np.ndarray:
    """Return A with A[k, j] = integral from 0 to node k of the Lagrange polynomial of node j on [0, 1]."""
    points, _ = medium.unit_gauss(nodes)
    legendre = np.polynomial.legendre
    x = 2.0 * points - 1.0
    basis = np.linalg.inv(legendre.legvander(x, nodes - 1))  # column j: Legendre coefficients of polynomial j
    integrals = legendre.legint(basis, lbnd=-1.0, axis=0)
    return 0.5 * legendre.legval(x, integrals).T
