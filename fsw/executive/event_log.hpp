// Writes event reports to the store, numbered on from those that it holds.
#pragma once

#include "fsw/base/checksum.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp {

class EventLog {
 public:
  explicit EventLog(Store& store) : store_(store) { guard_.seal(state_); }
  /// In a transaction of its own. A fault of the store itself is counted in `lost`, and told as soon as the store
  /// takes events again.
  void report(TimeNs time, const char* component, const Status& status);
  /// Tells of lost events, if there are any that have not been told of.
  void report_lost(TimeNs time);
  [[nodiscard]] std::uint32_t lost() const { return state_.lost; }

 private:
  struct State {
    std::int64_t last_id = 0;
    std::uint32_t lost = 0;
    std::uint32_t untold = 0;  ///< of the lost ones
    StatusCode first_untold = StatusCode::ok;
    bool numbered = false;  ///< the numbering goes on from that of the store
  };

  bool write(TimeNs time, const char* component, const Status& status);
  Status number();
  void check();

  Store& store_;
  State state_;
  Guarded<State> guard_;
};

}  // namespace ilp
