#version 450
// The paths from left and from right: a workgroup does one row in one direction twice, 32 lanes each.
#extension GL_GOOGLE_include_directive : require
#include "stereo_memory.glsl"
#include "stereo_step.glsl"

void main() {
  const uint lane = gl_LocalInvocationID.x % path_lanes, d0 = 4u * lane;
  const uint y = part.row + 2u * gl_WorkGroupID.x + gl_LocalInvocationID.x / path_lanes;
  const bool from_right = gl_WorkGroupID.y == 1u;
  const uint width = job.words[at_width], layer = (from_right ? 5u : 1u) * layer_words();
  // Lanes without a row take part in the barriers.
  const bool there = y < job.words[at_rows];
  const uint row = there ? y : 0u;
  uvec4 behind = beginning(d0);
  publish(0u, behind);
  barrier();
  for (uint s = 0u; s < width; ++s) {
    const uint x = from_right ? width - 1u - s : s;
    const uint before = s == 0u ? x : from_right ? x + 1u : x - 1u;
    const uint word = pixel_of(row, x) * disparity_words + lane;
    behind = advanced(s & 1u, unpacked(band.words[word]), behind, contrast_of(int(row), x, int(row), before),
                      run_at(x), d0);
    if (there) band.words[layer + word] = packed(behind);
    publish((s & 1u) ^ 1u, behind);
    barrier();
  }
}
