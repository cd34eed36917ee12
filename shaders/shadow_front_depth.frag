#version 330 core
// Pass 2: where the ray enters the planet's shadow; the near plane where the camera is inside it.

#include "shadow_depth.glsl"

void main() { write_shadow_depth(false); }
