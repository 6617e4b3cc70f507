#include "fsw/executive/minor_frame.hpp"

#include <algorithm>

#include "fsw/executive/component_step.hpp"

namespace ilp {
namespace {

/// A step is cut to about this time on the slowest processor that is meant, 1000 MIPS. Where less of a minor frame is
/// left, no woken component begins a step, however short its latest ones were.
constexpr TimeNs step_reserve_ns = 20 * ns_per_ms;

constexpr std::size_t nobody = ComponentTable::nobody;

struct Frame {
  ComponentTable& table;
  TimeNs end;
  std::size_t first;       ///< has waited for longest to fit into a frame: it runs in this one
  bool woken_ran = false;  ///< in this frame
  std::uint32_t pending_steps = 0;
};

std::size_t longest_left_out(const ComponentTable& table) {
  if (table.own.keeper != nobody && table.may_run(table.own.keeper)) return table.own.keeper;
  std::size_t longest = nobody;
  for (std::size_t i = 0; i < table.stages.size(); ++i) {
    if (!table.has_work(i) || table.slot(i).left_out == 0) continue;
    if (longest == nobody || table.slot(i).left_out > table.slot(longest).left_out) longest = i;
  }
  return longest;
}

/// Whether its next step is expected to end before the frame, with `reserved` to spare.
bool fits(const Frame& frame, std::size_t i, TimeNs reserved) {
  const ComponentTable& table = frame.table;
  return table.clock.now() + std::max(table.slot(i).expected_ns, step_reserve_ns) + reserved <= frame.end;
}

/// Runs a step, and the next ones while it keeps the shared memory and they fit.
void run_work(Frame& frame, std::size_t i) {
  ComponentTable& table = frame.table;
  run_step(table, i);
  for (std::uint32_t steps = 1; table.own.keeper == i && table.may_run(i) && steps < max_steps_per_frame; ++steps) {
    if (!fits(frame, i, 0)) break;
    run_step(table, i);
  }
}

/// Runs a woken component if it fits, has waited for longest, or is the first of its frame.
bool run_woken(Frame& frame, std::size_t i) {
  ComponentTable& table = frame.table;
  const TimeNs reserved = frame.first == nobody || frame.first == i ? 0 : table.slot(frame.first).expected_ns;
  const bool its_turn = frame.first == i || (frame.first == nobody && !frame.woken_ran);
  if (!its_turn && !fits(frame, i, reserved)) {
    if (!table.slot(i).counted) ++table.slot(i).left_out;
    table.slot(i).counted = true;
    return false;
  }
  if (frame.first == i) frame.first = nobody;
  frame.woken_ran = true;
  run_work(frame, i);
  return true;
}

/// Steps the stages that others wait for as long as they have work that fits. Returns whether there was any.
bool run_awaited(Frame& frame) {
  ComponentTable& table = frame.table;
  bool worked = false;
  for (std::size_t i = 0; i < table.stages.size(); ++i) {
    if (!others_wait_for(table.stages[i])) continue;
    while (table.has_work(i) && frame.pending_steps < max_steps_per_frame && run_woken(frame, i)) {
      ++frame.pending_steps;
      worked = true;
    }
  }
  return worked;
}

void run_pending(Frame& frame) {
  ComponentTable& table = frame.table;
  bool worked = true;
  while (worked && frame.pending_steps < max_steps_per_frame && table.clock.now() < frame.end) {
    worked = false;
    for (std::size_t i = 0; i < table.stages.size(); ++i) {
      if (!table.has_work(i) || table.is_put_off(i)) continue;
      if (table.setup.shares_flight && !others_wait_for(table.stages[i]) && run_awaited(frame)) worked = true;
      if (!table.may_run(i) || !run_woken(frame, i)) continue;
      ++frame.pending_steps;
      worked = true;
      if (table.clock.now() >= frame.end) break;
    }
  }
}

}  // namespace

void run_components(ComponentTable& table, TimeNs end) {
  for (std::size_t i = 0; i < table.stages.size(); ++i) table.slot(i).suspended = false;
  Frame frame{table, end, longest_left_out(table)};
  for (std::size_t i = 0; i < table.stages.size(); ++i) {
    ComponentSlot& slot = table.slot(i);
    slot.counted = false;
    slot.faults_in_a_row = 0;
    if (!slot.restored() && (table.own.frame < slot.hold_frame || !restored(restore(table, i)))) continue;
    if (slot.activity == ComponentSlot::Activity::full && table.own.frame >= slot.retry_frame) slot.wake();
    const bool due = table.stages[i].period != 0 && table.own.frame % table.stages[i].period == 0;
    if (due && table.memory_is_free(i)) {
      run_work(frame, i);
    } else if (due) {
      slot.wake();
    } else if (table.has_work(i) && !table.is_put_off(i)) {
      run_woken(frame, i);
    }
  }
  run_pending(frame);
}

}  // namespace ilp
