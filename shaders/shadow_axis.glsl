// The axis of the planet's shadow, which also says where the sun is.

#include "camera.glsl"

uniform Axis u_shadow_axis;
