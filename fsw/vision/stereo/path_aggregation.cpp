#include "fsw/vision/stereo/path_aggregation.hpp"

#include <algorithm>

namespace ilp {
namespace {

/// One step of a path; the lowest new cost is returned.
std::uint8_t advance(const std::uint8_t* __restrict cost, const std::uint8_t* __restrict previous, int previous_lowest,
                     int small_step, int large_step, std::int32_t count, std::uint8_t* __restrict out) {
  // The lowest cost behind may be of a disparity that is not searched here, and then be higher than any other.
  const auto jump = static_cast<std::uint8_t>(std::min(previous_lowest + large_step, 255));
  const auto step = static_cast<std::uint8_t>(small_step);
  const auto base = static_cast<std::uint8_t>(previous_lowest);
  std::uint8_t lowest = 255;
  for (std::int32_t d = 0; d < count; ++d) {
    const std::uint8_t near = static_cast<std::uint8_t>(std::min(previous[d - 1], previous[d + 1]) + step);
    const std::uint8_t best = std::min(std::min(previous[d], jump), near);
    const auto value = static_cast<std::uint8_t>(cost[d] + static_cast<std::uint8_t>(best - base));
    out[d] = value;
    lowest = std::min(lowest, value);
  }
  return lowest;
}

void add_paths(const std::uint8_t* __restrict a, const std::uint8_t* __restrict b, const std::uint8_t* __restrict c,
               const std::uint8_t* __restrict e, std::int32_t count, std::int16_t* __restrict sum) {
  for (std::int32_t d = 0; d < count; ++d) sum[d] = static_cast<std::int16_t>(a[d] + b[d] + c[d] + e[d]);
}

void add_path(const std::uint8_t* __restrict a, std::int32_t count, std::int16_t* __restrict sum) {
  for (std::int32_t d = 0; d < count; ++d) sum[d] = static_cast<std::int16_t>(sum[d] + a[d]);
}

/// No path has come yet: zero costs between guards.
void clear(std::uint8_t* costs, std::int32_t pixels, std::int32_t padded, std::uint8_t guard) {
  const std::int32_t stride = padded + path_guard;
  std::fill_n(costs, static_cast<std::ptrdiff_t>(pixels) * stride + path_guard, guard);
  for (std::int32_t x = 0; x < pixels; ++x)
    std::fill_n(costs + path_guard + static_cast<std::ptrdiff_t>(x) * stride, padded, std::uint8_t{0});
}

void start(std::int32_t width, std::int32_t padded, const PathPenalties& penalties, PathWorkspace& w) {
  const auto guard = static_cast<std::uint8_t>(255 - penalties.small_step);
  for (auto& parity : w.from_above) {
    for (PathRow& row : parity) {
      clear(row.costs.data(), width, padded, guard);
      row.lowest.fill(0);
    }
  }
  for (auto& buffer : w.along) clear(buffer.data(), 1, padded, guard);
  clear(w.zero.data(), 1, padded, guard);
}

}  // namespace

PathPenalties make_path_penalties(const StereoParams& params) {
  PathPenalties penalties;
  penalties.small_step = std::clamp(params.small_step_penalty, 0, max_small_step);
  const int most = std::clamp(params.large_step_penalty, penalties.small_step, max_large_step);
  const int least = std::clamp(params.min_large_step_penalty, penalties.small_step, most);
  for (int grey = 0; grey < 256; ++grey) {
    // Inverse to the gradient beyond edge_grey, as a depth edge is usually an image edge.
    const int penalty = grey <= params.edge_grey ? most : most * params.edge_grey / grey;
    penalties.large_step[static_cast<std::size_t>(grey)] = static_cast<std::uint8_t>(std::max(least, penalty));
  }
  return penalties;
}

void aggregate_row(GrayView left, std::int32_t y, const SearchRow& search, std::int32_t padded,
                   const PathPenalties& penalties, const std::uint8_t* cost, PathWorkspace& w, std::int16_t* sum) {
  const std::int32_t width = left.width;
  const std::int32_t stride = padded + path_guard;
  const auto guard = static_cast<std::uint8_t>(255 - penalties.small_step);
  if (y == 0) start(width, padded, penalties, w);
  if (y == 0 || !(search == w.search)) {
    w.search = search;
    w.stale_rows = 2;
  }
  const std::uint8_t* grey = left.row(y);
  const std::uint8_t* grey_above = left.row(std::max(y - 1, 0));
  const auto large_step = [&](std::uint8_t a, std::uint8_t b) {
    return int{penalties.large_step[static_cast<std::size_t>(a > b ? a - b : b - a)]};
  };
  PathRow* previous = w.from_above[(y & 1) ^ 1];
  PathRow* current = w.from_above[y & 1];
  // What is not searched stays a guard, so that paths may come from any other search.
  if (w.stale_rows > 0) {
    --w.stale_rows;
    for (int k = 0; k < 3; ++k) {
      std::fill_n(current[k].costs.data(), static_cast<std::ptrdiff_t>(width) * stride + path_guard, guard);
    }
  }
  const auto along_row = [&](std::int32_t x, bool stale) {
    auto& row = w.along[x & 1];
    if (stale) std::fill_n(row.data(), stride + path_guard, guard);
    return row.data() + path_guard;
  };

  const std::uint8_t* behind = w.zero.data() + path_guard;
  int behind_lowest = 0;
  for (const SearchRun& run : w.search) {
    for (std::int32_t x = run.begin; x < run.end; ++x) {
      const std::uint8_t* c = cost + static_cast<std::ptrdiff_t>(x) * padded + run.first;
      const std::ptrdiff_t here = path_guard + static_cast<std::ptrdiff_t>(x) * stride + run.first;
      std::uint8_t* along = along_row(x, x < run.begin + 2);
      behind_lowest = advance(c, behind + run.first, behind_lowest, penalties.small_step,
                              large_step(grey[x], grey[std::max(x - 1, 0)]), run.count, along + run.first);
      behind = along;
      for (int k = 0; k < 3; ++k) {
        const std::int32_t from = x + k - 1;
        const bool inside = from >= 0 && from < width;
        const std::uint8_t* path =
            inside ? previous[k].costs.data() + path_guard + static_cast<std::ptrdiff_t>(from) * stride
                   : w.zero.data() + path_guard;
        const int lowest = inside ? previous[k].lowest[static_cast<std::size_t>(from)] : 0;
        const int jump = large_step(grey[x], inside ? grey_above[from] : grey[x]);
        current[k].lowest[static_cast<std::size_t>(x)] =
            advance(c, path + run.first, lowest, penalties.small_step, jump, run.count, current[k].costs.data() + here);
      }
      add_paths(along + run.first, current[0].costs.data() + here, current[1].costs.data() + here,
                current[2].costs.data() + here, run.count, sum + static_cast<std::ptrdiff_t>(x) * padded + run.first);
    }
  }

  behind = w.zero.data() + path_guard;
  behind_lowest = 0;
  for (std::int32_t r = w.search.size - 1; r >= 0; --r) {
    const SearchRun& run = w.search.runs[static_cast<std::size_t>(r)];
    for (std::int32_t x = run.end - 1; x >= run.begin; --x) {
      const std::ptrdiff_t entry = static_cast<std::ptrdiff_t>(x) * padded + run.first;
      std::uint8_t* along = along_row(x, x >= run.end - 2);
      behind_lowest = advance(cost + entry, behind + run.first, behind_lowest, penalties.small_step,
                              large_step(grey[x], grey[std::min(x + 1, width - 1)]), run.count, along + run.first);
      behind = along;
      add_path(along + run.first, run.count, sum + entry);
    }
  }
}

}  // namespace ilp
