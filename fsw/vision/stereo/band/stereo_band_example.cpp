#include <algorithm>
#include <cstring>

#include "fsw/base/rng.hpp"
#include "fsw/vision/stereo/band/stereo_band.hpp"

namespace ilp {
namespace {

// A device is compared with every size of window, search and image that changes its way.
constexpr std::int32_t example_width = 96;

std::int32_t up_to(Rng& rng, std::int32_t most) {
  return static_cast<std::int32_t>(rng.below(static_cast<std::uint32_t>(most + 1)));
}

void make_search(Rng& rng, StereoBandInput& in) {
  in.run_count = 0;
  for (std::int32_t begin = 0; begin < in.width; begin += search_tile) {
    SearchRun& run = in.runs[static_cast<std::size_t>(in.run_count++)];
    run.begin = begin;
    run.end = std::min(begin + search_tile, in.width);
    run.count = std::min(disparity_block * (1 + up_to(rng, 2)), in.padded);
    run.first = up_to(rng, in.padded - run.count);
  }
}

void make_images(Rng& rng, StereoBandInput& in) {
  const std::int32_t shift = in.min_disparity + up_to(rng, in.disparities - 1);
  for (std::int32_t y = 0; y < in.held_rows; ++y) {
    for (std::int32_t x = 0; x < in.width; ++x) {
      const std::size_t at = static_cast<std::size_t>(y) * stereo_band_width + static_cast<std::size_t>(x);
      // Ground in steps of some pixels, so that there are flat windows as well.
      const std::uint64_t ground = mix64((in.serial * std::uint64_t{4096} + static_cast<std::uint64_t>(y / 2)) * 4096 +
                                         static_cast<std::uint64_t>((x + 512) / 3));
      in.left[at] = static_cast<std::uint8_t>(ground);
      const std::int32_t from = std::clamp(x + shift, 0, in.width - 1);
      const std::uint64_t there = mix64((in.serial * std::uint64_t{4096} + static_cast<std::uint64_t>(y / 2)) * 4096 +
                                        static_cast<std::uint64_t>((from + 512) / 3));
      in.right[at] = static_cast<std::uint8_t>((there & 0xFFU) ^ (rng.below(16) == 0 ? 7U : 0U));
      in.left_valid[at] = rng.below(32) == 0 ? 0 : 255;
      in.right_valid[at] = rng.below(32) == 0 ? 0 : 255;
    }
  }
}

void make_paths(Rng& rng, StereoBandInput& in) {
  const auto guard = static_cast<std::uint8_t>(255 - in.small_step);
  constexpr std::uint32_t dearest = max_matching_cost + max_large_step;
  for (std::size_t column = 0; column < std::size_t{handed_paths} * stereo_band_width; ++column) {
    std::uint8_t* const costs = in.paths.data() + column * stereo_band_disparities;
    if (static_cast<std::int32_t>(column % stereo_band_width) >= in.width) continue;
    const std::int32_t first = up_to(rng, in.padded - disparity_block);
    for (std::int32_t d = 0; d < in.padded; ++d) {
      const bool searched = d >= first && d < first + disparity_block;
      costs[d] = searched ? static_cast<std::uint8_t>(rng.below(dearest + 1)) : guard;
    }
  }
}

}  // namespace

void make_stereo_band_example(std::uint32_t number, StereoBandWorkspace& w, StereoBandInput& in) {
  std::memset(static_cast<void*>(&in), 0, sizeof in);
  Rng rng(number, 0x42616E64);
  // Jobs of a flight count from 1.
  in.serial = ~number;
  in.width = example_width - up_to(rng, 40);
  in.rows = std::min(4 + up_to(rng, 8), stereo_band_rows);
  in.radius = 1 + up_to(rng, max_window_radius - 1);
  in.continues = static_cast<std::int32_t>(number & 1U);
  in.first_row = in.continues != 0 ? in.radius : 0;
  in.held_rows = in.first_row + in.rows + up_to(rng, in.radius);
  in.disparities = 17 + up_to(rng, stereo_band_disparities - 17);
  in.padded = whole_blocks(in.disparities);
  in.min_disparity = up_to(rng, 80) - 60;
  in.lead = 1 + up_to(rng, 12);
  in.small_step = up_to(rng, max_small_step);
  in.out_of_view_cost = up_to(rng, max_matching_cost);
  in.damping = static_cast<float>((2 * in.radius + 1) * (2 * in.radius + 1));
  for (std::uint8_t& step : in.large_step) {
    step = static_cast<std::uint8_t>(in.small_step + up_to(rng, max_large_step - in.small_step));
  }
  make_search(rng, in);
  make_images(rng, in);
  if (in.continues != 0) make_paths(rng, in);
  // The processor's memory for products is not in use yet.
  complete_stereo_band(in, *w.ncc, reinterpret_cast<float*>(w.ncc->column_products.data()));
}

}  // namespace ilp
