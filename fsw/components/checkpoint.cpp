#include "fsw/components/checkpoint.hpp"

namespace ilp {

Status save_checkpoint(Store& store, ComponentId component, const Cursor& cursor, std::uint32_t layout,
                       std::span<const std::uint8_t> state) {
  CheckpointRecord record;
  record.id = static_cast<std::int64_t>(component) + 1;
  record.cursor = cursor.first;
  record.cursor_second = cursor.second;
  record.layout = layout;
  record.state.bytes = static_cast<std::uint32_t>(state.size());
  ILP_TRY(put(store, record));
  if (state.empty()) return {};
  return write_blob<CheckpointRecord>(store, "state", record.id, 0, state);
}

Status load_checkpoint(Store& store, ComponentId component, Cursor& cursor, std::uint32_t layout,
                       std::span<std::uint8_t> state) {
  CheckpointRecord record;
  ILP_TRY(get(store, static_cast<std::int64_t>(component) + 1, record));
  if (record.layout != layout || record.state.bytes != state.size()) return StatusCode::not_found;
  if (!state.empty()) ILP_TRY(read_blob<CheckpointRecord>(store, "state", record.id, 0, state));
  cursor = {record.cursor, record.cursor_second};
  return {};
}

}  // namespace ilp
