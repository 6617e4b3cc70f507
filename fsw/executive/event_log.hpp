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
  /// In a transaction of its own. A fault of the store itself is counted in `lost`, and told as soon as the store
  /// takes events again.
  void report(TimeNs time, const char* component, const Status& status);
  /// Tells of lost events, if there are any that have not been told of.
  void report_lost(TimeNs time);
  [[nodiscard]] std::uint32_t lost() const { return lost_; }

 private:
  bool write(TimeNs time, const char* component, const Status& status);

  Store& store_;
  std::int64_t last_id_ = 0;
  std::uint32_t lost_ = 0;
  std::uint32_t untold_ = 0;  ///< of the lost ones
  StatusCode first_untold_ = StatusCode::ok;
};

}  // namespace ilp
