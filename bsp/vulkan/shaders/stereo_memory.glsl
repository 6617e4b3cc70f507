// The memory of a stereo band on the device: fsw/vision/stereo/band/stereo_band.hpp, as words of four bytes.
layout(local_size_x = 64) in;

// StereoBandInput, word by word; static assertions in stereo_band_job.cpp compare these numbers with it.
const uint at_width = 1u, at_rows = 2u, at_first_row = 4u, at_continues = 5u, at_padded = 6u, at_disparities = 7u,
           at_radius = 8u, at_min_disparity = 9u, at_lead = 10u, at_small_step = 11u, at_out_of_view_cost = 12u,
           at_run_count = 14u;
const uint place_large_step = 16u, place_runs = 17u, place_left = 18u, place_right = 19u, place_left_sum = 20u,
           place_left_norm = 21u, place_right_mean = 22u, place_right_norm = 23u, place_paths = 24u,
           place_row_bytes = 25u, place_row_pixels = 26u, place_paths_given = 27u;

const uint band_rows = 32u, disparities = 128u, disparity_words = 32u;  // of a pixel
const uint max_cost = 64u, ncc_one = 16384u, max_large_step = 140u, max_lowest = 255u - max_large_step;
const uint excluded_sum = 1021u;

layout(set = 0, binding = 0) readonly buffer Input { uint words[]; } job;
// Costs of matching, of five paths, and correlations: arrays of [row][column][disparity], one behind the other.
layout(set = 0, binding = 1) buffer Scratch { uint words[]; } band;
layout(set = 0, binding = 2) buffer Output { uint words[]; } result;
// What this submission does: its first row, or the row whose paths from above it makes.
layout(push_constant) uniform Part { uint row; } part;

uint byte_of(uint first_word, uint i) {
  return (job.words[first_word + (i >> 2)] >> (8u * (i & 3u))) & 255u;
}
float number_of(uint i) {
  return uintBitsToFloat(job.words[i]);
}
uint pixel_of(uint y, uint x) {
  return y * job.words[place_row_pixels] + x;
}
/// Words of an array of single bytes, of which there are a cost and five paths.
uint layer_words() {
  return band_rows * job.words[place_row_pixels] * disparity_words;
}
uint correlations_begin() {
  return 6u * layer_words();
}

/// The run of column x: x and y are its first disparity and the one behind its last.
uvec2 run_at(uint x) {
  const uint runs = job.words[place_runs];
  for (uint i = 0u; i < job.words[at_run_count]; ++i) {
    if (x < job.words[runs + 4u * i + 1u]) {
      const uint first = job.words[runs + 4u * i + 2u];
      return uvec2(first, first + job.words[runs + 4u * i + 3u]);
    }
  }
  return uvec2(0u);
}
