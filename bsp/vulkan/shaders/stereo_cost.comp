#version 450
// Correlation and matching cost of four disparities of a pixel. It has the bytes of correlate() in ncc_cost.cpp: sums of
// products are whole numbers, and what is left of floating point is three products and a difference, each rounded to
// nearest. Roots and divisions are the processor's.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_spirv_intrinsics : require
#include "stereo_memory.glsl"
#ifdef ASK_FOR_ROUNDING
// RoundingModeRTE for 32 bits.
spirv_execution_mode(extensions = ["SPV_KHR_float_controls"], capabilities = [4467], 4462, 32);
#endif

void main() {
  const uint i = gl_GlobalInvocationID.x, y = part.row + gl_WorkGroupID.y;
  const uint width = job.words[at_width], x = i / disparity_words, d0 = i % disparity_words * 4u;
  if (x >= width || y >= job.words[at_rows]) return;
  const uvec2 run = run_at(x);
  if (d0 + 4u <= run.x || d0 >= run.y) return;
  const int radius = int(job.words[at_radius]), last = int(width) - 1;
  const uint row_bytes = job.words[place_row_bytes];
  // Column of the right image at the first of the four disparities.
  const int there = int(x) - int(job.words[at_min_disparity]) - int(d0);
  const int held = int(job.words[3]) - 1;
  int sum[4] = int[4](0, 0, 0, 0);
  for (int v = -radius; v <= radius; ++v) {
    const uint row = uint(clamp(int(job.words[at_first_row]) + int(y) + v, 0, held)) * row_bytes;
    for (int u = -radius; u <= radius; ++u) {
      const int left = int(byte_of(job.words[place_left], row + uint(clamp(int(x) + u, 0, last)))) - 128;
      for (int k = 0; k < 4; ++k) {
        sum[k] += left * (int(byte_of(job.words[place_right], row + uint(clamp(there - k + u, 0, last)))) - 128);
      }
    }
  }
  const uint pixel = pixel_of(y, x);
  const float left_sum = number_of(job.words[place_left_sum] + pixel);
  const float left_norm = number_of(job.words[place_left_norm] + pixel);
  precise const float scale = left_norm * float(ncc_one);
  const uint discount = max_cost - job.words[at_out_of_view_cost];
  uint costs = 0u;
  int ncc[4];
  for (int k = 0; k < 4; ++k) {
    const bool inside = there - k >= 0 && there - k <= last;
    const uint at = pixel_of(y, uint(clamp(there - k, 0, last)));
    const float right_mean = number_of(job.words[place_right_mean] + at);
    const float right_norm = inside ? number_of(job.words[place_right_norm] + at) : 0.0;
    precise const float mean_product = left_sum * right_mean;
    precise const float covariance = float(sum[k]) - mean_product;
    precise const float norm = scale * right_norm;
    precise const float value = covariance * norm;
    ncc[k] = int(value);
    const uint cost = (ncc_one + 128u - uint(max(ncc[k], 0))) >> 8;
    const uint seen = right_norm > 0.0 ? cost : cost - discount;
    costs |= (scale > 0.0 ? seen & 255u : 0u) << (8u * uint(k));
  }
  const uint word = pixel * disparity_words + d0 / 4u;
  band.words[word] = costs;
  band.words[correlations_begin() + 2u * word] = (uint(ncc[0]) & 0xffffu) | uint(ncc[1]) << 16;
  band.words[correlations_begin() + 2u * word + 1u] = (uint(ncc[2]) & 0xffffu) | uint(ncc[3]) << 16;
}
