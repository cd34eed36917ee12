// Depth conventions: what a depth texture holds, as metres along the pixel's ray.
//
// Path length = eye-space depth x stretch (camera.glsl). Our own depth is reversed with an infinite far plane, near / z,
// in 32-bit float: its relative error is that of a float at any distance. The published one is standard 24-bit.

#include "camera.glsl"

uniform vec2 u_clip_planes;  // m: near, far of our own depth textures

const float NOTHING = 1.0e30;  // m, stands for no surface

#ifdef HAS_PUBLISHED_DEPTH
float encode_depth(float z) {
  float near = u_clip_planes.x;
  float far = u_clip_planes.y;
  return clamp(far * (z - near) / ((far - near) * max(z, near)), 0.0, 1.0);
}
float decode_depth(float depth) {
  float near = u_clip_planes.x;
  float far = u_clip_planes.y;
  return depth >= 1.0 ? NOTHING : far * near / (far - depth * (far - near));
}
#else
float encode_depth(float z) { return u_clip_planes.x / max(z, u_clip_planes.x); }
float decode_depth(float depth) { return depth <= 0.0 ? NOTHING : u_clip_planes.x / depth; }
#endif

// Distance [m] along the pixel's ray of a value in one of our own depth textures.
float own_distance(sampler2D depth, ivec2 texel, Pixel pixel) {
  float z = decode_depth(texelFetch(depth, texel, 0).x);
  return z >= NOTHING ? NOTHING : z * pixel.stretch;
}

#ifdef HAS_HOST_DEPTH
uniform sampler2D u_host_depth;
uniform vec4 u_host_convention;  // near, far, coefficient, metres per unit

// Distance [m] along the pixel's ray of the host's surface; NOTHING where there is none.
float host_distance(ivec2 place, Pixel pixel) {
  vec4 texel = texelFetch(u_host_depth, place, 0);
  float near = u_host_convention.x;
  float far = u_host_convention.y;
  float d = texel.x;
#if CONVENTION == CONVENTION_DISTANCE
  float distance = d;
#elif CONVENTION == CONVENTION_LINEAR
  float distance = d * pixel.stretch;
#elif CONVENTION == CONVENTION_STANDARD
  // 1 - d is exact where it matters; and an infinite far plane is a zero ratio.
  float ratio = near / far;
  float distance = d >= 1.0 ? NOTHING : near / ((1.0 - d) + d * ratio) * pixel.stretch;
#elif CONVENTION == CONVENTION_REVERSED
  float ratio = near / far;
  float distance = d <= 0.0 ? NOTHING : near / (ratio + d * (1.0 - ratio)) * pixel.stretch;
#elif CONVENTION == CONVENTION_LOGARITHMIC
  float c = u_host_convention.z;
  float distance = d >= 1.0 ? NOTHING : (exp2(d * log2(1.0 + c * far)) - 1.0) / c * pixel.stretch;
#elif CONVENTION == CONVENTION_POSITION
  float distance = length(texel.xyz);
#endif
  distance *= u_host_convention.w;
  // Anything that is not a distance (nan, inf, negative) means that nothing was drawn there.
  return distance >= 0.0 && distance < NOTHING ? distance : NOTHING;
}
#endif
