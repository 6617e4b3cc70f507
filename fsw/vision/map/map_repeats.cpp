#include "fsw/vision/map/map_repeats.hpp"

#include <algorithm>
#include <span>

#include "fsw/vision/map/map_channels.hpp"
#include "fsw/vision/map/map_light.hpp"
#include "fsw/vision/map/map_votes.hpp"
#include "fsw/vision/map/patch_search.hpp"

namespace ilp {
namespace {

constexpr std::int32_t widest_px = 64;  // of the keyframe's ground: heights are smooth
constexpr std::int32_t most_reduced = 4;
constexpr PatchSearch by_heights{map_relief_patch_px, 0.5F};
constexpr std::int32_t own_px = 4;  // from a patch's own place: another one
constexpr std::int32_t same_shift_px = 1;
constexpr std::int32_t least_reaching = 6;
constexpr std::int64_t products_of_slice = 6'000'000;

/// Every so many cells of the heights become the window.
void reduce(const MapWindow& window, double level_m, std::int32_t factor, MapRegistrationWorkspace& workspace) {
  MapChannels<max_map_window_side>& all = workspace.window;
  all.width = window.width / factor;
  all.height = window.height / factor;
  for (std::int32_t row = 0; row < all.height; ++row) {
    for (std::int32_t column = 0; column < all.width; ++column) {
      const std::size_t from = static_cast<std::size_t>(row * factor) * static_cast<std::size_t>(window.width) +
                               static_cast<std::size_t>(column * factor);
      all.value[all.at(column, row)] =
          window.known[from] != 0
              ? raw_height(static_cast<double>(window.height_m[from]) - level_m, factor * window.pixel_m)
              : unknown_value;
    }
  }
  fill_directions(all, mean_gradient(all), 0, all.height);
  (void)normalise_values(all.value.data(), all.at(0, all.height));
}

/// The part of the reduced window about the keyframe's ground becomes the sheet.
void cut_out(std::int32_t factor, std::int32_t first_column, std::int32_t first_row,
             MapRegistrationWorkspace& workspace) {
  const MapChannels<max_map_window_side>& all = workspace.window;
  MapChannels<max_map_sheet_side>& sheet = workspace.sheet;
  sheet.width = std::min(sheet.width / factor, all.width - first_column);
  sheet.height = std::min(sheet.height / factor, all.height - first_row);
  for (std::int32_t row = 0; row < sheet.height; ++row) {
    for (std::int32_t column = 0; column < sheet.width; ++column) {
      const std::size_t to = sheet.at(column, row), from = all.at(first_column + column, first_row + row);
      sheet.value[to] = all.value[from];
      std::copy_n(all.direction.data() + 2 * from, 2, sheet.direction.data() + 2 * to);
    }
  }
}

/// The best place of a patch in the whole window but its own one, as a shift from there; false where it has none.
bool find_elsewhere(std::int32_t column, std::int32_t row, MapPatch& patch, MapRegistrationWorkspace& workspace) {
  const std::int32_t columns = workspace.window.width - by_heights.side + 1,
                     rows = workspace.window.height - by_heights.side + 1;
  std::int32_t best = 0;
  for (std::int32_t top = 0; top < rows; top += max_map_lags) {
    for (std::int32_t left = 0; left < columns; left += max_map_lags) {
      const LagRange lags{left - patch.column, top - patch.row, std::min(max_map_lags, columns - left),
                          std::min(max_map_lags, rows - top)};
      search_patch(patch, by_heights, lags, workspace);
      for (std::int32_t y = 0; y < lags.rows; ++y) {
        const std::int32_t* const scores = workspace.surface.data() + static_cast<std::ptrdiff_t>(y) * map_lag_stride;
        const std::int32_t down = top + y - row - patch.row;
        for (std::int32_t x = 0; x < lags.columns; ++x) {
          const std::int32_t right = left + x - column - patch.column;
          if (scores[x] <= best || std::max(std::abs(right), std::abs(down)) <= own_px) continue;
          best = scores[x];
          patch.best_column = static_cast<std::int16_t>(right);
          patch.best_row = static_cast<std::int16_t>(down);
        }
      }
    }
  }
  return best > 0;
}

}  // namespace

void RepeatSearch::begin(const MapWindow& window, double level_m, const MapPlan& plan,
                         MapRegistrationWorkspace& workspace) {
  const std::int32_t side = std::max(workspace.sheet.width, workspace.sheet.height);
  const std::int32_t factor = std::clamp((side + widest_px - 1) / widest_px, 1, most_reduced);
  reduce(window, level_m, factor, workspace);
  column_ = plan.sheet_column / factor;
  row_ = plan.sheet_row / factor;
  cut_out(factor, column_, row_, workspace);
  patches_ = choose_patches(workspace.sheet, by_heights.side, workspace);
  patch_ = 0;
  evidence_ = 0;
}

bool RepeatSearch::step(MapRegistrationWorkspace& workspace) {
  const std::int64_t products =
      std::int64_t{3} * by_heights.side * by_heights.side * workspace.window.width * workspace.window.height;
  for (std::int64_t work = 0; patch_ < patches_ && work < products_of_slice; ++patch_) {
    MapPatch& patch = workspace.patches[static_cast<std::size_t>(patch_)];
    patch.used = has_texture(workspace.sheet, patch, by_heights);
    if (!patch.used) continue;
    patch.used = find_elsewhere(column_, row_, patch, workspace);
    work += products;
  }
  if (patch_ < patches_) return true;
  count(workspace);
  return false;
}

void RepeatSearch::count(const MapRegistrationWorkspace& workspace) {
  const std::span<const MapPatch> patches(workspace.patches.data(), static_cast<std::size_t>(patches_));
  const std::int32_t columns = workspace.window.width - by_heights.side + 1,
                     rows = workspace.window.height - by_heights.side + 1;
  const double places = static_cast<double>(columns) * rows;
  for (const MapPatch& patch : patches) {
    if (!patch.used) continue;
    std::int32_t reaching = 0, votes = 0;
    for (const MapPatch& other : patches) {
      if (!other.used) continue;
      const std::int32_t x = column_ + other.column + patch.best_column, y = row_ + other.row + patch.best_row;
      if (x < 0 || y < 0 || x >= columns || y >= rows) continue;
      ++reaching;
      votes += std::abs(other.best_column - patch.best_column) <= same_shift_px &&
                       std::abs(other.best_row - patch.best_row) <= same_shift_px
                   ? 1
                   : 0;
    }
    if (reaching >= least_reaching) evidence_ = std::max(evidence_, vote_evidence(votes, reaching, places));
  }
}

}  // namespace ilp
