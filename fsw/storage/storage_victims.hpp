// Which products give up bytes first when storage is full (decisions.md, 12).
#pragma once

#include "fsw/base/fixed_vector.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// The product has a layer beyond the first that has not gone to the link.
[[nodiscard]] bool last_layer_can_go(const ProductRecord& product);
/// Nothing of the product has gone to the link.
[[nodiscard]] bool product_can_go(const ProductRecord& product);
/// What the last layer adds, per byte: the product's priority times the gain in dB (of an image's PSNR; of a depth map
/// six for every halving of its largest error), or one where no quality is on record.
[[nodiscard]] double worth_of_last_layer(const ProductRecord& product);

/// Finds the least worth of a whole table in pieces of bounded length. Its memory is bounded; what does not fit is
/// found by the next search.
class VictimSearch {
 public:
  struct Victim {
    std::int64_t product_id = 0;
    double worth = 0;
  };

  void restart();
  /// Looks at some more of the products up to `through_id`.
  Status look(Reader<ProductRecord> store, std::int64_t through_id);
  [[nodiscard]] bool complete() const { return complete_; }
  /// Least worth first: last layers, and whole products only when no last layer of the table can go. False: no more.
  bool take(Victim& victim, bool& whole);

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
