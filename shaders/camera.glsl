// From a pixel to the ray inside the air, with what the CPU knows of the camera in float64.
//
// A pixel's direction is forward + x right + y up (tangents of the half angles included). Dot and cross products of the
// camera's position with the three come from the CPU, so that the large position never meets a rounded direction: x and
// the tangent point keep their digits relative to their own size.

#include "shadow.glsl"

uniform vec2 u_pixel_to_screen;  // 2 / size in pixels
uniform mat3 u_axes;             // columns right, up, forward
uniform vec3 u_position_dots;    // m, position . right, up, forward
uniform float u_camera_k;        // m^2
#ifdef HAS_FAR_CAMERA
uniform mat3 u_moments;  // m, columns position x right, up, forward
#endif

struct Pixel {
  vec3 direction;  // unit
  float stretch;   // path length per eye-space depth, >= 1
  vec3 screen;     // x, y in -1..1, 1
};

Pixel make_pixel(vec2 fragment) {
  Pixel pixel;
  pixel.screen = vec3(fragment * u_pixel_to_screen - 1.0, 1.0);
  vec3 along = u_axes * pixel.screen;
  pixel.stretch = length(along);
  pixel.direction = along / pixel.stretch;
  return pixel;
}

#ifdef HAS_FAR_CAMERA
vec3 pixel_moment(Pixel pixel) { return u_moments * pixel.screen / pixel.stretch; }
#endif

Ray pixel_ray(Pixel pixel) {
  float x = dot(u_position_dots, pixel.screen) / pixel.stretch;
#ifdef HAS_FAR_CAMERA
  float impact = length(pixel_moment(pixel));
  float tangent_k = (impact - u_bottom_radius) * (impact + u_bottom_radius);
#else
  float tangent_k = u_camera_k - x * x;
#endif
  return make_ray(x, u_camera_k, tangent_k);
}

// A shadow axis through the planet's center, as the camera sees it.
struct Axis {
  vec3 direction;  // away from the sun
  vec3 off;        // m, position x direction
  float z;         // m, position . direction
};

// The base point [m]. From far away it is not the camera's position plus a distance, which cancel: the moment m = P x d
// tells the point of the ray that is the nearest to the center, d x m, to the digits of its own size.
vec3 base_point(Pixel pixel, Ray ray, vec3 position) {
#ifdef HAS_FAR_CAMERA
  return cross(pixel.direction, pixel_moment(pixel)) + ray.x * pixel.direction;
#else
  return position + ray.start * pixel.direction;
#endif
}

// Its height [m] along an axis; cosine = that of ray and axis.
float base_height(Pixel pixel, Ray ray, Axis axis, float cosine) {
#ifdef HAS_FAR_CAMERA
  return ray.x * cosine - dot(pixel_moment(pixel), cross(pixel.direction, axis.direction));
#else
  return axis.z + ray.start * cosine;
#endif
}

// Its product base x axis [m]; normal = direction x axis.
vec3 base_off(Pixel pixel, Ray ray, Axis axis, float cosine, vec3 normal) {
#ifdef HAS_FAR_CAMERA
  vec3 moment = pixel_moment(pixel);
  return moment * cosine - pixel.direction * dot(moment, axis.direction) + ray.x * normal;
#else
  return axis.off + ray.start * normal;
#endif
}

AxisRay pixel_axis_ray(Pixel pixel, Ray ray, Axis axis) {
  vec3 normal = cross(pixel.direction, axis.direction);
  AxisRay result;
  result.dz = dot(pixel.direction, axis.direction);
  vec3 off = base_off(pixel, ray, axis, result.dz, normal);
  result.z = base_height(pixel, ray, axis, result.dz);
  result.across = dot(normal, normal);
  result.drift = dot(off, normal);
  result.impact = dot(off, cross(axis.direction, normal));
  result.rim = ray.k - result.z * result.z;
  return result;
}
