#include "fsw/vision/stereo/semi_global/ordering_filter.hpp"

#include <algorithm>

#include "fsw/base/vector_width.hpp"

namespace ilp {
namespace {

static_assert(limits::max_rectified_width < 0xFFFF, "a left column + 1 has 16 bits");
/// Columns that a match may have in the right image: one image width to either side of it.
constexpr std::int32_t columns = 3 * limits::max_rectified_width;
static_assert(columns <= 0xFFFF, "a right column has 16 bits");

/// The right column, 1 .. columns.
std::int32_t right_column(std::int32_t x, float disparity_px) {
  // Truncation of a positive value, which rounds to nearest. The order of the limits takes care of NaN.
  const float shifted = static_cast<float>(x + limits::max_rectified_width + 1) - disparity_px + 0.5F;
  const float limited = shifted < static_cast<float>(columns) ? shifted : static_cast<float>(columns);
  return static_cast<std::int32_t>(shifted >= 1 ? limited : 1.0F);
}

/// Whether the row is in order already, as on almost all ground.
bool in_order(std::int32_t width, const float* disparity_px, const float* sigma_px) {
  constexpr std::int32_t chunk = 64;
  std::int32_t column[chunk + 1];
  std::int32_t last = 0;
  for (std::int32_t first = 0; first < width; first += chunk) {
    const std::int32_t count = std::min(width - first, chunk);
    std::int32_t empty = 0;
    for (std::int32_t i = 0; i < count; ++i) {
      const bool matched = sigma_px[first + i] > 0;
      const std::int32_t here = right_column(first + i, disparity_px[first + i]);
      column[i + 1] = matched ? here : 0;
      empty |= static_cast<std::int32_t>(!matched);
    }
    if (empty == 0) {
      column[0] = last;
      std::int32_t back = 0;
      for (std::int32_t i = 0; i < count; ++i) back |= static_cast<std::int32_t>(column[i + 1] < column[i]);
      if (back != 0) return false;
      last = column[count];
      continue;
    }
    for (std::int32_t i = 1; i <= count; ++i) {
      if (column[i] == 0) continue;
      if (column[i] < last) return false;
      last = column[i];
    }
  }
  return true;
}

/// The number of chains whose last right column is at most `column`; the columns do not fall.
std::int32_t chains_up_to(const std::uint16_t* last_right, std::int32_t chains, std::uint16_t column) {
  // On ground a match nearly always goes on from the longest chain.
  if (chains == 0 || last_right[chains - 1] <= column) return chains;
  return static_cast<std::int32_t>(std::upper_bound(last_right, last_right + chains, column) - last_right);
}

void keep_ordered(std::int32_t width, const float* disparity_px, float* sigma_px, OrderingWorkspace& workspace) {
  if (in_order(width, disparity_px, sigma_px)) return;
  std::uint16_t* last_right = workspace.last_right.data();
  std::uint16_t* last_left = workspace.last_left.data();
  std::uint16_t* previous = workspace.previous.data();
  std::int32_t longest = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    if (!(sigma_px[x] > 0)) continue;
    const auto column = static_cast<std::uint16_t>(right_column(x, disparity_px[x]));
    const std::int32_t before = chains_up_to(last_right, longest, column);
    previous[x] = before > 0 ? last_left[before - 1] : std::uint16_t{0};
    last_right[before] = column;
    last_left[before] = static_cast<std::uint16_t>(x + 1);
    longest = std::max(longest, before + 1);
  }
  std::int32_t next = longest > 0 ? last_left[longest - 1] : 0;
  for (std::int32_t x = width - 1; x >= 0; --x) {
    if (next == x + 1) {
      next = previous[x];
    } else {
      sigma_px[x] = 0;
    }
  }
}

}  // namespace

void keep_ordered_row(std::int32_t width, const float* disparity_px, float* sigma_px, OrderingWorkspace& workspace) {
  with_widest_vectors([&] { keep_ordered(width, disparity_px, sigma_px, workspace); });
}

}  // namespace ilp
