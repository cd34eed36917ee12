#version 330 core
// Pass 1: where the ray leaves the planet's shadow.

#include "shadow_depth.glsl"

void main() { write_shadow_depth(true); }
