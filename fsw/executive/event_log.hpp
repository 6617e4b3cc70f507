// Writes event reports to the store. Ids continue from the newest event, whichever process wrote it.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/checksum.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Limits the rate of events. Each pair of component and code has its own allowance: `burst` events are written at
/// once, and then one per `interval_ns` of mission time. Further events are only counted, and their number is reported
/// as `events_repeated`, once per `interval_ns`.
class EventLog {
 public:
  static constexpr std::int64_t burst = 64;
  static constexpr TimeNs interval_ns = 60 * ns_per_s;
  /// Most allowances at the same time. A further one replaces the least used one, so that the first event with a code
  /// is always written.
  static constexpr std::size_t max_allowances = 32;

  explicit EventLog(Store& store) : store_(store) { guard_.seal(state_); }
  /// Writes an event in its own transaction. While another process holds the store's lock, up to 16 events wait.
  /// Further events, or all if the store fails, count as lost; their number is reported once the store takes events
  /// again. `component` must outlive the log.
  void report(TimeNs time, const char* component, const Status& status);
  /// Writes events that wait, the number of lost events, and numbers of counted events that are due (all of them if the
  /// flight `ends`). Call it every few seconds.
  void report_due(TimeNs time, bool ends = false);
  [[nodiscard]] std::uint32_t lost() const { return state_.lost; }

 private:
  struct Allowance {
    char component[24] = {};
    StatusCode code = StatusCode::ok;
    TimeNs used_until_ns = 0;     ///< each written event adds `interval_ns`; in the past: the allowance is unused
    TimeNs counted_since_ns = 0;  ///< time of the first event in `counted`
    std::int64_t counted = 0;     ///< events that were not written and whose number was not reported yet
  };
  static constexpr std::size_t most_waiting = 16;
  struct Waiting {
    TimeNs time_ns = 0;
    const char* component = "";
    Status status;
    const char* place = "";  ///< file of a failed assertion
  };
  struct State {
    FixedVector<Waiting, most_waiting> waiting;  ///< events that wait for the store's lock, in order
    std::uint32_t lost = 0;
    std::uint32_t untold = 0;  ///< lost events whose number was not reported yet
    StatusCode first_untold = StatusCode::ok;
    std::array<Allowance, max_allowances> allowances{};
  };

  Allowance& allowance_of(TimeNs time, const char* component, StatusCode code);
  /// Whether another event may be written. Sets `used_until_ns` to `time` if it is in the past.
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
