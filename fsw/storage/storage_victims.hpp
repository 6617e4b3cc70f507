// Finds the products whose bytes are erased first when storage is full (decisions.md, 12).
#pragma once

#include "fsw/base/fixed_vector.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Whether the last layer may be erased: it is not the first one and was not sent.
[[nodiscard]] bool last_layer_can_go(const ProductRecord& product);
/// Whether the product may be erased: nothing of it was sent.
[[nodiscard]] bool product_can_go(const ProductRecord& product);
/// The utility of the last layer per byte: the product's priority times the layer's gain in dB, divided by its bytes.
/// The gain is that of the PSNR for an image, and 6 dB per halving of the largest error for a depth map; it is 1 if no
/// quality is on record.
[[nodiscard]] double utility_of_last_layer(const ProductRecord& product);

/// Finds the products of least utility in the complete table, in slices of bounded length and with bounded memory.
/// Products that did not fit are found by the next search.
class VictimSearch {
 public:
  struct Victim {
    std::int64_t product_id = 0;
    double utility = 0;
  };

  void restart();
  /// Examines further products up to `through_id`.
  Status look(Reader<ProductRecord> store, std::int64_t through_id);
  [[nodiscard]] bool complete() const { return complete_; }
  /// Whether the victims are complete products: this is so only if no last layer may be erased.
  [[nodiscard]] bool of_whole_products() const { return !any_layer_; }
  /// Takes the victim of least utility. Returns false if there are no more.
  bool take(Victim& victim);

 private:
  static constexpr std::size_t capacity = 1024;
  using Victims = FixedVector<Victim, capacity>;
  static void insert(const Victim& victim, Victims& victims);

  std::int64_t looked_at_id_ = 0;
  bool complete_ = false;
  bool any_layer_ = false;
  std::size_t taken_ = 0;
  Victims layers_, products_;
};

}  // namespace ilp
