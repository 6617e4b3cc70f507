// Writes event reports to the store.
#pragma once

#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp {

class EventLog {
 public:
  explicit EventLog(Store& store) : store_(store) {}
  /// Continues the numbering of the store.
  Status restore();
  /// In a transaction of its own. A fault of the store itself is counted in `lost`.
  void report(TimeNs time, const char* component, const Status& status);
  [[nodiscard]] std::uint32_t lost() const { return lost_; }

 private:
  Store& store_;
  std::int64_t last_id_ = 0;
  std::uint32_t lost_ = 0;
};

}  // namespace ilp
