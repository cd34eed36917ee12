#version 330 core

#include "adaptive_tile.glsl"

void main() { place_tile(); }
