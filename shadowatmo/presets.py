"""Atmospheres with the sources of their values."""

from dataclasses import replace

from shadowatmo.parameters import Atmosphere, TentLayer

# Radii and shell: Bruneton and Neyret 2008, section 4. Rayleigh at 680, 550, 440 nm and its scale height, aerosols and
# g: the same, after Riley et al. 2004, with the single-scattering albedo of 0.9. Ozone: tent of Bruneton 2017 with the
# cross sections of Serdyuchenko et al. 2014 at about 300 Dobson units. Mean ground albedo: Bruneton and Neyret 2008.
EARTH = Atmosphere(
    bottom_radius=6.36e6,
    top_radius=6.42e6,
    rayleigh_scattering=(5.802e-6, 13.558e-6, 33.1e-6),
    rayleigh_scale_height=8000.0,
    mie_scattering=(3.996e-6, 3.996e-6, 3.996e-6),
    mie_extinction=(4.44e-6, 4.44e-6, 4.44e-6),
    mie_scale_height=1200.0,
    mie_g=0.8,
    ozone=TentLayer(center=25e3, half_width=15e3, extinction=(0.65e-6, 1.881e-6, 0.085e-6)),
    ground_albedo=(0.1, 0.1, 0.1),
)

# Mean radius and scale height: Williams, Mars Fact Sheet (NASA). The carbon dioxide's Rayleigh scattering at 6 mbar is
# about 1/90 of the Earth's air's (Collienne et al. 2013). Dust: visible optical depth near 0.22, well mixed with the
# gas, strongly forward, and absorbing in the blue (Tomasko et al. 1999; Wolff et al. 2009).
MARS = Atmosphere(
    bottom_radius=3.3895e6,
    top_radius=3.4895e6,
    rayleigh_scattering=(6.5e-8, 1.5e-7, 3.6e-7),
    rayleigh_scale_height=11.1e3,
    mie_scattering=(1.9e-5, 1.75e-5, 1.55e-5),
    mie_extinction=(2.0e-5, 1.95e-5, 2.05e-5),
    mie_scale_height=11.0e3,
    mie_g=0.7,
    ground_albedo=(0.35, 0.2, 0.1),
)


def _scaled(atmosphere: Atmosphere, factor: float) -> Atmosphere:
    """Return air of `factor` times the density, ozone included."""

    def times(values):
        return tuple(factor * v for v in values)

    return replace(
        atmosphere,
        rayleigh_scattering=times(atmosphere.rayleigh_scattering),
        mie_scattering=times(atmosphere.mie_scattering),
        mie_extinction=times(atmosphere.mie_extinction),
        ozone=replace(atmosphere.ozone, extinction=times(atmosphere.ozone.extinction)),
    )


# The Earth's air at a fifth and at five times its density: Elek 2009, figure 6.
THIN_EARTH = _scaled(EARTH, 0.2)
DENSE_EARTH = _scaled(EARTH, 5.0)

# Like Titan: radius 2575 km, a nitrogen scale height of about 20 km and 4.4 times the Earth's density at the ground
# (Fulchignoni et al. 2005), under an orange haze that absorbs blue, of scale height near 65 km (Tomasko et al. 2008,
# rounded; visible optical depth about 1.5 here against 3 to 5 on the real moon).
TITAN = Atmosphere(
    bottom_radius=2.575e6,
    top_radius=2.975e6,
    rayleigh_scattering=(1.0e-5, 2.4e-5, 5.8e-5),
    rayleigh_scale_height=2.0e4,
    mie_scattering=(2.1e-5, 1.7e-5, 0.9e-5),
    mie_extinction=(2.3e-5, 2.4e-5, 2.6e-5),
    mie_scale_height=6.5e4,
    mie_g=0.65,
    ground_albedo=(0.2, 0.12, 0.05),
)

# A planet of 10 km for games and tests: thick, strongly curved air.
TOY_PLANET = Atmosphere(
    bottom_radius=1.0e4,
    top_radius=1.2e4,
    rayleigh_scattering=(2.0e-4, 4.7e-4, 1.1e-3),
    rayleigh_scale_height=400.0,
    mie_scattering=(2.7e-4, 2.7e-4, 2.7e-4),
    mie_extinction=(3.0e-4, 3.0e-4, 3.0e-4),
    mie_scale_height=150.0,
    mie_g=0.76,
    ground_albedo=(0.15, 0.2, 0.1),
)
