#include "fsw/executive/executive.hpp"

#include <algorithm>

#include "fsw/executive/component_step.hpp"
#include "fsw/executive/minor_frame.hpp"

namespace ilp {

static_assert(stage_count <= limits::max_components);

namespace {

bool no_waiting_heals(const Status& status) {
  return status.is(StatusCode::store_build) || status.is(StatusCode::store_schema) ||
         status.is(StatusCode::store_damaged);
}

}  // namespace

Executive::Executive(std::span<const Stage> stages, std::span<Component* const> components, Store& store, Clock& clock,
                     const ExecutiveSetup& setup)
    : table_{stages, components, store, clock, setup} {}

Status Executive::start() {
  const std::size_t components = table_.stages.size();
  const ExecutiveSetup& setup = table_.setup;
  ILP_ASSERT(components == table_.components.size() && components <= table_.own.slots.size(), components);
  ILP_ASSERT(!setup.real_time || setup.parameters != nullptr, setup.real_time);
  accept_parameters();
  // A process that shares the flight has a record of its own, of its lowest number; that of the primary is the
  // flight's.
  std::int64_t& number = table_.own.timing.id;
  for (std::size_t i = 0; i < components; ++i) {
    number = i == 0 ? table_.number_of(i) : std::min(number, table_.number_of(i));
  }
  table_.own.constants_checksum = checksum64(setup.constants);
  for (std::size_t i = 0; i < components; ++i) {
    const Status status = restore(table_, i);
    if (no_waiting_heals(status)) return status;
    table_.slot(i).wake();
  }
  // After the components: if one of them refuses the store, nothing in it has changed.
  const Status status = take_up(table_);
  seal_own();
  return no_waiting_heals(status) ? status : Status{};
}

void Executive::run_minor_frame(TimeNs nominal) {
  check_own(table_);
  const TimeNs begin = table_.clock.now();
  check_lock(table_);
  if (!table_.own.taken_up) static_cast<void>(take_up(table_));
  wake(table_);
  if (table_.own.frame % full_store_retry_frames == 0) table_.events.report_due(begin);
  run_components(table_, nominal + minor_frame_ns);
  end_frame(table_, nominal, begin);
  seal_own();
}

bool Executive::idle() const {
  for (std::size_t i = 0; i < table_.stages.size(); ++i) {
    if (table_.slot(i).activity != ComponentSlot::Activity::idle) return false;
  }
  return true;
}

}  // namespace ilp
