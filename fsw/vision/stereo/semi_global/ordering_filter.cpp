#include "fsw/vision/stereo/semi_global/ordering_filter.hpp"

namespace ilp {
namespace {

static_assert(limits::max_rectified_width < 0xFFFF, "a left column + 1 has 16 bits");
constexpr std::int32_t columns = OrderingWorkspace::columns;

/// The right column, 1 .. columns.
std::int32_t right_column(std::int32_t x, float disparity_px) {
  // Truncation of a positive value, which rounds to nearest.
  const float shifted = static_cast<float>(x + limits::max_rectified_width + 1) - disparity_px + 0.5F;
  if (!(shifted >= 1)) return 1;
  return shifted < static_cast<float>(columns) ? static_cast<std::int32_t>(shifted) : columns;
}

/// Whether the row is in order already, as on almost all ground.
bool in_order(std::int32_t width, const float* disparity_px, const float* sigma_px) {
  std::int32_t last = 0;
  for (std::int32_t x = 0; x < width; ++x) {
    if (!(sigma_px[x] > 0)) continue;
    const std::int32_t column = right_column(x, disparity_px[x]);
    if (column < last) return false;
    last = column;
  }
  return true;
}

std::uint32_t longest_up_to(const OrderingWorkspace& workspace, std::int32_t column) {
  std::uint32_t longest = 0;
  for (std::int32_t i = column; i > 0; i -= i & -i) {
    const std::uint32_t chain = workspace.longest[static_cast<std::size_t>(i)];
    if (chain > longest) longest = chain;
  }
  return longest;
}

void insert(OrderingWorkspace& workspace, std::int32_t column, std::uint32_t chain) {
  for (std::int32_t i = column; i <= columns; i += i & -i) {
    std::uint32_t& longest = workspace.longest[static_cast<std::size_t>(i)];
    if (chain > longest) longest = chain;
  }
}

}  // namespace

void keep_ordered_row(std::int32_t width, const float* disparity_px, float* sigma_px, OrderingWorkspace& workspace) {
  if (in_order(width, disparity_px, sigma_px)) return;
  workspace.longest.fill(0);
  for (std::int32_t x = 0; x < width; ++x) {
    if (!(sigma_px[x] > 0)) continue;
    const std::int32_t column = right_column(x, disparity_px[x]);
    const std::uint32_t before = longest_up_to(workspace, column);
    workspace.previous[static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(before & 0xFFFFU);
    const std::uint32_t length = (before >> 16U) + 1;
    insert(workspace, column, length << 16U | static_cast<std::uint32_t>(x + 1));
  }
  std::uint32_t next = longest_up_to(workspace, columns) & 0xFFFFU;
  for (std::int32_t x = width - 1; x >= 0; --x) {
    if (next == static_cast<std::uint32_t>(x + 1)) {
      next = workspace.previous[static_cast<std::size_t>(x)];
    } else {
      sigma_px[x] = 0;
    }
  }
}

}  // namespace ilp
