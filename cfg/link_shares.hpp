// The least share of a permanently busy link that each class of file gets.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp {

enum class FileClass : std::uint8_t { products, records, points, events, count };
inline constexpr std::size_t file_classes = static_cast<std::size_t>(FileClass::count);

/// Guaranteed share of each FileClass in all bytes sent, in thousandths. The remaining bytes follow the usual order.
/// The shares keep any class from waiting for ever.
inline constexpr std::int64_t link_share_permille[file_classes] = {500, 200, 50, 50};

constexpr std::int64_t sum_of_link_shares() {
  std::int64_t sum = 0;
  for (const std::int64_t share : link_share_permille) sum += share;
  return sum;
}
static_assert(sum_of_link_shares() <= 1000, "a link has no more than all of itself");

}  // namespace ilp
