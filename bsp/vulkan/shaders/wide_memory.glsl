// The memory of a wide search on the device: what fsw/vision/overlap/wide_search.hpp has, as words of four bytes, because
// storage of single bytes is optional in Vulkan.
layout(local_size_x = 64) in;

// WideInput, word by word; static assertions in wide_search_job.cpp compare these numbers with it.
const uint max_side = 160u, plane_rows = 40u, plane_words = 16u;
const uint at_width = 0u, at_height = 1u, at_pose_count = 2u;
const uint at_a = 4u, at_b = at_a + max_side * max_side / 4u;
const uint at_poses = at_b + 16u * plane_rows * plane_words;
const uint pose_words = 12u;
const uint start_x = 0u, start_y = 1u, step_x = 2u, step_y = 3u, columns = 4u, rows = 5u, left = 6u, top = 7u,
           shifts_x = 8u, shifts_y = 9u, min_count = 10u;

const uint max_shifts = 192u, shift_bits = 8u, unrelated = 36u;
const uint canvas_side = 85u, canvas_words = 22u;  // of a row

layout(set = 0, binding = 0) readonly buffer Input { uint words[]; } job;
layout(set = 0, binding = 1) buffer Canvases { uint words[]; } canvases;
layout(set = 0, binding = 2) buffer Output { uint best[]; } result;
// The first pose of this submission: the work is cut, because a long one may hang a driver.
layout(push_constant) uniform Part { uint first_pose; } part;

int of_pose(uint pose, uint field) {
  return int(job.words[at_poses + pose * pose_words + field]);
}
