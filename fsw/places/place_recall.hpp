// Reads places from the store, after a start or for a comparison, and erases places.
#pragma once

#include "fsw/places/place_part.hpp"

namespace ilp {

class PlaceRecall : public PlacePart {
 public:
  using PlacePart::PlacePart;

  Status newest_place(std::int64_t& id);
  static RememberedPlace entry_of(const PlaceRecord& place);
  void fill_vocabulary(std::size_t through_slot);
  Result<bool> read_features(const PlaceRecord& place);
  /// Reads a place into memory. Returns false if its features cannot be read.
  Result<bool> recall_place(const PlaceRecord& place);
  Status recall();
  Status erase_place(std::int64_t id);
  Result<bool> forget_one();
  Result<bool> load_features(const PlaceRecord& place);
};

}  // namespace ilp
