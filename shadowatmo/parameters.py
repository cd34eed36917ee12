"""Physical parameters: the air, the sun, the bodies that shade it. All SI, planet-centered, per color channel.

The model is the usual clear-sky one: two exponential layers (molecules and aerosols), an optional absorbing layer of
tent shape (ozone), cut sharply at the top radius. Colors are three independent linear channels.
"""

from dataclasses import dataclass, fields

from shadowatmo.errors import ParameterError
from shadowatmo.validation import instance, number, unit_vector, vector

MAX_LENGTH = 1e15  # m; about 7000 au, far beyond any scene yet safe to square in float64


@dataclass(frozen=True)
class TentLayer:
    """An absorbing layer whose extinction rises and falls linearly with altitude (Bruneton 2017, ozone).

    Parameters
    ----------
    center : float
        Altitude of the peak [m], > 0.
    half_width : float
        Distance from the peak to where the layer ends [m], > 0.
    extinction : (3,) float
        Extinction coefficient at the peak [1/m], >= 0. The layer absorbs and does not scatter.
    """

    center: float
    half_width: float
    extinction: tuple[float, float, float]

    def __post_init__(self):
        _set(self, center=number("center", self.center, low=0, open_low=True, high=MAX_LENGTH))
        _set(self, half_width=number("half_width", self.half_width, low=0, open_low=True, high=MAX_LENGTH))
        _set(self, extinction=vector("extinction", self.extinction, low=0, high=1e3))


@dataclass(frozen=True)
class Atmosphere:
    """A spherical shell of air over a spherical ground.

    Densities fall as exp(-altitude / scale height) and are cut at `top_radius`.

    Parameters
    ----------
    bottom_radius, top_radius : float
        Radius of the ground (altitude 0) and of the top of the air [m], 0 < bottom < top.
    rayleigh_scattering : (3,) float
        Molecular scattering coefficient at altitude 0 [1/m], >= 0.
    rayleigh_scale_height : float
        Scale height of the molecules [m], > 0.
    mie_scattering, mie_extinction : (3,) float
        Aerosol scattering and extinction at altitude 0 [1/m], 0 <= scattering <= extinction in each channel.
    mie_scale_height : float
        Scale height of the aerosols [m], > 0.
    mie_g : float
        Asymmetry of the aerosol phase function (Cornette and Shanks 1992), in (-1, 1).
    ozone : TentLayer, optional
        Absorbing layer.
    ground_albedo : (3,) float
        Lambertian reflectance of the ground, in [0, 1].

    Raises
    ------
    ParameterError
        If a value is not finite or out of range; the message names the field, the value and the range.
    """

    bottom_radius: float
    top_radius: float
    rayleigh_scattering: tuple[float, float, float]
    rayleigh_scale_height: float
    mie_scattering: tuple[float, float, float]
    mie_extinction: tuple[float, float, float]
    mie_scale_height: float
    mie_g: float
    ozone: TentLayer | None = None
    ground_albedo: tuple[float, float, float] = (0.1, 0.1, 0.1)

    def __post_init__(self):
        bottom = number("bottom_radius", self.bottom_radius, low=0, open_low=True, high=MAX_LENGTH)
        _set(self, bottom_radius=bottom)
        _set(self, top_radius=number("top_radius", self.top_radius, low=bottom, open_low=True, high=MAX_LENGTH))
        for name in ("rayleigh_scattering", "mie_scattering", "mie_extinction"):
            _set(self, **{name: vector(name, getattr(self, name), low=0, high=1e3)})
        for name in ("rayleigh_scale_height", "mie_scale_height"):
            _set(self, **{name: number(name, getattr(self, name), low=0, open_low=True, high=MAX_LENGTH)})
        _set(self, mie_g=number("mie_g", self.mie_g, low=-1, high=1, open_low=True, open_high=True))
        _set(self, ground_albedo=vector("ground_albedo", self.ground_albedo, low=0, high=1))
        if self.ozone is not None:
            instance("ozone", self.ozone, TentLayer, "None or a TentLayer")
            lowest = self.ozone.center - self.ozone.half_width
            if lowest <= -bottom:
                raise ParameterError("ozone", self.ozone, f"a layer that begins above the center, at {-bottom:g} m")
        if any(s > e * (1 + 1e-12) for s, e in zip(self.mie_scattering, self.mie_extinction, strict=True)):
            raise ParameterError(
                "mie_scattering", self.mie_scattering, f"at most mie_extinction = {self.mie_extinction} in each channel"
            )

    @property
    def thickness(self) -> float:
        """Altitude of the top of the air [m]."""
        return self.top_radius - self.bottom_radius


@dataclass(frozen=True)
class Sun:
    """A spherical light source, far away.

    Parameters
    ----------
    direction : (3,) float
        From the planet's center to the sun; normalized here. All light arrives from this direction (parallel).
    distance, radius : float
        Distance of the sun's center from the planet's center, and the sun's radius [m], 0 < radius < distance.
        They serve the shadow cones, the visible fraction and the disc.
    irradiance : (3,) float
        Irradiance on a plane that faces the sun at the top of the air, >= 0. With (1, 1, 1) radiances are per unit
        solar irradiance [1/sr].
    limb_darkening : float
        u of I(r) = 1 - u (1 - sqrt(1 - r^2)), r = normalized radius on the disc; in [0, 1].
    disc_at_terminator : bool
        True: the planet's limb hides a finite, uniform disc, in single scattering by the method "segments" and on the
        ground; light scattered more than once keeps a point sun. False: it hides a point (the hard planet shadow).
        A moon hides its part of what stands above the limb, limb-darkened; a ring dims it as it does the whole disc.
    """

    direction: tuple[float, float, float]
    distance: float = 1.496e11
    radius: float = 6.957e8
    irradiance: tuple[float, float, float] = (1.0, 1.0, 1.0)
    limb_darkening: float = 0.6
    disc_at_terminator: bool = False

    def __post_init__(self):
        _set(self, direction=unit_vector("direction", self.direction))
        _set(self, distance=number("distance", self.distance, low=0, open_low=True, high=1e20))
        _set(self, radius=number("radius", self.radius, low=0, high=self.distance, open_low=True, open_high=True))
        _set(self, irradiance=vector("irradiance", self.irradiance, low=0, high=1e12))
        _set(self, limb_darkening=number("limb_darkening", self.limb_darkening, low=0, high=1))
        instance("disc_at_terminator", self.disc_at_terminator, bool, "True or False")


@dataclass(frozen=True)
class Occluder:
    """An opaque sphere that can stand between the sun and the air, a moon for instance.

    Parameters
    ----------
    center : (3,) float
        Position of its center, planet-centered [m].
    radius : float
        Its radius [m], > 0.
    """

    center: tuple[float, float, float]
    radius: float

    def __post_init__(self):
        _set(self, center=vector("center", self.center, low=-1e20, high=1e20))
        _set(self, radius=number("radius", self.radius, low=0, open_low=True, high=MAX_LENGTH))


def _set(instance_, **values):
    """Store validated values in a frozen dataclass during its construction."""
    known = {f.name for f in fields(instance_)}
    for name, value in values.items():
        assert name in known
        object.__setattr__(instance_, name, value)
