#include "fsw/components/checkpoint.hpp"

namespace ilp {
namespace {

std::int64_t id_of(const CheckpointForm& form) {
  return static_cast<std::int64_t>(form.component) + 1;
}

bool has_form(const CheckpointRecord& record, const CheckpointForm& form) {
  return record.layout == form.layout && record.state.bytes == form.bytes;
}

Status of_another_build(const CheckpointRecord& record) {
  return {StatusCode::store_build, record.id, record.state.bytes};
}

}  // namespace

Status save_checkpoint(Store& store, const CheckpointForm& form, const Cursor& cursor,
                       std::span<const std::uint8_t> state) {
  ILP_ASSERT(state.size() == form.bytes, state.size());
  CheckpointRecord record;
  record.id = id_of(form);
  record.cursor = cursor.first;
  record.cursor_second = cursor.second;
  record.layout = form.layout;
  record.state.bytes = form.bytes;
  ILP_TRY(put(store, record));
  if (state.empty()) return {};
  return write_blob<CheckpointRecord>(store, "state", record.id, 0, state);
}

Status load_checkpoint(Store& store, const CheckpointForm& form, Cursor& cursor, std::span<std::uint8_t> state) {
  ILP_ASSERT(state.size() == form.bytes, state.size());
  CheckpointRecord record;
  ILP_TRY(get(store, id_of(form), record));
  if (!has_form(record, form)) return of_another_build(record);
  if (!state.empty()) ILP_TRY(read_blob<CheckpointRecord>(store, "state", record.id, 0, state));
  cursor = {record.cursor, record.cursor_second};
  return {};
}

Status check_checkpoints(Store& store, std::span<const CheckpointForm* const> forms) {
  CheckpointRecord record;
  // Bounded by the components.
  while (true) {
    const Status found = next(store, record.id, record);
    if (found.is(StatusCode::not_found)) return {};
    ILP_TRY(found);
    bool known = false, fits = false;
    for (const CheckpointForm* form : forms) {
      if (id_of(*form) != record.id) continue;
      known = true;
      fits = fits || has_form(record, *form);
    }
    if (known && !fits) return of_another_build(record);
  }
}

}  // namespace ilp
