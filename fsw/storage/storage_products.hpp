// The products of StorageManager: which are erased, cut, or sent again.
#pragma once

#include "fsw/storage/storage_part.hpp"

namespace ilp {

class StorageProducts : public StoragePart {
 public:
  using StoragePart::StoragePart;

  Status delete_product(const ProductRecord& product, Draft& draft);
  Status abandon(ProductRecord product, Draft& draft);
  Status abandon_damaged(const ProductRecord& product, Draft& draft);
  Status drop(const ProductRecord& product, Draft& draft);
  /// False where its bytes cannot be read.
  Result<bool> cut_last_layer(ProductRecord product, Draft& draft);
  Status abandon_least(Draft& draft);
  Status find_oldest(Draft& draft);
  Status finish_product(const DownlinkRecord& sent, TimeNs newest_sent_ns, Draft& draft);
  Status send_again(const DownlinkRecord& lost, ProductRecord product, Draft& draft);
  Status sweep(Draft& draft);
};

}  // namespace ilp
