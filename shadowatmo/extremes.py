"""What an air asks of the methods beyond the usual: thick air, shells far deeper than their air, strong curvature.

An ordinary planet pays nothing for the others: each answer here is worked out once on the CPU and becomes a feature of
the shaders, or does not.
"""

import math

THICK = 90.0  # optical depth along the horizon above which a path is cut where nothing more can be seen
RESOLVED = 25.0  # the same, above which a lit piece takes half as many nodes again
CLOSED_CURVATURE = 20.0  # ground radius over scale height below which the closed form of columns is wrong by a percent
CLOSED_DEPTH = 4.0  # scale height over thickness above which the column beyond the top swamps the one below
CURVED_OZONE = 40.0  # ground radius over the tent's half width below which its sides bend by more than 1e-3 over r^2
DENSE_TOP = 0.3  # optical depth of a level ray just below the top above which light decays as exp(-sqrt(depth)) there
OPAQUE_OZONE = 5.0  # optical depth of an absorbing layer along its own horizon above which its upper end is a kink
EMPTY = 26.0  # scale heights, beyond those that make a layer thin, above which even at night it counts no more
FAR_ABOVE = 8.0  # scale heights of the other layer that the nodes of the dominant one may reach


def exponential_layers(atmosphere) -> list[tuple[float, float, float]]:
    """Return (scale height [m], largest extinction [1/m], vertical optical depth) of the layers that are there."""
    layers = [
        (atmosphere.rayleigh_scale_height, max(atmosphere.rayleigh_scattering)),
        (atmosphere.mie_scale_height, max(atmosphere.mie_extinction)),
    ]
    return [
        (height, beta, -height * beta * math.expm1(-atmosphere.thickness / height))
        for height, beta in layers
        if beta > 0.0
    ]


def dominant_layer(atmosphere) -> tuple[float, float]:
    """Return scale height [m] and extinction [1/m] that shape a lit piece: of the layer of largest optical depth.

    The scale height is at most the air's thickness, and where the other layer counts a few of that one's.
    """
    layers = sorted(exponential_layers(atmosphere), key=lambda layer: -layer[2])
    if not layers:
        return min(atmosphere.rayleigh_scale_height, atmosphere.thickness), 0.0
    height, beta, depth = layers[0]
    height = min(height, atmosphere.thickness)
    if len(layers) > 1 and layers[1][2] > 0.003 * depth:
        height = min(height, FAR_ABOVE * layers[1][0])
    return height, beta


def horizon_depth(atmosphere) -> float:
    """Return the optical depth of a ray that touches the ground, from there to the top, in its thickest channel."""
    reach = math.sqrt(atmosphere.thickness * (2.0 * atmosphere.bottom_radius + atmosphere.thickness))
    return sum(
        min(math.sqrt(0.5 * math.pi * height * (atmosphere.bottom_radius + height)), reach) * depth / height
        if height < atmosphere.thickness
        else reach * depth / atmosphere.thickness
        for height, _, depth in exponential_layers(atmosphere)
    )


def is_thick(atmosphere) -> bool:
    """Whether rays end in the air itself, so that their nodes belong where it can be seen."""
    return horizon_depth(atmosphere) > THICK


def has_dense_top(atmosphere) -> bool:
    """Whether thick air ends so abruptly that the light of a low sun is all in a hair beneath the top.

    The sun's column there grows with the square root of the depth, which no polynomial over the depth follows.
    """
    if not is_thick(atmosphere):
        return False
    radius, thickness = atmosphere.top_radius, atmosphere.thickness
    level = sum(
        beta * math.exp(-thickness / height) * math.sqrt(0.5 * math.pi * min(height, thickness) * radius)
        for height, beta, _ in exponential_layers(atmosphere)
    )
    return level > DENSE_TOP


def has_opaque_ozone(atmosphere) -> bool:
    """Whether a low sun lights the air above the absorbing layer alone: its upper end then cuts pieces."""
    layer = atmosphere.ozone
    if layer is None or layer.center + layer.half_width >= atmosphere.thickness:
        return False
    reach = math.sqrt(2.0 * layer.half_width * (atmosphere.bottom_radius + layer.center))
    return max(layer.extinction) * reach > OPAQUE_OZONE


def reach_altitude(atmosphere) -> float:
    """Return the altitude [m] up to which the air counts: the top, or in a deep shell where its layers have faded."""
    layers = exponential_layers(atmosphere)
    if not layers:
        return atmosphere.thickness
    reach = max(height * (EMPTY + math.log(max(beta * height, 1.0))) for height, beta, _ in layers)
    return min(reach, atmosphere.thickness)


def is_deep(atmosphere) -> bool:
    """Whether a good part of the shell is empty, so that nodes spread over all of it are wasted."""
    return reach_altitude(atmosphere) < 0.7 * atmosphere.thickness


def needs_more_nodes(atmosphere) -> bool:
    """Whether light comes from a part of a path so near that the map resolves it with fewer of its nodes.

    Measured on a planet of five times the Earth's density, on a hazy moon, and on planets of ten Earth radii and more.
    """
    height, beta = dominant_layer(atmosphere)
    return height * beta > 1.0 or horizon_depth(atmosphere) > RESOLVED


def is_small(atmosphere) -> bool:
    """Whether a ray may pass the ground nearer to the center than the air is deep: density all but has a kink there."""
    return CLOSED_CURVATURE * dominant_layer(atmosphere)[0] > atmosphere.bottom_radius


def has_curved_ozone(atmosphere) -> bool:
    """Whether the tent's sides, straight over the altitude, are not straight over r^2 - R^2."""
    return atmosphere.ozone is not None and atmosphere.bottom_radius < CURVED_OZONE * atmosphere.ozone.half_width


def closed_form_holds(atmosphere) -> bool:
    """Whether columns towards the sun have the closed form of shadowatmo.transmittance.

    It is a series in scale height over radius, for a layer without a top; the part above the top is taken off.
    """
    tallest = max((height for height, _, _ in exponential_layers(atmosphere)), default=0.0)
    return CLOSED_CURVATURE * tallest <= atmosphere.bottom_radius and tallest <= CLOSED_DEPTH * atmosphere.thickness
