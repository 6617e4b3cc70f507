// Data of StorageManager that nobody needs any more, or that a full store abandons: depth maps, masks, points.
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
  Result<std::int64_t> unneeded_before();
  /// Releases the oldest points left: old ones according to the history, newer ones too if `full`.
  Result<bool> release_oldest_points(bool full, Draft& draft);
  Result<bool> release_oldest_mask(bool full, Draft& draft);
  Status release(Draft& draft);
  Result<bool> finish_records(const DownlinkRecord& sent, Draft& draft);
  Result<bool> finish_points(const DownlinkRecord& sent, Draft& draft);
};

}  // namespace ilp
