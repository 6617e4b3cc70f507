// Writes event reports to the store. Their numbers continue those that the store holds, whichever process wrote them.
#pragma once

#include "fsw/base/checksum.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp {

class EventLog {
 public:
  explicit EventLog(Store& store) : store_(store) { guard_.seal(state_); }
  /// Writes in a transaction of its own. If the store itself fails, the event is counted in `lost` and reported as soon
  /// as the store takes events again.
  void report(TimeNs time, const char* component, const Status& status);
  /// Reports lost events that have not been reported yet.
  void report_lost(TimeNs time);
  [[nodiscard]] std::uint32_t lost() const { return state_.lost; }

 private:
  struct State {
    std::uint32_t lost = 0;
    std::uint32_t untold = 0;  ///< lost events that have not been reported
    StatusCode first_untold = StatusCode::ok;
  };

  bool write(TimeNs time, const char* component, const Status& status);
  Status write(EventRecord& record);
  void check();

  Store& store_;
  State state_;
  Guarded<State> guard_;
};

}  // namespace ilp
