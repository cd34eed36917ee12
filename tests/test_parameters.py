"""Physical and scene parameters: what is accepted, and the message where it is not."""

import dataclasses
import math

import pytest

import shadowatmo as sa
from shadowatmo.quality import as_quality

EARTH = dataclasses.asdict(sa.EARTH)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"bottom_radius": 0.0}, "bottom_radius"),
        ({"bottom_radius": True}, "bottom_radius"),
        ({"top_radius": 6.36e6}, "top_radius"),
        ({"top_radius": 6e6}, "top_radius"),
        ({"top_radius": math.inf}, "top_radius"),
        ({"rayleigh_scattering": (1e-6, -1e-6, 1e-6)}, "rayleigh_scattering"),
        ({"rayleigh_scattering": (1e-6, 1e-6)}, "rayleigh_scattering"),
        ({"rayleigh_scattering": 1e-6}, "rayleigh_scattering"),
        ({"rayleigh_scale_height": 0.0}, "rayleigh_scale_height"),
        ({"mie_scattering": (1.0, 1.0, 1.0)}, "mie_scattering"),
        ({"mie_extinction": (math.nan,) * 3}, "mie_extinction"),
        ({"mie_scale_height": "1200"}, "mie_scale_height"),
        ({"mie_g": 1.0}, "mie_g"),
        ({"mie_g": -1.0}, "mie_g"),
        ({"ground_albedo": (0.1, 0.1, 1.1)}, "ground_albedo"),
        ({"ozone": (25e3, 15e3)}, "ozone"),
    ],
)
def test_atmosphere_rejects(changes, name):
    with pytest.raises(sa.ParameterError) as caught:
        dataclasses.replace(sa.EARTH, **changes)
    error = caught.value
    assert error.name == name and str(error.allowed) in str(error) and name in str(error)
    assert isinstance(error, ValueError)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: sa.TentLayer(0.0, 1.0, (0, 0, 0)), "center"),
        (lambda: sa.TentLayer(1.0, -1.0, (0, 0, 0)), "half_width"),
        (lambda: sa.TentLayer(1.0, 1.0, (0, -1, 0)), "extinction"),
        (lambda: sa.Sun(direction=(0, 0, 0)), "direction"),
        (lambda: sa.Sun(direction=(0, 0, 1), radius=2e11), "radius"),
        (lambda: sa.Sun(direction=(0, 0, 1), limb_darkening=1.5), "limb_darkening"),
        (lambda: sa.Sun(direction=(0, 0, 1), irradiance=(1, 1, -1)), "irradiance"),
        (lambda: sa.Sun(direction=(0, 0, 1), disc_at_terminator=1), "disc_at_terminator"),
        (lambda: sa.Occluder(center=(0, 0, math.inf), radius=1.0), "center"),
        (lambda: sa.Occluder(center=(0, 0, 0), radius=0.0), "radius"),
        (lambda: sa.Scene(atmosphere="earth"), "atmosphere"),
        (lambda: sa.Scene(suns=()), "suns"),
        (lambda: sa.Scene(suns=(1,)), "suns"),
        (lambda: sa.Scene(occluders=5), "occluders"),
        (lambda: sa.Scene(surface="earth"), "surface"),
        (lambda: sa.Surface(color="nowhere.png"), "color"),
        (lambda: sa.Surface(relief_scale=-1), "relief_scale"),
        (lambda: sa.Quality(method="stepping"), "method"),
        (lambda: sa.Quality(nodes=1), "nodes"),
        (lambda: sa.Quality(nodes=8.0), "nodes"),
        (lambda: sa.Quality(depth="both"), "depth"),
        (lambda: sa.Quality(depth_bits=16), "depth_bits"),
        (lambda: as_quality("best"), "quality"),
        (lambda: as_quality(3), "quality"),
    ],
)
def test_others_reject(make, name):
    with pytest.raises(sa.ParameterError) as caught:
        make()
    assert caught.value.name == name


def test_a_sole_sun_and_moon_are_accepted():
    scene = sa.Scene(suns=sa.Sun(direction=(0, 0, 2)), occluders=sa.Occluder((0, 0, 3.8e8), 1.7e6))
    assert scene.suns[0].direction == (0.0, 0.0, 1.0) and len(scene.occluders) == 1
    assert scene.with_sun_direction((1, 0, 0)).suns[0].direction == (1.0, 0.0, 0.0)


def test_parameters_are_frozen():
    with pytest.raises(dataclasses.FrozenInstanceError):
        sa.EARTH.mie_g = 0.5


def test_names_of_qualities():
    assert as_quality("accurate").nodes > as_quality("balanced").nodes > as_quality("fast").nodes
    assert as_quality(sa.Quality(nodes=5)).nodes == 5


@pytest.mark.parametrize("preset", [sa.EARTH, sa.MARS, sa.THIN_EARTH, sa.DENSE_EARTH, sa.TITAN, sa.TOY_PLANET])
def test_presets_survive_their_own_checks(preset):
    assert sa.Atmosphere(**{f.name: getattr(preset, f.name) for f in dataclasses.fields(preset)}) == preset
