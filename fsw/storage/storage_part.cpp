#include "fsw/storage/storage_part.hpp"

#include "fsw/storage/storage_manager.hpp"

namespace ilp {

double StoragePart::share(double part) const {
  return part * wiring_.mission.storage_budget_mib * 1048576.0;
}

std::int64_t StoragePart::held_bytes(const StorageRecord& account) const {
  return account.frame_bytes + account.depth_bytes + account.structure_bytes + account.product_bytes +
         work_.place_bytes;
}

bool StoragePart::products_above(const Draft& draft, double watermark) const {
  const StorageRecord& account = draft.after.account;
  const std::int64_t used = draft.usage.bytes - draft.usage.free_bytes;
  const std::int64_t capacity =
      draft.usage.limit_bytes > 0 ? draft.usage.limit_bytes : database_limit_bytes(wiring_.mission);
  return static_cast<double>(held_bytes(account)) > watermark * share(1) ||
         static_cast<double>(account.product_bytes) > watermark * share(wiring_.mission.product_share) ||
         static_cast<double>(used) > watermark * static_cast<double>(capacity);
}

}  // namespace ilp
