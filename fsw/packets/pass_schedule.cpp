#include "fsw/packets/pass_schedule.hpp"

namespace ilp {
namespace {

struct Passes {
  TimeNs period = 0, length = 0, start = 0;
  std::int64_t count = 0;  ///< 0: no end
};

Passes passes_of(const MissionParameters& mission) {
  if (mission.pass_period_s <= 0) return {continuous_window_ns, continuous_window_ns, 0, 0};
  Passes passes;
  passes.period = ns_from_seconds(mission.pass_period_s);
  passes.length = ns_from_seconds(mission.pass_length_s);
  passes.start = ns_from_seconds(mission.pass_start_s);
  passes.count = mission.pass_count;
  if (passes.period < 1) passes.period = 1;
  if (passes.length > passes.period) passes.length = passes.period;
  return passes;
}

/// Rounded down. Before the first pass it is 0 with passes, and negative without passes at times before zero.
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

struct Window {
  TimeNs from = 0, to = 0;
  [[nodiscard]] bool holds(TimeNs now) const { return now >= from && now < to; }
};

Window window_of(double from_s, double to_s) {
  return {ns_from_seconds(from_s), ns_from_seconds(to_s)};
}
Window part_of(const Window& window, TimeNs from, TimeNs to) {
  return {window.from > from ? window.from : from, window.to < to ? window.to : to};
}

Contact scheduled(const Passes& passes, TimeNs now) {
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

/// Contact by the schedule alone.
TimeNs scheduled_between(const Passes& passes, const Window& window) {
  return window.to > window.from ? contact_until(passes, window.to) - contact_until(passes, window.from) : 0;
}

}  // namespace

Contact contact_at(const MissionParameters& mission, TimeNs now) {
  const Passes passes = passes_of(mission);
  const Window opened = window_of(mission.opened_s, mission.opened_until_s);
  const Window closed = window_of(mission.closed_s, mission.closed_until_s);
  const bool is_closed = closed.holds(now);
  Contact contact = scheduled(passes, is_closed ? closed.to : now);
  if (is_closed) contact.open = false;
  if (!opened.holds(now)) return contact;
  if (contact.open) {
    if (contact.end_ns < opened.to) contact.end_ns = opened.to;
    return contact;
  }
  contact.open = true;
  contact.over = false;
  contact.begin_ns = opened.from;
  contact.end_ns = opened.to;
  return contact;
}

TimeNs contact_between(const MissionParameters& mission, TimeNs from, TimeNs to) {
  if (to <= from) return 0;
  const Passes passes = passes_of(mission);
  const Window opened = part_of(window_of(mission.opened_s, mission.opened_until_s), from, to);
  const Window closed = part_of(window_of(mission.closed_s, mission.closed_until_s), from, to);
  TimeNs sum = scheduled_between(passes, {from, to}) - scheduled_between(passes, closed);
  if (opened.to > opened.from) sum += opened.to - opened.from - scheduled_between(passes, opened);
  return sum;
}

void open_contact(TimeNs now, double length_s, MissionParameters& mission) {
  const double now_s = 1e-9 * static_cast<double>(now);
  mission.opened_s = now_s;
  mission.opened_until_s = now_s + length_s;
  if (mission.closed_until_s > now_s) mission.closed_until_s = now_s;
  if (mission.closed_s > mission.closed_until_s) mission.closed_s = mission.closed_until_s;
}

void close_contact(TimeNs now, MissionParameters& mission) {
  const double now_s = 1e-9 * static_cast<double>(now);
  if (mission.opened_until_s > now_s) mission.opened_until_s = now_s;
  if (mission.opened_s > mission.opened_until_s) mission.opened_s = mission.opened_until_s;
  const Passes passes = passes_of(mission);
  const Contact contact = scheduled(passes, now);
  const bool pass = contact.open && mission.pass_period_s > 0;
  const TimeNs next = pass ? contact.begin_ns + passes.period : contact.open ? contact.end_ns : now;
  mission.closed_s = now_s;
  mission.closed_until_s = 1e-9 * static_cast<double>(next);
}

}  // namespace ilp
