// Chooses the products that lose bytes first when storage is full (decisions.md, 12).
#pragma once

#include "fsw/base/fixed_vector.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The product has a layer beyond the first that was not sent.
[[nodiscard]] bool last_layer_can_go(const ProductRecord& product);
/// Nothing of the product was sent.
[[nodiscard]] bool product_can_go(const ProductRecord& product);
/// The worth of the last layer per byte: the product's priority times the gain in dB (PSNR of an image; of a depth map
/// 6 dB per halving of its largest error), or times one if no quality is on record.
[[nodiscard]] double utility_of_last_layer(const ProductRecord& product);

/// Finds the products of least utility in a whole table, in slices of bounded length and with bounded memory. The next
/// search finds those that did not fit.
class VictimSearch {
 public:
  struct Victim {
    std::int64_t product_id = 0;
    double utility = 0;
  };

  void restart();
  /// Examines some more of the products up to `through_id`.
  Status look(Reader<ProductRecord> store, std::int64_t through_id);
  [[nodiscard]] bool complete() const { return complete_; }
  /// Last layers go first, whole products only when the table has no last layer to take.
  [[nodiscard]] bool of_whole_products() const { return !any_layer_; }
  /// Takes the victim of least utility. False: no more.
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
