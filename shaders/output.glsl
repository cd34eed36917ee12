// What the composite writes: light, and in place of a background that is read what the air leaves of it, to be blended.

#ifdef HAS_IN_PLACE
layout(location = 0, index = 0) out vec4 out_color;
layout(location = 0, index = 1) out vec4 out_passed;
#else
out vec4 out_color;  // a: how much of the background the air hides
#endif
