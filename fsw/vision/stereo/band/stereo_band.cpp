#include "fsw/vision/stereo/band/stereo_band.hpp"

#include <algorithm>
#include <cstring>

namespace ilp {
namespace {

GrayView rows_of(const StereoBandInput::Rows& rows, const StereoBandInput& in) {
  return {rows.data(), in.width, in.held_rows, stereo_band_width};
}

NccRows ncc_rows(const StereoBandInput& in) {
  NccRows rows;
  rows.left = rows_of(in.left, in);
  rows.right = rows_of(in.right, in);
  rows.left_valid = rows_of(in.left_valid, in);
  rows.right_valid = rows_of(in.right_valid, in);
  rows.min_disparity = in.min_disparity;
  rows.padded_disparities = in.padded;
  rows.radius = in.radius;
  rows.damping = in.damping;
  rows.out_of_view_cost = in.out_of_view_cost;
  rows.next_row = in.first_row;
  return rows;
}

template <typename T>
std::int32_t word_of(const StereoBandInput& in, const T& member) {
  const auto* const begin = reinterpret_cast<const std::byte*>(&in);
  return static_cast<std::int32_t>((reinterpret_cast<const std::byte*>(&member) - begin) / 4);
}

StereoBandPlaces places_of(const StereoBandInput& in) {
  StereoBandPlaces places{};
  places.large_step = word_of(in, in.large_step);
  places.runs = word_of(in, in.runs);
  places.left = word_of(in, in.left);
  places.right = word_of(in, in.right);
  places.left_sum = word_of(in, in.left_sum);
  places.left_inverse_norm = word_of(in, in.left_inverse_norm);
  places.right_mean = word_of(in, in.right_mean);
  places.right_inverse_norm = word_of(in, in.right_inverse_norm);
  places.paths = word_of(in, in.paths);
  places.row_bytes = stereo_band_width;
  places.row_pixels = stereo_band_width;
  places.paths_given = static_cast<std::int32_t>(offsetof(StereoBandOutput, paths) / 4);
  return places;
}

SearchRow search_of(const StereoBandInput& in) {
  SearchRow search;
  search.size = in.run_count;
  std::copy_n(in.runs.begin(), in.run_count, search.runs.begin());
  return search;
}

void begin_job(const StereoBandInput& in, StereoBandWorkspace& w) {
  w.input = &in;
  w.serial = in.serial;
  w.next_row = 0;
  w.rows = ncc_rows(in);
  w.penalties.small_step = in.small_step;
  for (std::size_t grey = 0; grey < in.large_step.size(); ++grey) {
    std::fill_n(w.penalties.large_step.begin() + static_cast<std::ptrdiff_t>(large_step_copies * grey),
                large_step_copies, in.large_step[grey]);
  }
  if (in.continues == 0) return;
  constexpr std::ptrdiff_t path_stride = std::ptrdiff_t{stereo_band_width} * stereo_band_disparities;
  take_handed_paths(in.width, in.first_row, in.padded, w.penalties,
                    {in.paths.data(), path_stride, stereo_band_disparities}, *w.paths);
}

void match_next_row(const StereoBandInput& in, const SearchRow& search, StereoBandWorkspace& w) {
  compute_ncc_row(w.rows, search, *w.ncc, w.correlations, w.costs, w.variance);
  aggregate_row(w.rows.left, in.first_row + w.next_row, search, in.padded, in.disparities, in.lead, w.penalties,
                w.costs, *w.paths, w.winners);
  ++w.next_row;
}

StereoBandPixel pixel_of(const RowWinner& winner, const std::int16_t* correlations, const SearchRun& run) {
  StereoBandPixel pixel;
  pixel.winner = static_cast<std::uint32_t>(winner.cost) | (winner.unique ? 1U << 15U : 0U) |
                 static_cast<std::uint32_t>(winner.index) << 16U;
  for (std::int32_t k = 0; k < stereo_band_peaks; ++k) {
    const std::int32_t index = winner.index + k - stereo_band_peaks / 2;
    const bool searched = index >= run.first && index < run.first + run.count;
    pixel.peaks[static_cast<std::size_t>(k)] = searched ? correlations[index] : std::int16_t{0};
  }
  return pixel;
}

void write_row(const StereoBandInput& in, const SearchRow& search, const StereoBandWorkspace& w,
               std::span<std::byte> output) {
  for (const SearchRun& run : search) {
    for (std::int32_t x = run.begin; x < run.end; ++x) {
      const StereoBandPixel pixel =
          pixel_of(w.winners[x], w.correlations + static_cast<std::ptrdiff_t>(x) * in.padded, run);
      std::memcpy(output.data() + static_cast<std::size_t>(x) * sizeof pixel, &pixel, sizeof pixel);
    }
  }
}

/// The costs of the handed paths from column `column` on, counted over all paths.
void write_paths(const StereoBandInput& in, std::size_t column, const StereoBandWorkspace& w,
                 std::span<std::byte> output) {
  const std::int32_t last = in.first_row + in.rows - 1;
  for (std::size_t at = 0; at < output.size(); at += stereo_band_disparities, ++column) {
    const auto x = static_cast<std::int32_t>(column % stereo_band_width);
    if (x >= in.width) continue;
    const std::uint8_t* const costs =
        handed_costs(*w.paths, last, in.padded, static_cast<int>(column / stereo_band_width), x);
    std::memcpy(output.data() + at, costs, static_cast<std::size_t>(in.padded));
  }
}

}  // namespace

void complete_stereo_band(StereoBandInput& in, NccWorkspace& workspace, float* variance) {
  in.places = places_of(in);
  NccRows rows = ncc_rows(in);
  for (std::int32_t y = 0; y < in.rows; ++y) {
    const std::size_t at = static_cast<std::size_t>(y) * stereo_band_width;
    compute_moments_row(
        rows, workspace,
        {&in.left_sum[at], &in.left_inverse_norm[at], &in.right_mean[at], &in.right_inverse_norm[at], variance + at});
  }
}

void compute_stereo_band_unit(const StereoBandInput& in, std::size_t unit, StereoBandWorkspace& w,
                              std::span<std::byte> output) {
  std::fill(output.begin(), output.end(), std::byte{0});
  const auto rows = static_cast<std::size_t>(in.rows);
  if (unit >= rows && unit < stereo_band_rows) return;
  const std::size_t end = std::min(unit + 1, rows);
  const auto done = static_cast<std::size_t>(w.next_row);
  if (w.input != &in || w.serial != in.serial || done > end || (done == end && unit < rows)) begin_job(in, w);
  const SearchRow search = search_of(in);
  while (static_cast<std::size_t>(w.next_row) < end) match_next_row(in, search, w);  // bound: one row a turn
  if (unit < rows) return write_row(in, search, w, output);
  write_paths(in, (unit - stereo_band_rows) * (stereo_band_unit_bytes / stereo_band_disparities), w, output);
}

}  // namespace ilp
