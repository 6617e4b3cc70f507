#version 450
// The disparity with the lowest sum of paths, the smallest of several, whether none but its neighbours is near it, and
// the correlations about it: one invocation does a pixel. It has the bytes of find_winner() in path_steps.inc.
#extension GL_GOOGLE_include_directive : require
#include "stereo_memory.glsl"

uint sum_of(uint pixel, uint d) {
  if (d >= job.words[at_disparities]) return excluded_sum;
  const uint word = pixel * disparity_words + d / 4u, layer = layer_words();
  uint sum = 0u;
  for (uint path = 1u; path <= 5u; ++path) sum += (band.words[path * layer + word] >> (8u * (d & 3u))) & 255u;
  return sum;
}

int correlation(uint pixel, int d, uvec2 run) {
  if (d < int(run.x) || d >= int(run.y)) return 0;
  return int(band.words[correlations_begin() + pixel * 2u * disparity_words + uint(d) / 2u] << (16u - 16u * (uint(d) & 1u))) >> 16;
}

void main() {
  const uint x = gl_GlobalInvocationID.x, y = part.row + gl_WorkGroupID.y;
  if (x >= job.words[at_width] || y >= job.words[at_rows]) return;
  const uint pixel = pixel_of(y, x);
  const uvec2 run = run_at(x);
  uint cost = excluded_sum, index = run.x;
  for (uint d = run.x; d < run.y; ++d) {
    const uint sum = sum_of(pixel, d);
    if (sum < cost) {
      cost = sum;
      index = d;
    }
  }
  const uint limit = cost + job.words[at_lead];
  bool unique = true;
  for (uint d = run.x; d < run.y; ++d) unique = unique && !(d - index + 1u > 2u && sum_of(pixel, d) < limit);
  const int middle = int(index);
  const int peaks[5] = int[5](correlation(pixel, middle - 2, run), correlation(pixel, middle - 1, run),
                              correlation(pixel, middle, run), correlation(pixel, middle + 1, run),
                              correlation(pixel, middle + 2, run));
  const uint at = 4u * pixel;
  result.words[at] = cost | (unique ? 1u << 15 : 0u) | index << 16;
  result.words[at + 1u] = (uint(peaks[0]) & 0xffffu) | uint(peaks[1]) << 16;
  result.words[at + 2u] = (uint(peaks[2]) & 0xffffu) | uint(peaks[3]) << 16;
  result.words[at + 3u] = uint(peaks[4]) & 0xffffu;
}
