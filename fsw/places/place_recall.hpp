// What the memory of places reads of its records, after a start or to compare, and what it forgets.
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
  /// False where its features cannot be read.
  Result<bool> recall_place(const PlaceRecord& place);
  Status recall();
  Status erase_place(std::int64_t id);
  Result<bool> forget_one();
  Result<bool> load_features(const PlaceRecord& place);
};

}  // namespace ilp
