#include "fsw/executive/executive.hpp"

#include <algorithm>

#include "fsw/base/status_values.hpp"
#include "fsw/base/text.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {

static_assert(stage_count <= limits::max_components);

namespace {
/// A long step is remembered for some steps, because the component's next step may be as long.
constexpr TimeNs forget_divisor = 16;

/// A step is cut to about this time on the slowest processor that is meant, 1000 MIPS. Where less of a minor frame is
/// left, no woken component begins a step, however short its latest ones were.
constexpr TimeNs step_reserve_ns = 20 * ns_per_ms;

/// Where several processes share a store, each has the lock for a moment now and then.
constexpr TimeNs shortest_lock_told_ns = ns_per_s;

// Second value of memory_damaged.
constexpr auto from_checkpoint = static_cast<std::int64_t>(MemorySource::checkpoint);
constexpr auto from_copy = static_cast<std::int64_t>(MemorySource::copy);
constexpr auto from_new_process = static_cast<std::int64_t>(MemorySource::new_process);

bool no_waiting_heals(const Status& status) {
  return status.is(StatusCode::store_build) || status.is(StatusCode::store_schema) ||
         status.is(StatusCode::store_damaged);
}
}  // namespace

Executive::Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock,
                     const ExecutiveSetup& setup)
    : stages_(stages), components_(components), store_(store), clock_(clock), events_(store), setup_(setup) {}

Status Executive::start() {
  ILP_ASSERT(stages_.size() == components_.size() && stages_.size() <= own_.slots.size(), stages_.size());
  ILP_ASSERT(!setup_.real_time || setup_.parameters != nullptr, setup_.real_time);
  accept_parameters();
  // A process that shares the flight has a record of its own, of its lowest number; that of the head is the flight's.
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    own_.timing.id = i == 0 ? number_of(i) : std::min(own_.timing.id, number_of(i));
  }
  own_.constants_checksum = checksum64(setup_.constants);
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    Status status;
    restore(i, status);
    if (no_waiting_heals(status)) return status;
    own_.slots[i].wake();
  }
  // After the components: if one of them refuses the store, nothing in it has changed.
  const Status status = take_up();
  seal_own();
  return no_waiting_heals(status) ? status : Status{};
}

/// Every component starts from its checkpoint now, so earlier commands to restart are carried out.
Status Executive::take_up() {
  ILP_TRY(newest_id<CommandRecord>(store_, own_.obeyed_command_id));
  ILP_TRY(take_up_level());
  own_.taken_up = true;
  return {};
}

void Executive::obey_commands() {
  if (!own_.taken_up) return;
  CommandRecord command;
  // Bounded by the commands of one step.
  for (Status found = next(store_, own_.obeyed_command_id, command); found.ok() || found.is(StatusCode::record_damaged);
       found = next(store_, own_.obeyed_command_id, command)) {
    own_.obeyed_command_id = found.ok() ? command.id : found.a;
    if (!found.ok()) continue;
    const std::size_t place = place_of(command.subject_id);
    if (command.kind == CommandKind::restart && place != nobody) restart(place);
  }
}

std::size_t Executive::place_of(std::int64_t number) const {
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (number_of(i) == number) return i;
  }
  return nobody;
}

void Executive::wake() {
  RecordMask changed = 0;
  const Status status = store_.poll(changed);
  if (!status.ok()) events_.report(clock_.now(), "executive", status);
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if ((stages_[i].wakes & changed) != 0) own_.slots[i].wake();
  }
  if ((changed & mask_of(RecordType::command)) != 0) obey_commands();
}

void Executive::hold(Slot& slot) const {
  slot.pause = std::clamp<std::int64_t>(2 * slot.pause, 1, longest_pause_frames);
  slot.hold_frame = own_.frame + slot.pause;
}

/// The step has changed nothing and is repeated. The lock is reported once, when it is free again.
void Executive::wait_for_lock(Slot& slot) {
  slot.wake();
  slot.suspended = true;
  if (!store_locked_) locked_since_ns_ = clock_.now();
  store_locked_ = true;
}

void Executive::look_at_lock() {
  if (!store_locked_) return;
  {
    Transaction transaction(store_);
    if (transaction.begin().is(StatusCode::store_locked)) return;
  }
  store_locked_ = false;
  const TimeNs now = clock_.now();
  const TimeNs taken_ns = now - locked_since_ns_;
  if (taken_ns < shortest_lock_told_ns) {
    events_.report_due(now);
  } else {
    events_.report(now, "executive", {StatusCode::store_locked, taken_ns / ns_per_ms});
  }
}

void Executive::report_own(const Status& status) {
  if (!status.ok() && !status.is(StatusCode::store_locked)) events_.report(clock_.now(), "executive", status);
}

bool Executive::restore(std::size_t i, Status& status) {
  Slot& slot = own_.slots[i];
  if (own_.keeper == i) own_.keeper = nobody;
  status = components_[i]->restore();
  const std::int64_t number = number_of(i);
  const bool waited = slot.activity == Activity::waiting;
  if (!restored(status)) {
    ++slot.attempts;
    if (!waited) {
      events_.report(clock_.now(), components_[i]->name(),
                     {StatusCode::component_waiting, number, static_cast<std::int64_t>(status.code)});
    }
    slot.activity = Activity::waiting;
    hold(slot);
    return false;
  }
  if (!status.ok()) events_.report(clock_.now(), components_[i]->name(), status);
  if (waited) {
    events_.report(clock_.now(), components_[i]->name(), {StatusCode::component_resumed, number, slot.attempts});
    slot.pause = slot.hold_frame = 0;
    // It is not known which inputs it has missed.
    slot.activity = Activity::ready;
  } else if (slot.activity == Activity::stopped) {
    slot.activity = Activity::idle;
  }
  slot.attempts = 0;
  const LastingMemory memory = components_[i]->lasting();
  seal(i, memory, memory.state_checksum());
  return true;
}

void Executive::seal(std::size_t i, const LastingMemory& memory, std::uint64_t state) {
  Slot& slot = own_.slots[i];
  slot.state_checksum = state;
  slot.checksum = memory.checksum(state);
  // Once: the damage stays until the next process.
  if (!slot.sealed) slot.wiring_checksum = memory.wiring_checksum();
  slot.sealed = true;
}

void Executive::restart(std::size_t i) {
  ++own_.slots[i].stats.restarts;
  // A repeated attempt on this input would fail again at once, so it waits for the next minor frame.
  own_.slots[i].suspended = true;
  events_.report(clock_.now(), "executive", {StatusCode::component_restarted, number_of(i)});
  Status status;
  restore(i, status);
}

void Executive::go_back(std::size_t i) {
  events_.report(clock_.now(), components_[i]->name(), {StatusCode::memory_damaged, number_of(i), from_checkpoint});
  restart(i);
  own_.slots[i].wake();
}

bool Executive::sound(std::size_t i, const LastingMemory& memory) {
  Slot& slot = own_.slots[i];
  if (memory.wiring_checksum() != slot.wiring_checksum) {
    // A restore would read its checkpoint through the damaged memory.
    events_.report(clock_.now(), "executive", {StatusCode::memory_damaged, number_of(i), from_new_process});
    restart_wanted_ = slot.suspended = true;
    return false;
  }
  const std::uint64_t state = memory.state_checksum();
  if (state == slot.state_checksum && memory.checksum(state) == slot.checksum) return true;
  go_back(i);
  return false;
}

void Executive::check_own() {
  const GuardFinding finding = own_guard_.check(own_);
  if (finding == GuardFinding::intact) return;
  restart_wanted_ = restart_wanted_ || finding == GuardFinding::lost;
  events_.report(clock_.now(), "executive",
                 {StatusCode::memory_damaged, 0, finding == GuardFinding::mended ? from_copy : from_new_process});
}

void Executive::check_parameters() {
  if (setup_.parameters == nullptr) return;
  const GuardFinding finding = parameters_guard_.check(*setup_.parameters);
  if (finding == GuardFinding::intact) return;
  restart_wanted_ = restart_wanted_ || finding == GuardFinding::lost;
  events_.report(clock_.now(), "parameters",
                 {StatusCode::memory_damaged, 0, finding == GuardFinding::mended ? from_copy : from_new_process});
}

void Executive::check_constants() {
  if (restart_wanted_ || checksum64(setup_.constants) == own_.constants_checksum) return;
  restart_wanted_ = true;
  events_.report(clock_.now(), "executive", {StatusCode::memory_damaged, 0, from_new_process});
}

void Executive::count_step(std::size_t i, TimeNs used_ns) {
  ComponentStats& stats = own_.slots[i].stats;
  ++stats.steps;
  stats.busy_ns += used_ns;
  if (used_ns > stats.longest_ns) stats.longest_ns = used_ns;
  if (used_ns > stages_[i].budget_ns) ++stats.overruns;
}

StepResult Executive::take_step(std::size_t i, const LastingMemory& memory, bool& intact) {
  Slot& slot = own_.slots[i];
  StepStore* const steps = setup_.steps;
  if (steps != nullptr) steps->begin_step(memory, slot.state_checksum);
  const TimeNs begin_ns = clock_.now();
  const TimeNs begin = clock_.processor_time();
  const StepResult result = components_[i]->step();
  count_step(i, clock_.processor_time() - begin);
  slot.expected_ns = std::max(clock_.now() - begin_ns, slot.expected_ns - slot.expected_ns / forget_divisor);
  if (steps != nullptr) steps->end_step();
  const LastingMemory after = components_[i]->lasting();
  const bool watched = steps != nullptr && after.changes_by_commits();
  intact = !watched || !steps->refused();
  // What has not changed keeps its checksum: if a bit has flipped meanwhile, it is found before the next step.
  const bool same = memory.is_at_rest() || (watched && !steps->committed());
  if (intact) seal(i, after, same ? slot.state_checksum : after.state_checksum());
  if (result.set_parameters) accept_parameters();
  check_parameters();
  return result;
}

bool Executive::follow_fault(std::size_t i, const Status& status) {
  Slot& slot = own_.slots[i];
  // A report without severity is no fault.
  if (status_severity(status.code) != Severity::info) ++slot.stats.faults;
  // A fault may be one of many bad inputs, which are processed; an endless series is the component's own.
  if (++slot.faults_in_a_row >= max_faults_in_a_row) slot.suspended = true;
  events_.report(clock_.now(), components_[i]->name(), status);
  const bool bug = status.is(StatusCode::assertion_failed) || status.is(StatusCode::cursor_back);
  if (bug) restart(i);
  if (status.is(StatusCode::store_full)) {
    // Nothing else would wake it: its input does not change while the store is full.
    slot.activity = Activity::full;
    slot.retry_frame = own_.frame + full_store_retry_frames;
  } else if (is_transient(status)) {
    // Its work is not done, and its input does not change because of that.
    if (stages_[i].period == 0 || status.is(StatusCode::store_error)) slot.wake();
    hold(slot);
  }
  return bug;
}

void Executive::follow(std::size_t i, const StepResult& result) {
  Slot& slot = own_.slots[i];
  bool restarted = false;
  if (result.status.ok()) {
    slot.faults_in_a_row = 0;
  } else if (result.status.is(StatusCode::store_locked)) {
    wait_for_lock(slot);
  } else {
    restarted = follow_fault(i, result.status);
  }
  if (!result.status.ok() && result.then == Then::restore && !restarted) {
    Status status;
    restore(i, status);
  }
  if (!is_transient(result.status) && slot.restored()) slot.pause = slot.hold_frame = 0;
}

void Executive::run_step(std::size_t i) {
  check_parameters();
  check_constants();
  const LastingMemory memory = components_[i]->lasting();
  if (!sound(i, memory)) return;
  bool intact = true;
  const StepResult result = take_step(i, memory, intact);
  Slot& slot = own_.slots[i];
  slot.activity = result.pending ? Activity::ready : Activity::idle;
  slot.suspended = slot.suspended || result.then == Then::wait;
  slot.left_out = 0;
  if (stages_[i].step_memory) own_.keeper = result.then == Then::keep && result.pending ? i : nobody;
  if (intact) {
    follow(i, result);
  } else {
    go_back(i);
  }
  wake();
}

bool Executive::fits(std::size_t i, TimeNs reserved, TimeNs deadline) {
  return clock_.now() + std::max(own_.slots[i].expected_ns, step_reserve_ns) + reserved <= deadline;
}

void Executive::run_work(std::size_t i, TimeNs deadline) {
  run_step(i);
  for (std::uint32_t steps = 1; own_.keeper == i && may_run(i) && steps < max_steps_per_frame; ++steps) {
    if (!fits(i, 0, deadline)) break;
    run_step(i);
  }
}

std::size_t Executive::longest_left_out() const {
  if (own_.keeper != nobody && may_run(own_.keeper)) return own_.keeper;
  std::size_t longest = nobody;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (!has_work(i) || own_.slots[i].left_out == 0) continue;
    if (longest == nobody || own_.slots[i].left_out > own_.slots[longest].left_out) longest = i;
  }
  return longest;
}

bool Executive::run_woken(std::size_t i, TimeNs deadline) {
  const TimeNs reserved = first_ == nobody || first_ == i ? 0 : own_.slots[first_].expected_ns;
  const bool its_turn = first_ == i || (first_ == nobody && !woken_ran_);
  if (!its_turn && !fits(i, reserved, deadline)) {
    if (!own_.slots[i].counted) ++own_.slots[i].left_out;
    own_.slots[i].counted = true;
    return false;
  }
  if (first_ == i) first_ = nobody;
  woken_ran_ = true;
  run_work(i, deadline);
  return true;
}

bool Executive::run_awaited(TimeNs deadline, std::uint32_t& steps) {
  bool worked = false;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (!others_wait_for(stages_[i])) continue;
    while (has_work(i) && steps < max_steps_per_frame && run_woken(i, deadline)) {
      ++steps;
      worked = true;
    }
  }
  return worked;
}

void Executive::run_pending(TimeNs deadline) {
  std::uint32_t steps = 0;
  bool worked = true;
  while (worked && steps < max_steps_per_frame && clock_.now() < deadline) {
    worked = false;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (!has_work(i) || is_put_off(i)) continue;
      if (setup_.shares_flight && !others_wait_for(stages_[i]) && run_awaited(deadline, steps)) worked = true;
      if (!may_run(i) || !run_woken(i, deadline)) continue;
      ++steps;
      worked = true;
      if (clock_.now() >= deadline) break;
    }
  }
}

void Executive::end_frame(TimeNs nominal, TimeNs begin) {
  const TimeNs now = clock_.now();
  const TimeNs over = now - (nominal + minor_frame_ns);
  count_frame(begin - nominal, now - begin, over > 0, own_.timing);
  const Status told = own_.overruns.note(own_.frame, over, now);
  if (!told.ok()) events_.report(now, "executive", told);
  ++own_.frame;
  if (!setup_.real_time) return;
  if (leads()) count_load(now, over);
  if (setup_.parameters->housekeeping_period_s <= 0) return;
  if (now - own_.housekeeping_ns < ns_from_seconds(setup_.parameters->housekeeping_period_s)) return;
  own_.housekeeping_ns = now;
  report_own(write_housekeeping());
}

void Executive::count_load(TimeNs now, TimeNs over) {
  if (own_.window.begin_ns == 0) own_.window.begin_ns = now;
  // The work of other processes shows in the backlog only.
  bool busy = setup_.shares_flight;
  // Time-driven components always have work.
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    busy = busy || (stages_[i].period == 0 && has_work(i));
  }
  ++own_.window.frames;
  own_.window.busy_frames += busy ? 1 : 0;
  own_.window.overrun_ns += std::max<TimeNs>(over, 0);
  if (now - own_.window.begin_ns >= ns_from_seconds(setup_.parameters->load_window_s)) judge_load(now);
}

Status Executive::measure_backlog(Backlog& backlog) {
  std::int64_t frame = 0, looked_at = 0, keyframe = 0, rated = 0;
  ILP_TRY(newest_id<FrameRecord>(store_, frame));
  ILP_TRY(newest_id<OverlapRecord>(store_, looked_at));
  ILP_TRY(newest_id<KeyframeRecord>(store_, keyframe));
  ILP_TRY(newest_id<RichnessRecord>(store_, rated));
  backlog.frames = frame - looked_at;
  // This many wait for their final poses in any case.
  backlog.keyframes = keyframe - rated - window_length(*setup_.parameters);
  return {};
}

void Executive::judge_load(TimeNs now) {
  const std::uint8_t before = own_.work_level.level();
  Backlog backlog;
  report_own(measure_backlog(backlog));
  const LoadReason reason = own_.work_level.judge(own_.window, now, backlog, *setup_.parameters);
  own_.window = {};
  own_.window.begin_ns = now;
  const std::uint8_t level = own_.work_level.level();
  if (level == before) return;
  own_.timing.degraded = level;
  ++own_.timing.degraded_changes;
  report_own(write_timing());
  events_.report(now, "executive",
                 level > before ? Status{StatusCode::work_reduced, level, static_cast<std::int64_t>(reason)}
                                : Status{StatusCode::work_restored, level});
}

Status Executive::take_up_level() {
  TimingRecord before;
  const Status found = leads() ? get(store_, own_.timing.id, before) : Status{StatusCode::not_found};
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  if (setup_.real_time) own_.work_level.restore(before.degraded);
  own_.timing.degraded = own_.work_level.level();
  return own_.timing.degraded == before.degraded ? Status{} : write_timing();
}

Status Executive::write_timing() {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, own_.timing));
  return transaction.commit();
}

void Executive::run_minor_frame(TimeNs nominal) {
  check_own();
  const TimeNs begin = clock_.now();
  const TimeNs end = nominal + minor_frame_ns;
  woken_ran_ = false;
  look_at_lock();
  if (!own_.taken_up) static_cast<void>(take_up());
  wake();
  if (own_.frame % full_store_retry_frames == 0) events_.report_due(begin);
  for (std::size_t i = 0; i < stages_.size(); ++i) own_.slots[i].suspended = false;
  first_ = longest_left_out();
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    Slot& slot = own_.slots[i];
    slot.counted = false;
    slot.faults_in_a_row = 0;
    Status status;
    if (!slot.restored() && (own_.frame < slot.hold_frame || !restore(i, status))) continue;
    if (slot.activity == Activity::full && own_.frame >= slot.retry_frame) slot.wake();
    const bool due = stages_[i].period != 0 && own_.frame % stages_[i].period == 0;
    if (due && memory_is_free(i)) {
      run_work(i, end);
    } else if (due) {
      slot.wake();
    } else if (has_work(i) && !is_put_off(i)) {
      run_woken(i, end);
    }
  }
  run_pending(end);
  end_frame(nominal, begin);
  seal_own();
}

bool Executive::idle() const {
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (own_.slots[i].activity != Activity::idle) return false;
  }
  return true;
}

Status Executive::write_housekeeping() {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const ComponentStats& stats = own_.slots[i].stats;
    ComponentRecord record;
    record.id = number_of(i);
    copy_text(record.name, stages_[i].name);
    record.steps = stats.steps;
    record.overruns = stats.overruns;
    record.restarts = stats.restarts;
    record.faults = stats.faults;
    record.busy_ns = stats.busy_ns;
    record.longest_ns = stats.longest_ns;
    ILP_TRY(put(store_, record));
  }
  ILP_TRY(put(store_, own_.timing));
  return transaction.commit();
}

}  // namespace ilp
