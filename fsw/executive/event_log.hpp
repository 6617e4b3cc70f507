// Writes event reports to the store. Their numbers continue those that the store holds, whichever process wrote them.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/checksum.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The limit in time that every event has, by mission time: of what one component reports with one code, `burst` events
/// are written at once, and then one in `interval_ns`. The others are counted, and `events_repeated` says how many they
/// were, once in `interval_ns`. No component and no other code can use up this allowance.
class EventLog {
 public:
  static constexpr std::int64_t burst = 64;
  static constexpr TimeNs interval_ns = 60 * ns_per_s;
  /// Allowances in use at the same time. Beyond them the one that is used least begins again, so that the first event
  /// with a code is written in any case.
  static constexpr std::size_t max_allowances = 32;

  explicit EventLog(Store& store) : store_(store) { guard_.seal(state_); }
  /// Writes in a transaction of its own. While another process has the lock of the store, some events wait for it. If
  /// they are more, or the store itself fails, the event is counted in `lost` and reported as soon as the store takes
  /// events again. `component` outlives the log.
  void report(TimeNs time, const char* component, const Status& status);
  /// Reports what is due: events that wait, lost ones, and the numbers of counted ones, all of them where the flight
  /// `ends`. Call it every few seconds.
  void report_due(TimeNs time, bool ends = false);
  [[nodiscard]] std::uint32_t lost() const { return state_.lost; }

 private:
  struct Allowance {
    char component[24] = {};
    StatusCode code = StatusCode::ok;
    TimeNs used_until_ns = 0;     ///< an event puts it off by `interval_ns`; in the past, nothing is used
    TimeNs counted_since_ns = 0;  ///< the first event that is among `counted`
    std::int64_t counted = 0;     ///< events that were not written and have not been reported
  };
  static constexpr std::size_t most_waiting = 16;
  struct Waiting {
    TimeNs time_ns = 0;
    const char* component = "";
    Status status;
    const char* place = "";  ///< file of a failed assertion
  };
  struct State {
    FixedVector<Waiting, most_waiting> waiting;  ///< for the lock of the store, in order
    std::uint32_t lost = 0;
    std::uint32_t untold = 0;  ///< lost events that have not been reported
    StatusCode first_untold = StatusCode::ok;
    std::array<Allowance, max_allowances> allowances{};
  };

  Allowance& allowance_of(TimeNs time, const char* component, StatusCode code);
  /// Whether another event may be written; `used_until_ns` is not in the past then.
  static bool allows(Allowance& allowance, TimeNs time);
  void report_lost(TimeNs time);
  void report_counted(TimeNs time, Allowance& allowance);
  void write_waiting();
  void lose(StatusCode code, std::int64_t events);
  Status write(const Waiting& event);
  void check();

  Store& store_;
  State state_;
  Guarded<State> guard_;
};

}  // namespace ilp
