// A store as whoever keeps house sees it: what is damaged is passed over, and keeps nobody from the rest.
#pragma once

#include "hal/store/forwarding_store.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// next() leaves damaged records out, last() answers `not_found` where the newest one is damaged. Everything else is as
/// the store behind answers.
class SoundStore final : public ForwardingStore {
 public:
  using ForwardingStore::ForwardingStore;

  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    Status found = behind_.next(info, after, record);
    for (int passed = 0; found.is(StatusCode::record_damaged) && passed < most_passed; ++passed) {
      found = behind_.next(info, found.a, record);
    }
    return found;
  }
  Status last(const RecordInfo& info, void* record) override {
    const Status found = behind_.last(info, record);
    return found.is(StatusCode::record_damaged) ? Status{StatusCode::not_found} : found;
  }

 private:
  static constexpr int most_passed = 1000;  ///< in one call
};

namespace detail {
struct SoundBehind {
  SoundStore sound;
};
}  // namespace detail

/// The same tables as those of a view, without what is damaged in them.
template <StoreAccess access>
class SoundView : private detail::SoundBehind, public StoreView<access> {
 public:
  explicit SoundView(StoreView<access> whole)
      : detail::SoundBehind{SoundStore(*whole.store_)}, StoreView<access>(this->sound) {}
  SoundView(const SoundView&) = delete;
  SoundView& operator=(const SoundView&) = delete;
};

}  // namespace ilp
