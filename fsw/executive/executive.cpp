#include "fsw/executive/executive.hpp"

#include "fsw/base/text.hpp"

namespace ilp {

static_assert(stage_count <= limits::max_components);

Executive::Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock)
    : stages_(stages), components_(components), store_(store), clock_(clock), events_(store) {}

Status Executive::start() {
  ILP_ASSERT(stages_.size() == components_.size() && stages_.size() <= slots_.size(), stages_.size());
  ILP_TRY(events_.restore());
  // Every component starts from its checkpoint now: earlier commands to restart are obeyed.
  CommandRecord newest;
  const Status found = last(store_, newest);
  if (!found.ok() && !found.is(StatusCode::not_found)) return found;
  obeyed_command_id_ = found.ok() ? newest.id : 0;
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    ILP_TRY(components_[i]->restore());
    slots_[i].pending = true;
  }
  return {};
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
  const TimeNs begin = clock_.processor_time();
  const StepResult result = components_[i]->step(deadline);
  const TimeNs used = clock_.processor_time() - begin;

  ComponentStats& stats = slot.stats;
  ++stats.steps;
  stats.busy_ns += used;
  if (used > stats.longest_ns) stats.longest_ns = used;
  if (used > stages_[i].budget_ns) ++stats.overruns;
  slot.pending = result.pending;
  slot.retry_frame = 0;

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

void Executive::run_minor_frame() {
  const TimeNs begin = clock_.now();
  const TimeNs end = begin + minor_frame_ns;
  wake();
  if (frame_ % full_store_retry_frames == 0) events_.report_lost(begin);
  for (std::size_t i = 0; i < stages_.size(); ++i) {
    if (slots_[i].retry_frame != 0 && frame_ >= slots_[i].retry_frame) slots_[i].pending = true;
    slots_[i].suspended = false;
    slots_[i].faults_in_a_row = 0;
    const bool due = stages_[i].period != 0 && frame_ % stages_[i].period == 0;
    if (due || slots_[i].pending) run_step(i, end);
  }

  std::uint32_t steps = 0;
  bool worked = true;
  while (worked && steps < max_steps_per_frame && clock_.now() < end) {
    worked = false;
    for (std::size_t i = 0; i < stages_.size(); ++i) {
      if (!slots_[i].pending || slots_[i].suspended) continue;
      run_step(i, end);
      ++steps;
      worked = true;
      if (clock_.now() >= end) break;
    }
  }
  const TimeNs late = clock_.now() - end;
  if (late > 0) {
    ++frame_overruns_;
    events_.report(clock_.now(), "executive", {StatusCode::frame_overrun, frame_, late / ns_per_us});
  }
  ++frame_;
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
  return transaction.commit();
}

}  // namespace ilp
