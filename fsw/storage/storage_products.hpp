// The part of StorageManager that erases products, cuts their layers, or lets them be sent again.
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
  /// Cuts off the last layer of a product. Returns false if the product's bytes cannot be read.
  Result<bool> cut_last_layer(ProductRecord product, Draft& draft);
  Status abandon_least(Draft& draft);
  Status find_oldest(Draft& draft);
  Status finish_product(const DownlinkRecord& sent, TimeNs newest_sent_ns, Draft& draft);
  Status send_again(const DownlinkRecord& lost, ProductRecord product, Draft& draft);
  Status sweep(Draft& draft);
};

}  // namespace ilp
