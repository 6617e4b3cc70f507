// Data of StorageManager that nobody needs any more, or that a full store gives up: depth maps, masks, points.
#pragma once

#include "fsw/storage/storage_part.hpp"

namespace ilp {

class StorageRelease : public StoragePart {
 public:
  using StoragePart::StoragePart;

  Status find_mask(std::int64_t keyframe_id, MaskRecord& mask);
  Status release_depth(Draft& draft);
  Status release_mask(MaskRecord mask, Draft& draft);
  Status release_points(StructureRecord structure, bool held, Draft& draft);
  Status age_points(Draft& draft);
  Status unneeded_before(std::int64_t& keyframe_id);
  /// Releases the oldest points left: old ones according to the history, newer ones too if `full`.
  Status release_oldest_points(bool full, Draft& draft, bool& released);
  Status release_oldest_mask(bool full, Draft& draft, bool& released);
  Status release(Draft& draft);
  Status settle_records(const DownlinkRecord& sent, Draft& draft, bool& settled);
  Status settle_points(const DownlinkRecord& sent, Draft& draft, bool& settled);
};

}  // namespace ilp
