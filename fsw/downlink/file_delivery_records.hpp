// Reads and saves the records of FileDelivery's transfers.
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/downlink/file_delivery_part.hpp"

namespace ilp {

class FileDeliveryRecords : public FileDeliveryPart {
 public:
  using FileDeliveryPart::FileDeliveryPart;

  /// Takes new transfers from the store into free slots.
  Status adopt_new();
  /// Erases a damaged record.
  Status drop_damaged(std::int64_t id);
  /// Reads the record of a transfer. Returns false, and marks the transfer as gone, if it is no longer in the store.
  Result<bool> find(Slot& slot, TransferRecord& record);
  /// Marks the transfer for saving if its progress or phase has changed enough.
  void mark_changes(Slot& slot);
  /// Saves all changes in one transaction. If that fails, saves some of the transfers in one transaction each.
  Status save();

 private:
  Status adopt(const TransferRecord& record);
  Status save_checkpoint_and(std::span<Slot> slots);
  Status save(Slot& slot);
};

}  // namespace ilp
