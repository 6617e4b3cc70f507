// The part of StorageManager that releases depth maps, masks and points: those that are no longer needed, and those
// that a full store abandons.
#pragma once

#include "fsw/storage/storage_part.hpp"

namespace ilp {

class StorageRelease : public StoragePart {
 public:
  using StoragePart::StoragePart;

  /// Reads a mask. If there is none, `mask` is that of the flight without code.
  Status find_mask(std::int64_t keyframe_id, MaskRecord& mask);
  Status release_depth(Draft& draft);
  Status release_mask(MaskRecord mask, Draft& draft);
  Status release_points(StructureRecord structure, bool held, Draft& draft);
  Status age_points(Draft& draft);
  Result<std::int64_t> unneeded_before();
  /// Releases the oldest remaining points, if they are older than the history, or if the store is `full`.
  Result<bool> release_oldest_points(bool full, Draft& draft);
  /// Releases the oldest remaining mask, if it is older than the history, or if the store is `full` and its records
  /// were sent.
  Result<bool> release_oldest_mask(bool full, Draft& draft);
  Status release(Draft& draft);
  Result<bool> finish_records(const DownlinkRecord& sent, Draft& draft);
  Result<bool> finish_points(const DownlinkRecord& sent, Draft& draft);
};

}  // namespace ilp
