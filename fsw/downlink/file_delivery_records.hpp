// The transfers of FileDelivery and their records.
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/downlink/file_delivery_part.hpp"

namespace ilp {

class FileDeliveryRecords : public FileDeliveryPart {
 public:
  using FileDeliveryPart::FileDeliveryPart;

  Status adopt_new();
  Status drop_damaged(std::int64_t id);
  /// A transfer that is no longer in the store is marked as gone.
  Result<bool> find(Slot& slot, TransferRecord& record);
  void mark_changes(Slot& slot);
  /// Saves in one transaction. If that fails, saves some of the transfers in one transaction each.
  Status save();

 private:
  Status adopt(const TransferRecord& record);
  Status save_checkpoint_and(std::span<Slot> slots);
  Status save(Slot& slot);
};

}  // namespace ilp
