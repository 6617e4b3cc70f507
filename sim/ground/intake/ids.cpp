#include "sim/ground/intake/ids.hpp"

#include <charconv>
#include <cstring>
#include <string>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::intake {
namespace {

bool names_an_id(std::string_view field) {
  return field == "id" || field.ends_with("_id");
}

/// Ids, times and sizes are calculated with; others are only shown.
bool in_range(const RecordInfo& info, std::string_view field, std::int64_t value) {
  // A map's id is a digest, with which nothing is calculated.
  if (info.type == RecordType::fix && field == "map_id") return true;
  if (!names_an_id(field)) {
    const bool is_free = !field.ends_with("_ns") && !field.ends_with("_bytes");
    return is_free || (value >= -largest_number && value <= largest_number);
  }
  // These may be ids of products.
  const bool of_products = field == "subject_id" || (info.type == RecordType::product && field == "id");
  return value >= 0 && value <= (of_products ? product_id(largest_id, ProductKind::image) : largest_id);
}

}  // namespace

std::optional<ProductName> product_of(std::int64_t id) {
  if (id < 0) return std::nullopt;
  const ProductName product{id / 4, static_cast<ProductKind>(id % 4)};
  const bool good = is_id(product.keyframe_id) && product.kind < ProductKind::count;
  return good ? std::optional(product) : std::nullopt;
}

std::optional<ProductName> product_named(std::string_view name) {
  constexpr std::string_view prefix = "product-";
  if (!name.starts_with(prefix)) return std::nullopt;
  name.remove_prefix(prefix.size());
  ProductName product;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), product.keyframe_id);
  if (error != std::errc() || !is_id(product.keyframe_id)) return std::nullopt;
  name.remove_prefix(static_cast<std::size_t>(end - name.data()));
  if (name == "-image.jp2") return product;
  product.kind = ProductKind::depth;
  if (name == "-depth.jp2") return product;
  return std::nullopt;
}

void check_numbers(const RecordInfo& info, const void* record) {
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (field.type != FieldType::i64) continue;
    for (std::size_t i = 0; i < field.count; ++i) {
      std::int64_t value = 0;
      std::memcpy(&value, static_cast<const std::uint8_t*>(record) + field.offset + i * sizeof(value), sizeof(value));
      if (in_range(info, field.name, value)) continue;
      throw BadFile(std::string("a ") + info.name + " record whose " + field.name + " is " + std::to_string(value) +
                    ": no flight has such a number");
    }
  }
  if (info.type != RecordType::product) return;
  ProductRecord product;
  std::memcpy(&product, record, sizeof(product));
  const auto named = product_of(product.id);
  if (!named || named->keyframe_id != product.keyframe_id || named->kind != product.kind) {
    throw BadFile("a product record whose id " + std::to_string(product.id) + " is not that of its keyframe");
  }
}

}  // namespace ilp::intake
