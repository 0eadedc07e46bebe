// SPDX-License-Identifier: Apache-2.0
// The point cloud: each vertex looks its pixel up in the depth image and unprojects it. Nothing is done per point on the CPU.

export const kPointVertexShader = /* glsl */ `
precision highp float;
precision highp int;
precision highp usampler2D;

uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform usampler2D depth_image;  // counts; 0: not measured
uniform sampler2D palette;
uniform float depth_unit_mm;
uniform vec4 lens;               // fx, fy, cx, cy; the centre of the first pixel is (0, 0)
uniform bool is_orthographic;
uniform bool is_distorted;
uniform float distortion[8];     // OpenCV's k1, k2, p1, p2, k3, k4, k5, k6
uniform vec2 range_mm;           // near and far end of the palette
uniform int stride;              // every so many-th column and row is drawn
uniform bool is_cut;             // points beyond both ends of the palette are left out
uniform float focal_px;          // of the drawing: its height / (2 tan(field of view / 2))

flat out vec3 colour;

vec2 distorted(vec2 p) {
  float r2 = dot(p, p);
  float radial = (1.0 + r2 * (distortion[0] + r2 * (distortion[1] + r2 * distortion[4]))) /
                 (1.0 + r2 * (distortion[5] + r2 * (distortion[6] + r2 * distortion[7])));
  vec2 tangential = vec2(2.0 * distortion[2] * p.x * p.y + distortion[3] * (r2 + 2.0 * p.x * p.x),
                         distortion[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * distortion[3] * p.x * p.y);
  return p * radial + tangential;
}

// The inverse of 'distorted', by fixed-point iteration: lenses bend little.
vec2 undistorted(vec2 target) {
  vec2 p = target;
  for (int i = 0; i < 8; ++i) p += target - distorted(p);
  return p;
}

vec3 unproject(ivec2 pixel, float depth_mm) {
  vec2 plane = (vec2(pixel) - lens.zw) / lens.xy;
  if (is_orthographic) return vec3(plane, depth_mm);
  if (is_distorted) plane = undistorted(plane);
  return vec3(plane * depth_mm, depth_mm);
}

// How much of the light that comes from the sensor the surface takes: from the step to the next pixel on either side.
float lit(ivec2 pixel, ivec2 size, vec3 point) {
  ivec2 next = min(pixel + 1, size - 1);
  float right = float(texelFetch(depth_image, ivec2(next.x, pixel.y), 0).r) * depth_unit_mm;
  float below = float(texelFetch(depth_image, ivec2(pixel.x, next.y), 0).r) * depth_unit_mm;
  if (right == 0.0 || below == 0.0) return 0.7;
  float pitch = is_orthographic ? 1.0 / abs(lens.x) : point.z / abs(lens.x);
  vec2 slope = vec2(right - point.z, below - point.z) / pitch;
  return 0.45 + 0.55 * inversesqrt(1.0 + 0.35 * dot(slope, slope));
}

void main() {
  ivec2 size = textureSize(depth_image, 0);
  int columns = (size.x + stride - 1) / stride;
  ivec2 pixel = stride * ivec2(gl_VertexID % columns, gl_VertexID / columns);
  uint count = texelFetch(depth_image, pixel, 0).r;
  float depth_mm = float(count) * depth_unit_mm;
  if (count == 0u || (is_cut && (depth_mm < range_mm.x || depth_mm > range_mm.y))) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // outside of what is seen
    gl_PointSize = 1.0;
    return;
  }
  vec3 point = unproject(pixel, depth_mm);
  vec4 seen = modelViewMatrix * vec4(point, 1.0);
  gl_Position = projectionMatrix * seen;
  float pitch_mm = is_orthographic ? 1.0 / abs(lens.x) : point.z / abs(lens.x);
  gl_PointSize = clamp(1.25 * float(stride) * focal_px * pitch_mm / max(-seen.z, 1.0), 1.0, 16.0);
  float shade = (point.z - range_mm.x) / (range_mm.y - range_mm.x);
  colour = texture(palette, vec2(clamp(shade, 0.0, 1.0) * 255.0 / 256.0 + 0.5 / 256.0, 0.5)).rgb * lit(pixel, size, point);
}
`;

export const kPointFragmentShader = /* glsl */ `
precision highp float;
flat in vec3 colour;
out vec4 pixel_colour;
void main() { pixel_colour = vec4(colour, 1.0); }
`;
