// Which numbers that come down can be ids and times of a flight, and what the name of a product says. Every name and
// every number of a file becomes an id here, so that none is so large that sums and multiples of it wrap.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "fsw/records/field.hpp"
#include "fsw/records/records.hpp"

namespace ilp::ground {

/// More than any flight makes in all its lives; product_id() of it is a number.
inline constexpr std::int64_t largest_id = std::int64_t{1} << 60U;
/// Differences of two are numbers.
inline constexpr std::int64_t largest_number = (std::int64_t{1} << 62U) - 1;

[[nodiscard]] constexpr bool is_id(std::int64_t number) {
  return number >= 1 && number <= largest_id;
}

struct ProductName {
  std::int64_t keyframe_id = 0;
  ProductKind kind = ProductKind::image;
};

/// Of an id as product_id() makes it; none for other numbers.
[[nodiscard]] std::optional<ProductName> product_of(std::int64_t product_id);
/// Of a file name: product-KKKKKK-image.jp2 or product-KKKKKK-depth.jp2.
[[nodiscard]] std::optional<ProductName> product_named(std::string_view file_name);

/// Throws BadFile when an id or a time of the record is none.
void check_numbers(const RecordInfo& info, const void* record);

}  // namespace ilp::ground
