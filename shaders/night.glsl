// Where a ray is cut in the light of a sun with a finite disc. Night is where the planet's limb hides the whole disc; in
// dusk, the shadow of parallel light, it hides half of it or more. A ray that meets no night is dark nowhere, but the dip
// of the light in dusk asks for as many nodes as a shadow would: it is cut in two there.

// Distances [m] at which the dark part of a ray [0, end] begins and ends, both the same where it has none; beyond the end
// for a ray without night and dusk.
vec2 night_or_dusk(vec2 night, vec2 dusk, float end) {
  if (night.x < night.y) return night;
  if (dusk.x >= dusk.y) return vec2(end);
  if (dusk.x > 0.0 && dusk.y < end) return vec2(0.5 * (dusk.x + dusk.y));
  return vec2(dusk.x > 0.0 ? dusk.x : dusk.y);
}
