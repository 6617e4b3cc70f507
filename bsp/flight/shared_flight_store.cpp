#include "bsp/flight/shared_flight_store.hpp"

#include "fsw/commanding/settings.hpp"

namespace ilp {
namespace {

constexpr RecordMask waking_tables = [] {
  RecordMask tables = 0;
  for (const Stage& stage : schedule) {
    if (stage.runs_on == RunsOn::any) tables |= stage.wakes;
  }
  return tables;
}();

}  // namespace

Status SharedFlightStore::begin() {
  written_ = 0;
  return inner_.begin();
}

Status SharedFlightStore::commit() {
  ILP_TRY(inner_.commit());
  has_updates_ = true;
  if ((written_ & waking_tables) != 0) ++waking_commits_;
  return {};
}

Status SharedFlightStore::put(const RecordInfo& info, const void* record) {
  written_ |= mask_of(info.type);
  return inner_.put(info, record);
}

Status SharedFlightStore::get(const RecordInfo& info, std::int64_t id, void* record) {
  has_updates_ = true;
  return inner_.get(info, id, record);
}

Status SharedFlightStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  has_updates_ = true;
  return inner_.next(info, after, record);
}

Status SharedFlightStore::last(const RecordInfo& info, void* record) {
  has_updates_ = true;
  return inner_.last(info, record);
}

Status SharedFlightStore::count(const RecordInfo& info, std::int64_t& records) {
  has_updates_ = true;
  return inner_.count(info, records);
}

Status SharedFlightStore::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                    std::span<std::uint8_t> bytes) {
  has_updates_ = true;
  return inner_.read_blob(info, field, id, offset, bytes);
}

Status SharedFlightStore::commit_read(StoreSharing& sharing) {
  if (!has_updates_) return {};
  ILP_TRY(sharing.flush());
  has_updates_ = false;
  return {};
}

Status SharedFlightStore::erase(const RecordInfo& info, std::int64_t id) {
  written_ |= mask_of(info.type);
  return inner_.erase(info, id);
}

Status SharedFlightStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                                     std::span<const std::uint8_t> bytes) {
  written_ |= mask_of(info.type);
  return inner_.write_blob(info, field, id, offset, bytes);
}

Status SharedFlightStore::poll(RecordMask& changed) {
  ILP_TRY(inner_.poll(changed));
  updates_ |= changed;
  settings_changed_ = settings_changed_ || (changed & mask_of(RecordType::setting)) != 0;
  if (settings_changed_ && executive_ != nullptr) follow_settings();
  return {};
}

bool SharedFlightStore::changed(RecordMask tables) {
  const bool any = (updates_ & tables) != 0;
  updates_ &= ~tables;
  return any;
}

void SharedFlightStore::follow(const MissionParameters& file, MissionParameters& in_force, Executive& executive) {
  file_ = &file;
  in_force_ = &in_force;
  executive_ = &executive;
  settings_changed_ = true;
}

/// Parameters that act at the next start are those of this process' start.
void SharedFlightStore::follow_settings() {
  MissionParameters wanted = *file_;
  const Status loaded = load_settings(inner_, wanted);
  settings_changed_ = !loaded.ok() && !loaded.is(StatusCode::setting_ignored);
  if (settings_changed_) return;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    if (parameter_info(i).acts != Acts::at_once) continue;
    static_cast<void>(set_parameter(*in_force_, i, parameter_value(wanted, i)));
  }
  executive_->accept_parameters();
}

}  // namespace ilp
