// One point for each tile, as large as the tile; those of other kinds go outside the clip volume. Where points cannot be
// so large, two triangles (HAS_TRIANGLES).

uniform sampler2D u_tiles;
uniform float u_kind;
uniform ivec4 u_window;  // first tile, tiles across and up

// Writes the vertex's place, and returns which tile it belongs to.
ivec2 place_tile() {
  ivec2 count = textureSize(u_tiles, 0);
#ifdef HAS_TRIANGLES
  int number = gl_VertexID / 6;
  int vertex = gl_VertexID % 6;
  vec2 place = vec2(vertex == 1 || vertex > 3 ? 1.0 : 0.0, vertex == 2 || vertex == 3 || vertex == 5 ? 1.0 : 0.0);
#else
  int number = gl_VertexID;
  vec2 place = vec2(0.5);
  gl_PointSize = float(TILE_PIXELS);
#endif
  ivec2 tile = u_window.xy + ivec2(number % u_window.z, number / u_window.z);
  bool wanted = texelFetch(u_tiles, tile, 0).x == u_kind;
  gl_Position = wanted ? vec4(2.0 * (vec2(tile) + place) / vec2(count) - 1.0, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
  return tile;
}
