#version 330 core
// A proxy mesh: tells which pixels a volume can cover. No near or far plane cuts it: z = 0 is inside the clip volume for
// every vertex in front of the eye, and the depth is the fragment's own.

in vec3 in_position;  // m, planet-centered

uniform mat4 u_to_clip;  // x, y, eye depth from planet-centered metres

out float v_eye_depth;  // m

void main() {
  vec4 clip = u_to_clip * vec4(in_position, 1.0);
  v_eye_depth = clip.w;
  gl_Position = vec4(clip.xy, 0.0, clip.w);
}
