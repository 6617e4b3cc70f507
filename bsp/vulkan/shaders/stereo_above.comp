#version 450
// One row of the paths from above left, above and above right: a workgroup does two columns of one path, 32 lanes each.
#extension GL_GOOGLE_include_directive : require
#include "stereo_memory.glsl"
#include "stereo_step.glsl"

void main() {
  const uint lane = gl_LocalInvocationID.x % path_lanes, d0 = 4u * lane;
  const uint x = 2u * gl_WorkGroupID.x + gl_LocalInvocationID.x / path_lanes, path = gl_WorkGroupID.y;
  const uint width = job.words[at_width], y = part.row, layer = (2u + path) * layer_words();
  const bool there = x < width && y < job.words[at_rows];
  const uint column = there ? x : 0u, row = there ? y : 0u;
  const int from = int(column) + int(path) - 1;
  const bool outside = from < 0 || from >= int(width);
  uvec4 behind = beginning(d0);
  if (!outside && row > 0u) {
    behind = unpacked(band.words[layer + pixel_of(row - 1u, uint(from)) * disparity_words + lane]);
  } else if (!outside && job.words[at_continues] != 0u && d0 < job.words[at_padded]) {
    const uint given = job.words[place_paths] + (path * job.words[place_row_pixels] + uint(from)) * disparity_words;
    behind = unpacked(job.words[given + lane]);
  }
  publish(0u, behind);
  barrier();
  const uint contrast = outside ? 0u : contrast_of(int(row), column, int(row) - 1, uint(from));
  const uint word = pixel_of(row, column) * disparity_words + lane;
  const uvec4 costs = advanced(0u, unpacked(band.words[word]), behind, contrast, run_at(column), d0);
  if (!there) return;
  band.words[layer + word] = packed(costs);
  if (row + 1u < job.words[at_rows] || d0 >= job.words[at_padded]) return;
  const uint handed = job.words[place_paths_given] + (path * job.words[place_row_pixels] + column) * disparity_words;
  result.words[handed + lane] = packed(costs);
}
