#version 330 core
// One point for each tile, as large as the tile; those of other kinds go outside the clip volume.

uniform sampler2D u_tiles;
uniform float u_kind;

void main() {
  ivec2 count = textureSize(u_tiles, 0);
  ivec2 tile = ivec2(gl_VertexID % count.x, gl_VertexID / count.x);
  bool wanted = texelFetch(u_tiles, tile, 0).x == u_kind;
  gl_Position = wanted ? vec4((2.0 * vec2(tile) + 1.0) / vec2(count) - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = float(TILE);
}
