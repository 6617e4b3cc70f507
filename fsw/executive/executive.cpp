#include "fsw/executive/executive.hpp"

#include <algorithm>

#include "fsw/base/text.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {

static_assert(stage_count <= limits::max_components);

namespace {
/// A long step is remembered for some steps: what a component does next may be as long.
constexpr TimeNs forget_divisor = 16;
}  // namespace

Executive::Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock)
    : stages_(stages), components_(components), store_(store), clock_(clock), events_(store) {}

Status Executive::start() {
  ILP_ASSERT(stages_.size() == components_.size() && stages_.size() <= slots_.size(), stages_.size());
  ILP_TRY(events_.restore());
  // Every component starts from its checkpoint now: earlier commands to restart are obeyed.
  ILP_TRY(newest_id<CommandRecord>(store_, obeyed_command_id_));
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    ILP_TRY(components_[i]->restore());
    slots_[i].pending = true;
  }
  // Behind the components: where one of them refuses the store, nothing in it has changed.
  return take_up_level();
}

void Executive::obey_commands() {
  CommandRecord command;
  // Bounded by the commands of one step.
  while (next(store_, obeyed_command_id_, command).ok()) {
    obeyed_command_id_ = command.id;
    const bool known = command.subject_id >= 1 && command.subject_id <= static_cast<std::int64_t>(stages_.size());
    if (command.kind == CommandKind::restart && known) restart(static_cast<std::size_t>(command.subject_id - 1));
  }
}

void Executive::wake() {
  RecordMask changed = 0;
  const Status status = store_.poll(changed);
  if (!status.ok()) events_.report(clock_.now(), "executive", status);
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if ((stages_[i].reads & changed) != 0) slots_[i].pending = true;
  }
  if ((changed & mask_of(RecordType::command)) != 0) obey_commands();
}

void Executive::wait_for_store(Slot& slot) const {
  // Nothing else may ever wake it: what it reads does not change while the store is full.
  slot.pending = false;
  slot.retry_frame = frame_ + full_store_retry_frames;
}

void Executive::restart(std::size_t i) {
  ++slots_[i].stats.restarts;
  // What failed once on this input would fail again at once: it has to wait for the next minor frame.
  slots_[i].suspended = true;
  events_.report(clock_.now(), "executive", {StatusCode::component_restarted, static_cast<std::int64_t>(i) + 1});
  const Status status = components_[i]->restore();
  if (!status.ok()) events_.report(clock_.now(), components_[i]->name(), status);
}

void Executive::run_step(std::size_t i, TimeNs deadline) {
  Slot& slot = slots_[i];
  const TimeNs begin_ns = clock_.now();
  const TimeNs begin = clock_.processor_time();
  const StepResult result = components_[i]->step(deadline);
  const TimeNs used = clock_.processor_time() - begin;
  slot.expected_ns = std::max(clock_.now() - begin_ns, slot.expected_ns - slot.expected_ns / forget_divisor);

  ComponentStats& stats = slot.stats;
  ++stats.steps;
  stats.busy_ns += used;
  if (used > stats.longest_ns) stats.longest_ns = used;
  if (used > stages_[i].budget_ns) ++stats.overruns;
  slot.pending = result.pending;
  slot.retry_frame = 0;
  slot.left_out = 0;

  if (result.status.ok()) {
    slot.faults_in_a_row = 0;
  } else {
    // What is only worth knowing is no fault.
    if (status_severity(result.status.code) != Severity::info) ++stats.faults;
    // A fault may be one of many bad inputs, which are worked through; without an end it is the component's own.
    if (++slot.faults_in_a_row >= max_faults_in_a_row) slot.suspended = true;
    events_.report(clock_.now(), components_[i]->name(), result.status);
    if (result.status.is(StatusCode::assertion_failed)) restart(i);
    if (result.status.is(StatusCode::store_full)) wait_for_store(slot);
  }
  wake();
}

std::size_t Executive::longest_left_out() const {
  std::size_t longest = nobody;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (!slots_[i].pending || slots_[i].left_out == 0) continue;
    if (longest == nobody || slots_[i].left_out > slots_[longest].left_out) longest = i;
  }
  return longest;
}

bool Executive::run_woken(std::size_t i, TimeNs deadline) {
  const TimeNs reserved = first_ == nobody || first_ == i ? 0 : slots_[first_].expected_ns;
  const bool fits = clock_.now() + slots_[i].expected_ns + reserved <= deadline;
  const bool its_turn = first_ == i || (first_ == nobody && !woken_ran_);
  if (!fits && !its_turn) {
    if (!slots_[i].counted) ++slots_[i].left_out;
    slots_[i].counted = true;
    return false;
  }
  if (first_ == i) first_ = nobody;
  woken_ran_ = true;
  run_step(i, deadline);
  return true;
}

void Executive::run_pending(TimeNs deadline) {
  std::uint32_t steps = 0;
  bool worked = true;
  while (worked && steps < max_steps_per_frame && clock_.now() < deadline) {
    worked = false;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (!slots_[i].pending || slots_[i].suspended || !run_woken(i, deadline)) continue;
      ++steps;
      worked = true;
      if (clock_.now() >= deadline) break;
    }
  }
}

void Executive::end_frame(TimeNs nominal, TimeNs begin) {
  const TimeNs now = clock_.now();
  const TimeNs over = now - (nominal + minor_frame_ns);
  count_frame(begin - nominal, now - begin, over > 0, timing_);
  const Status told = overruns_.note(frame_, over, now);
  if (!told.ok()) events_.report(now, "executive", told);
  ++frame_;
  if (mission_ == nullptr) return;
  count_load(now, over);
  if (mission_->housekeeping_period_s <= 0) return;
  if (now - housekeeping_ns_ < ns_from_seconds(mission_->housekeeping_period_s)) return;
  housekeeping_ns_ = now;
  const Status written = write_housekeeping();
  if (!written.ok()) events_.report(now, "executive", written);
}

void Executive::count_load(TimeNs now, TimeNs over) {
  if (window_.begin_ns == 0) window_.begin_ns = now;
  bool busy = false;
  // Time-driven components have always something to do.
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    busy = busy || (stages_[i].period == 0 && slots_[i].pending && !slots_[i].suspended);
  }
  ++window_.frames;
  window_.busy_frames += busy ? 1 : 0;
  window_.overrun_ns += std::max<TimeNs>(over, 0);
  if (now - window_.begin_ns >= ns_from_seconds(mission_->load_window_s)) judge_load(now);
}

Status Executive::measure_backlog(Backlog& backlog) {
  std::int64_t frame = 0, looked_at = 0, keyframe = 0, rated = 0;
  ILP_TRY(newest_id<FrameRecord>(store_, frame));
  ILP_TRY(newest_id<OverlapRecord>(store_, looked_at));
  ILP_TRY(newest_id<KeyframeRecord>(store_, keyframe));
  ILP_TRY(newest_id<RichnessRecord>(store_, rated));
  backlog.frames = frame - looked_at;
  // So many wait for their final poses in any case.
  backlog.keyframes = keyframe - rated - window_length(*mission_);
  return {};
}

void Executive::judge_load(TimeNs now) {
  const std::uint8_t before = work_level_.level();
  Backlog backlog;
  Status status = measure_backlog(backlog);
  if (!status.ok()) events_.report(now, "executive", status);
  const LoadReason reason = work_level_.judge(window_, now, backlog, *mission_);
  window_ = {};
  window_.begin_ns = now;
  const std::uint8_t level = work_level_.level();
  if (level == before) return;
  timing_.degraded = level;
  ++timing_.degraded_changes;
  status = write_timing();
  if (!status.ok()) events_.report(now, "executive", status);
  events_.report(now, "executive",
                 level > before ? Status{StatusCode::work_reduced, level, static_cast<std::int64_t>(reason)}
                                : Status{StatusCode::work_restored, level});
}

Status Executive::take_up_level() {
  TimingRecord before;
  const Status found = get(store_, before.id, before);
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  if (mission_ != nullptr) work_level_.restore(before.degraded);
  timing_.degraded = work_level_.level();
  return timing_.degraded == before.degraded ? Status{} : write_timing();
}

Status Executive::write_timing() {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store_, timing_));
  return transaction.commit();
}

void Executive::run_minor_frame(TimeNs nominal) {
  const TimeNs begin = clock_.now();
  const TimeNs end = nominal + minor_frame_ns;
  woken_ran_ = false;
  wake();
  if (frame_ % full_store_retry_frames == 0) events_.report_lost(begin);
  first_ = longest_left_out();
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (slots_[i].retry_frame != 0 && frame_ >= slots_[i].retry_frame) slots_[i].pending = true;
    slots_[i].suspended = false;
    slots_[i].counted = false;
    slots_[i].faults_in_a_row = 0;
    const bool due = stages_[i].period != 0 && frame_ % stages_[i].period == 0;
    if (due) {
      run_step(i, end);
    } else if (slots_[i].pending) {
      run_woken(i, end);
    }
  }
  run_pending(end);
  end_frame(nominal, begin);
}

bool Executive::idle() const {
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (slots_[i].pending || slots_[i].retry_frame != 0) return false;
  }
  return true;
}

Status Executive::write_housekeeping() {
  Transaction transaction(store_);
  ILP_TRY(transaction.begin());
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    const ComponentStats& stats = slots_[i].stats;
    ComponentRecord record;
    record.id = static_cast<std::int64_t>(i) + 1;
    copy_text(record.name, stages_[i].name);
    record.steps = stats.steps;
    record.overruns = stats.overruns;
    record.restarts = stats.restarts;
    record.faults = stats.faults;
    record.busy_ns = stats.busy_ns;
    record.longest_ns = stats.longest_ns;
    ILP_TRY(put(store_, record));
  }
  ILP_TRY(put(store_, timing_));
  return transaction.commit();
}

}  // namespace ilp
