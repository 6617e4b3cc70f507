#version 450
// Draws image a, turned and scaled, at every fourth pixel: one invocation does four samples of a row. It has the bytes
// of draw() in wide_search.cpp.
#extension GL_GOOGLE_include_directive : require
#include "wide_memory.glsl"

uint pixel(uint stride, int x, int y) {
  const uint at = uint(y) * stride + uint(x);
  return (job.words[at_a + at / 4u] >> (8u * (at % 4u))) & 255u;
}

uint sample_at(int x, int y) {
  const uint width = job.words[at_width], height = job.words[at_height];
  if (uint(x) >= (width - 1u) << 16 || uint(y) >= (height - 1u) << 16) return 0u;
  const uint stride = (width + 3u) / 4u * 4u;
  const int px = x >> 16, py = y >> 16, fx = (x >> 8) & 255, fy = (y >> 8) & 255;
  const int p = int(pixel(stride, px, py)), q = int(pixel(stride, px + 1, py));
  const int r = int(pixel(stride, px, py + 1)), s = int(pixel(stride, px + 1, py + 1));
  if (p == 0 || q == 0 || r == 0 || s == 0) return 0u;
  const int upper = (p << 8) + fx * (q - p), lower = (r << 8) + fx * (s - r);
  return uint(((upper << 8) + fy * (lower - upper) + 32768) >> 16);
}

void main() {
  const uint i = gl_GlobalInvocationID.x, pose = part.first_pose + gl_WorkGroupID.y;
  if (i >= canvas_side * canvas_words || pose >= job.words[at_pose_count]) return;
  const int y = int(i / canvas_words), dx = of_pose(pose, step_x), dy = of_pose(pose, step_y);
  const int row_x = of_pose(pose, start_x) - dy * y, row_y = of_pose(pose, start_y) + dx * y;
  uint four = 0u;
  for (uint k = 0u; k < 4u; ++k) {
    const int x = int(i % canvas_words * 4u + k);
    if (y >= of_pose(pose, rows) || x >= of_pose(pose, columns)) continue;
    four |= sample_at(row_x + dx * x, row_y + dy * x) << (8u * k);
  }
  canvases.words[pose * canvas_side * canvas_words + i] = four;
}
