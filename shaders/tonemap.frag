#version 330 core
// The last pass: scene-linear radiance to display values, apart from everything physical.

uniform sampler2D u_color;
uniform float u_exposure;

out vec4 out_color;

// A saturating exponential: linear in the dark, without a hard clip in the light.
vec3 saturate(vec3 radiance) { return 1.0 - exp(-u_exposure * max(radiance, 0.0)); }

// IEC 61966-2-1, the sRGB transfer function.
vec3 encode_srgb(vec3 linear) {
  return mix(12.92 * linear, 1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, greaterThan(linear, vec3(0.0031308)));
}

// Half an 8-bit step of ordered noise (Jimenez 2014, interleaved gradient noise) keeps smooth skies free of bands.
float dither(vec2 fragment) { return fract(52.9829189 * fract(dot(fragment, vec2(0.06711056, 0.00583715)))) - 0.5; }

void main() {
  vec3 radiance = texelFetch(u_color, ivec2(gl_FragCoord.xy), 0).rgb;
  out_color = vec4(encode_srgb(saturate(radiance)) + dither(gl_FragCoord.xy) / 255.0, 1.0);
}
