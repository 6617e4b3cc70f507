// A store that is full when a test says so.
#pragma once

#include "hal/store/forwarding_store.hpp"

namespace ilp::test {

/// Takes no record while it is full.
class RefusingStore final : public ForwardingStore {
 public:
  using ForwardingStore::ForwardingStore;
  Status put(const RecordInfo& info, const void* record) override {
    return full ? Status{StatusCode::store_full} : ForwardingStore::put(info, record);
  }
  bool full = false;
};

}  // namespace ilp::test
