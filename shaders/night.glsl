// Where a ray is cut in the light of a sun with a finite disc: the planet's limb hides the whole disc in a cone that
// narrows, and some of it in one that widens. A ray through the penumbra alone is not dark anywhere; it is cut in two at
// its middle, since the dip of the light there asks for as many nodes as a shadow would.

#include "shadow.glsl"

uniform Cone u_dusk;  // where the limb hides any of the disc

// The cut of a ray: `night`, the distances [m] between which it is dark, or where these are none the middle of its dusk.
vec2 night_or_dusk(AxisRay axis, vec2 night) {
  vec2 dusk = cone_interval(axis, u_dusk, 1.0);
  return night.x < night.y || dusk.x >= dusk.y ? night : vec2(0.5 * (dusk.x + dusk.y));
}
