// Notices a flight that does not end.
#pragma once

#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp::sil {

/// Progress is a new record of any kind but events and housekeeping, or a component's cursor that moves.
class StallGuard {
 public:
  /// `longest`: mission time without progress that is still plausible.
  explicit StallGuard(TimeNs longest) : longest_(longest) {}
  /// Must be called regularly. True if there has been no progress for too long.
  bool stalled(Store& store, TimeNs now);

 private:
  TimeNs longest_;
  std::uint64_t fingerprint_ = 0;
  TimeNs changed_ns_ = -1;
};

}  // namespace ilp::sil
