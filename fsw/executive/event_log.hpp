// Writes event reports to the store. Their numbers continue those that the store holds, whichever process wrote them.
#pragma once

#include "fsw/base/checksum.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp {

class EventLog {
 public:
  explicit EventLog(Store& store) : store_(store) { guard_.seal(state_); }
  /// Writes in a transaction of its own. While another process has the lock of the store, some events wait for it. If
  /// they are more, or the store itself fails, the event is counted in `lost` and reported as soon as the store takes
  /// events again. `component` outlives the log.
  void report(TimeNs time, const char* component, const Status& status);
  /// Writes the events that wait, and reports lost ones that have not been reported yet.
  void report_lost(TimeNs time);
  [[nodiscard]] std::uint32_t lost() const { return state_.lost; }

 private:
  static constexpr std::size_t most_waiting = 16;
  struct Waiting {
    TimeNs time_ns = 0;
    const char* component = "";
    Status status;
  };
  struct State {
    FixedVector<Waiting, most_waiting> waiting;  ///< for the lock of the store, in order
    std::uint32_t lost = 0;
    std::uint32_t untold = 0;  ///< lost events that have not been reported
    StatusCode first_untold = StatusCode::ok;
  };

  Status write(const Waiting& event);
  void write_waiting();
  void lose(const Status& status);
  Status write(EventRecord& record);
  void check();

  Store& store_;
  State state_;
  Guarded<State> guard_;
};

}  // namespace ilp
