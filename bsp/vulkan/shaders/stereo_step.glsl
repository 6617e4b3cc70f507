// One step of a path at four disparities of a lane; 32 lanes share a path (H. Hirschmueller, PAMI 30(2), 2008, eq. 13).
// It has the bytes of advance() in path_steps.inc.

const uint path_lanes = disparities / 4u;
// What a lane tells the others of its path: first and last cost, and the lowest.
shared uint first_cost[2][64], last_cost[2][64], lowest_cost[2][64];

void publish(uint parity, uvec4 costs) {
  const uint i = gl_LocalInvocationID.x;
  first_cost[parity][i] = costs.x;
  last_cost[parity][i] = costs.w;
  lowest_cost[parity][i] = min(min(costs.x, costs.y), min(costs.z, costs.w));
}

uvec4 unpacked(uint word) {
  return uvec4(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u, word >> 24);
}
uint packed(uvec4 costs) {
  return costs.x | costs.y << 8 | costs.z << 16 | costs.w << 24;
}

uint guard_cost() {
  return 255u - job.words[at_small_step];
}
/// The costs where a path begins: 0, and guards at disparities beyond the padded ones.
uvec4 beginning(uint d0) {
  return d0 < job.words[at_padded] ? uvec4(0u) : uvec4(guard_cost());
}

/// Costs here, where all lanes of the path have published those behind.
uvec4 advanced(uint parity, uvec4 cost, uvec4 behind, uint contrast, uvec2 run, uint d0) {
  const uint i = gl_LocalInvocationID.x, lane = i % path_lanes, begin = i - lane;
  uint lowest = max_lowest;
  for (uint k = 0u; k < path_lanes; ++k) lowest = min(lowest, lowest_cost[parity][begin + k]);
  const uint under = lane == 0u ? guard_cost() : last_cost[parity][i - 1u];
  const uint over = lane + 1u == path_lanes ? guard_cost() : first_cost[parity][i + 1u];
  const uvec4 before = uvec4(under, behind.xyz), after = uvec4(behind.yzw, over);
  const uvec4 near = min(min(before, after) + job.words[at_small_step], behind);
  const uvec4 costs = cost + min(near - lowest, uvec4(byte_of(job.words[place_large_step], contrast)));
  const uvec4 d = uvec4(d0, d0 + 1u, d0 + 2u, d0 + 3u);
  const bvec4 searched = bvec4(uvec4(greaterThanEqual(d, uvec4(run.x))) * uvec4(lessThan(d, uvec4(run.y))));
  return mix(uvec4(guard_cost()), costs, searched);
}

/// Difference of grey of two pixels of the left image, rows counted from the band's first.
uint contrast_of(int y, uint x, int other_y, uint other_x) {
  const uint row_bytes = job.words[place_row_bytes], first = job.words[at_first_row], left = job.words[place_left];
  // Above the first row of an image there is that row.
  const uint row = uint(int(first) + y) * row_bytes, other = uint(max(int(first) + other_y, 0)) * row_bytes;
  return uint(abs(int(byte_of(left, row + x)) - int(byte_of(left, other + other_x))));
}
