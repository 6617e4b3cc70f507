// A view of the store that leaves out damaged records, for housekeeping that must not stop at them.
#pragma once

#include "fsw/base/result.hpp"
#include "hal/store/forwarding_store.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// next() skips damaged records, and last() returns `not_found` if the newest record is damaged. All other calls are
/// passed to the store unchanged.
class ValidStore final : public ForwardingStore {
 public:
  using ForwardingStore::ForwardingStore;

  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    Status found = inner_.next(info, after, record);
    for (int passed = 0; found.is(StatusCode::record_damaged) && passed < most_passed; ++passed) {
      found = inner_.next(info, found.a, record);
    }
    return found;
  }
  Status last(const RecordInfo& info, void* record) override {
    const Status found = inner_.last(info, record);
    return found.is(StatusCode::record_damaged) ? Status{StatusCode::not_found} : found;
  }

 private:
  static constexpr int most_passed = 1000;  ///< most damaged records that one call skips
};

namespace detail {
struct ValidStoreHolder {
  explicit ValidStoreHolder(Store& whole) : valid(whole) {}
  ValidStore valid;
};
}  // namespace detail

/// A StoreView of the same tables without their damaged records.
template <StoreAccess access>
class ValidView : private detail::ValidStoreHolder, public StoreView<access> {
 public:
  explicit ValidView(StoreView<access> whole)
      : detail::ValidStoreHolder(*whole.store_), StoreView<access>(this->valid) {}
  ValidView(const ValidView&) = delete;
  ValidView& operator=(const ValidView&) = delete;
};

/// Reads the first record with an id above `after` from a ValidView. Returns false if there is none.
template <typename Record>
Result<bool> find_next_valid(Reader<Record> store, std::int64_t after, Record& record) {
  const Status status = next(store, after, record);
  if (status.is(StatusCode::not_found)) return false;
  if (!status.ok()) return status;
  return true;
}

}  // namespace ilp
