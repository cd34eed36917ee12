"""Which passes a scene needs, and why."""

import logging

from shadowatmo.extremes import closed_form_holds
from shadowatmo.passes.adaptive import TILE, AdaptiveComposite
from shadowatmo.passes.atmosphere import AtmosphereComposite
from shadowatmo.passes.atmosphere_back_depth import AtmosphereBackDepth
from shadowatmo.passes.cone_depth import ConeDepth, reaching_cones
from shadowatmo.passes.eclipse import MAX_DISCS, Eclipse, dimming_rings, shading_occluders
from shadowatmo.passes.eclipse_multiple import EclipseMultiple
from shadowatmo.passes.eclipse_view import EclipseView
from shadowatmo.passes.multiple import MultipleScattering
from shadowatmo.passes.multiple_view import MultipleView
from shadowatmo.passes.planet import Planet
from shadowatmo.passes.shadow_back_depth import ShadowBackDepth
from shadowatmo.passes.shadow_front_depth import ShadowFrontDepth
from shadowatmo.passes.table3d import METHOD_TABLES, Table3D
from shadowatmo.passes.table4d import Table4D
from shadowatmo.passes.table4d_view import Table4DView
from shadowatmo.passes.table_probe import method_orders
from shadowatmo.passes.terminator import STRIPS
from shadowatmo.passes.tonemap import Tonemap
from shadowatmo.passes.transmittance import TransmittanceTable
from shadowatmo.passes.widths import DEPTH_TEXTURES, Widths
from shadowatmo.plan import Plan, Step
from shadowatmo.quality import PATH_METHODS
from shadowatmo.segments import nodes_for
from shadowatmo.transmittance import COLUMN_NODES

log = logging.getLogger("shadowatmo")
_HARD = "method={!r} draws the planet's shadow hard, method='segments' averages over the disc"


def warn_of_approximations(scene, quality) -> list[str]:
    """Log, and return, what of a scene the passes only approximate at a quality."""
    found = []
    if hard_terminator(scene, quality):
        found.append(f"disc_at_terminator: {_HARD.format(quality.method)}")
    if any(len(shading_occluders(scene, sun)) > MAX_DISCS for sun in scene.suns):
        found.append(f"occluders: beyond {MAX_DISCS} that shade the air, what overlaps before the sun counts twice")
    for message in found:
        log.warning(message)
    return found


def composite_name(quality) -> str:
    """Return the name of the pass that writes the frame's color."""
    return (AdaptiveComposite if quality.tolerance > 0.0 else AtmosphereComposite).name


def hard_terminator(scene, quality) -> bool:
    """Whether a scene asks for finite discs at the planet's limb, and a method draws the planet's shadow hard."""
    return quality.method != "segments" and any(sun.disc_at_terminator for sun in scene.suns)


def make_plan(scene, quality, blends=True) -> Plan:
    """Return the passes that `Renderer.render` runs for a scene at a quality, in order, with their reasons.

    `blends` says whether the context can blend by two outputs of a shader.
    """
    textured, shape = quality.depth == "textures", quality.shadow
    steps, left_out = [], []

    def add(wanted, render_pass, reason, otherwise, inputs=None):
        why, reads = reason if wanted else otherwise, inputs or render_pass.inputs
        (steps if wanted else left_out).append(Step(render_pass.name, why, reads, render_pass.outputs))

    why = "the method march steps through it" if quality.method == "march" else "transmittance='table'"
    tabled = f"columns come from a table ({why}), made once"
    curved = "the closed form of columns does not hold in this air: quadrature in its place"
    closed = closed_form_holds(scene.atmosphere)
    add(quality.column_table, TransmittanceTable, tabled, "columns have a closed form" if closed else curved)
    every = quality.orders == "all"
    uses = [
        *([f"{quality.method} adds what is scattered more than once"] if quality.method in PATH_METHODS else []),
        *(["the surface reflects skylight"] if scene.surface is not None else []),
    ]
    unused = "nothing needs it" if every else "single scattering alone was asked for (orders=1)"
    add(every and uses, MultipleScattering, f"{' and '.join(uses)}; made once for the air", unused)
    if quality.method in METHOD_TABLES:
        size, summed = METHOD_TABLES[quality.method][0], method_orders(quality)
        axes = f"{size.heights} x {size.views} x {size.suns} heights, views and suns"
        add(True, Table3D, f"inscatter over {axes}, orders 1 to {summed}; made once for the air", "")
    if quality.method == "table4d":
        summed = method_orders(quality)
        add(True, Table4D, f"inscatter over r, mu, mu_s and nu, orders 1 to {summed}; made once for the air", "")
    moons = {sun: len(shading_occluders(scene, sun)) for sun in scene.suns}
    touched = f"the penumbrae of {max(moons.values())} occluders reach the air"
    untouched = "no occluder's penumbra reaches the air" if scene.occluders else "the scene has no occluders"
    rings = max(len(dimming_rings(scene, sun)) for sun in scene.suns)
    if rings:
        touched = f"{touched if any(moons.values()) else untouched}; the shadows of {rings} rings do"
    add(any(moons.values()) or rings, Eclipse, touched, untouched)
    shaded = any(moons.values()) and every and uses
    why = "what the moons leave of multiple scattering, about the axes of their shadows; made once for their places"
    add(shaded, EclipseMultiple, why, untouched if not any(moons.values()) else unused)
    solved = "the shadow's distances are solved per pixel (depth='analytic')"
    add(textured, ShadowBackDepth, f"the far side of the planet's shadow ({shape}) ends the dark part of a ray", solved)
    add(textured, ShadowFrontDepth, f"the near side of the planet's shadow ({shape}) begins the dark part", solved)
    if scene.surface is not None:
        reason = "the scene has a surface, to be drawn and lit"
    else:
        reason = "the ground ends the path of a ray; without a surface it stays black"
    add(textured or scene.surface is not None, Planet, reason, "the ground's distance is solved per pixel; it is black")
    add(textured, AtmosphereBackDepth, "the top of the air ends the path of a ray", solved.replace("shadow", "air"))
    depths = DEPTH_TEXTURES if textured else ()
    planet = ("planet_depth",) if any(step.name == "planet" for step in steps) else ()
    suns = f"{len(scene.suns)} suns, once for each" if len(scene.suns) > 1 else "one sun"
    discs = sum(sun.disc_at_terminator for sun in scene.suns)
    night = ", dark where the limb hides a whole disc" if discs and quality.method == "segments" else ""
    adaptive = quality.tolerance > 0.0
    cutting = (*depths, *planet)
    tiles = f"tiles of {TILE} x {TILE} pixels cut rays by themselves (tolerance={quality.tolerance:g})"
    add(not adaptive, Widths, f"cuts rays into lit and shadowed widths{night} ({suns})", tiles, cutting)
    if quality.method == "table4d":
        add(True, Table4DView, f"the table at the camera's height and under its sun, inside the air ({suns})", "")
    gathered = every and quality.method in PATH_METHODS
    why = "gathers what the moons leave of multiple scattering for the camera in coarse cells"
    add(gathered and shaded, EclipseView, why, untouched if not any(moons.values()) else unused)
    reads = (*MultipleView.inputs, *(EclipseView.outputs if gathered and shaded else ()))
    why = f"gathers multiple scattering for the camera in coarse cells ({suns})"
    add(gathered, MultipleView, why, unused, reads)
    background = ("planet_color",) if planet else ()
    nodes = nodes_for(scene.atmosphere, quality.nodes)
    columns = f"closed form with {quality.terms} terms" if closed else f"quadrature by {COLUMN_NODES} nodes"
    columns = "table" if quality.transmittance == "table" else columns
    jointly = ", less what moons hide of each" if any(n and sun.disc_at_terminator for sun, n in moons.items()) else ""
    strips = f", sunlight by {STRIPS[quality.terms]} strips of the disc above the limb{jointly}" if discs else ""
    how = {
        "segments": f"single scattering by {nodes} nodes a lit piece, columns from the {columns}{strips}",
        "march": f"single scattering by {quality.steps} uniform steps a path, in the shadow or out of it step by step",
        "table3d": "two lookups a lit piece, single scattering without azimuth",
        "table3d-multiple": "two lookups a lit piece, all orders without azimuth, under the ad-hoc phase",
        "table4d": "two lookups a path, two more where the planet's shadow cuts it",
        "widths": "brightness by widths, the published formula",
    }[quality.method]
    inputs = (*background, *(MultipleView.outputs if gathered else ()))
    if adaptive:
        smooth = f"at the corners of tiles, interpolated where second differences are below {quality.tolerance:g}"
        where = "in the window of the frame that may show air"
        if (otherwise := why_not_in_place(scene, blends)) is None:
            where += ", blended into the planet's color in place"
        else:
            left_out.append(Step("in_place", otherwise))
        add(True, AdaptiveComposite, f"{how}, {smooth}, {where} ({suns})", "", (*cutting, *inputs))
    add(not adaptive, AtmosphereComposite, f"{how} ({suns})", tiles, (*AtmosphereComposite.inputs, *inputs))
    if hard_terminator(scene, quality):
        left_out.append(Step("disc_at_terminator", _HARD.format(quality.method)))
    if any(moons.values()):
        cones = f"drawn when asked for, the table does the shading: {cones_in_words(scene)}"
        left_out.append(Step(ConeDepth.name, cones))
    left_out.append(Step(Tonemap.name, "runs when a picture is asked for; frames are scene-linear"))
    return Plan(tuple(steps), tuple(left_out), quality.budget)


def why_not_in_place(scene, blends) -> str | None:
    """Return why `render` does not blend the air into the picture of what stands behind it; None: it does."""
    if not blends:
        return "this context cannot blend by two outputs of a shader: the background is read, and the window written"
    if scene.surface is None:
        return "nothing stands behind the air; compose() blends where its target has the host's own color"
    return None


def cones_in_words(scene) -> str:
    """Return which occluders have which cones in the air, in the light of each sun."""
    found = []
    for number, sun in enumerate(scene.suns):
        for moon in shading_occluders(scene, sun):
            cones = ", ".join("penumbra" if c == "outer" else c for c in reaching_cones(scene.atmosphere, sun, moon))
            found.append(f"{cones} of occluder {scene.occluders.index(moon)} in the light of sun {number}")
    return "; ".join(found)
