// Checks the ids and times of downlinked files, so that sums and multiples of them cannot overflow, and parses names of
// products.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "fsw/records/field.hpp"
#include "fsw/records/records.hpp"

namespace ilp::intake {

/// Largest valid id. No flight reaches it in all its store epochs, and its product_id() does not overflow.
inline constexpr std::int64_t largest_id = std::int64_t{1} << 60U;
/// Largest valid magnitude of a time: the difference of two such numbers does not overflow.
inline constexpr std::int64_t largest_number = (std::int64_t{1} << 62U) - 1;

[[nodiscard]] constexpr bool is_id(std::int64_t number) {
  return number >= 1 && number <= largest_id;
}

struct ProductName {
  std::int64_t keyframe_id = 0;
  ProductKind kind = ProductKind::image;
};

/// Keyframe and kind of an id that product_id() made; none for other numbers.
[[nodiscard]] std::optional<ProductName> product_of(std::int64_t product_id);
/// Keyframe and kind of a file named product-KKKKKK-image.jp2 or product-KKKKKK-depth.jp2; none for other names.
[[nodiscard]] std::optional<ProductName> product_named(std::string_view file_name);

/// Throws BadFile if an id or a time of the record is out of range, or a product's id contradicts its keyframe and
/// kind.
void check_numbers(const RecordInfo& info, const void* record);

}  // namespace ilp::intake
