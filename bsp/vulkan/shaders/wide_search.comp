#version 450
// Sums of absolute differences at all shifts of a pose: one workgroup does one shift along y. It has the bytes of
// best_of_row() in wide_search.cpp: whole numbers only, and a maximum, in which the order of the invocations does not
// matter.
#extension GL_GOOGLE_include_directive : require
#include "wide_memory.glsl"

shared uint best;

// 255 in each byte that is not 0.
uint mask_of(uint four) {
  const uint set = (((four & 0x7f7f7f7fu) + 0x7f7f7f7fu) | four) & 0x80808080u;
  return (set >> 7) * 255u;
}

// Absolute differences of the bytes in the lower half of each half-word; the sum stays below 2 x 255.
uint differences(uint p, uint q) {
  const uint d = (p | 0x80008000u) - q;
  const uint below = (~d >> 15) & 0x00010001u;  // 1 where p is less than q
  return ((d & 0x7fff7fffu) ^ (below * 0x7fffu)) + below;
}

// Bytes `first` to `first + 3` of a row of a plane of b; those outside of the row are 0.
uint four_of_b(uint row, int first) {
  const int word = first >> 2;
  const uint low = word >= 0 && word < int(plane_words) ? job.words[row + uint(word)] : 0u;
  const uint high = word + 1 >= 0 && word + 1 < int(plane_words) ? job.words[row + uint(word + 1)] : 0u;
  const uint shift = 8u * uint(first & 3);
  return shift == 0u ? low : (low >> shift) | (high << (32u - shift));
}

uint score_of(uint pose, int x, int y) {
  const uint plane = at_b + uint((y & 3) * 4 + (x & 3)) * plane_rows * plane_words;
  const int right = x >> 2, down = y >> 2;
  const int plane_columns = (int(job.words[at_width]) - (x & 3) + 3) >> 2;
  const int plane_height = (int(job.words[at_height]) - (y & 3) + 3) >> 2;
  const int first_row = max(-down, 0), end_row = min(of_pose(pose, rows), plane_height - down);
  const int first_column = max(-right, 0), end_column = min(of_pose(pose, columns), plane_columns - right);
  uint difference = 0u, count = 0u;
  for (int j = first_row; j < end_row; ++j) {
    const uint canvas = (pose * canvas_side + uint(j)) * canvas_words;
    const uint row = plane + uint(j + down) * plane_words;
    uint sum = 0u;
    for (int word = first_column >> 2; word * 4 < end_column; ++word) {
      const uint p = canvases.words[canvas + uint(word)], q = four_of_b(row, word * 4 + right);
      const uint mask = mask_of(p) & mask_of(q), from_p = p & mask, from_q = q & mask;
      sum += differences(from_p & 0x00ff00ffu, from_q & 0x00ff00ffu) +
             differences((from_p >> 8) & 0x00ff00ffu, (from_q >> 8) & 0x00ff00ffu);
      count += uint(bitCount(mask & 0x01010101u));
    }
    difference += (sum & 0xffffu) + (sum >> 16);
  }
  const int better = int(unrelated * count) - int(difference);
  if (int(count) < of_pose(pose, min_count) || better <= 0) return 0u;
  return uint(better) * uint(better) / count;
}

void main() {
  const uint iy = gl_WorkGroupID.x, pose = part.first_pose + gl_WorkGroupID.y;
  if (gl_LocalInvocationID.x == 0u) best = 0u;
  barrier();
  const bool there = pose < job.words[at_pose_count] && int(iy) < of_pose(pose, shifts_y);
  if (there) {
    const int y = of_pose(pose, top) + 2 * int(iy);
    for (uint ix = gl_LocalInvocationID.x; int(ix) < of_pose(pose, shifts_x); ix += 64u) {
      const uint found = score_of(pose, of_pose(pose, left) + 2 * int(ix), y);
      if (found != 0u) atomicMax(best, (found << shift_bits) | ix);
    }
  }
  barrier();
  if (gl_LocalInvocationID.x == 0u) result.best[pose * max_shifts + iy] = best;
}
