#include "fsw/link/pass_schedule.hpp"

namespace ilp {
namespace {

constexpr double ns_in_a_second = 1e9;

struct Passes {
  TimeNs period = 0, length = 0, start = 0;
  std::int64_t count = 0;  ///< 0: no end
};

Passes passes_of(const MissionParameters& mission) {
  if (mission.pass_period_s <= 0) return {continuous_window_ns, continuous_window_ns, 0, 0};
  Passes passes;
  passes.period = static_cast<TimeNs>(mission.pass_period_s * ns_in_a_second);
  passes.length = static_cast<TimeNs>(mission.pass_length_s * ns_in_a_second);
  passes.start = static_cast<TimeNs>(mission.pass_start_s * ns_in_a_second);
  passes.count = static_cast<std::int64_t>(mission.pass_count);
  if (passes.period < 1) passes.period = 1;
  if (passes.length > passes.period) passes.length = passes.period;
  return passes;
}

/// Rounded down; before the first pass 0 with passes, and negative for times before zero without.
std::int64_t pass_number(const Passes& passes, TimeNs now) {
  const TimeNs since = now - passes.start;
  return since < 0 ? 0 : since / passes.period;
}

/// Contact from the first pass's start to `now`.
TimeNs contact_until(const Passes& passes, TimeNs now) {
  if (now <= passes.start) return 0;
  const std::int64_t number = pass_number(passes, now);
  if (passes.count > 0 && number >= passes.count) return passes.count * passes.length;
  const TimeNs within = now - passes.start - number * passes.period;
  return number * passes.length + (within < passes.length ? within : passes.length);
}

}  // namespace

Contact contact_at(const MissionParameters& mission, TimeNs now) {
  const Passes passes = passes_of(mission);
  Contact contact;
  contact.pass = pass_number(passes, now);
  contact.begin_ns = passes.start + contact.pass * passes.period;
  if (now >= contact.begin_ns + passes.length) {
    ++contact.pass;
    contact.begin_ns += passes.period;
  }
  contact.end_ns = contact.begin_ns + passes.length;
  contact.over = passes.count > 0 && contact.pass >= passes.count;
  contact.open = now >= contact.begin_ns && !contact.over;
  return contact;
}

TimeNs contact_between(const MissionParameters& mission, TimeNs from, TimeNs to) {
  if (to <= from) return 0;
  const Passes passes = passes_of(mission);
  return contact_until(passes, to) - contact_until(passes, from);
}

}  // namespace ilp
