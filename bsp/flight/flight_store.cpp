#include "bsp/flight/flight_store.hpp"

#include <algorithm>
#include <new>

#include "bsp/flight/flight_software.hpp"
#include "fsw/components/storage_manager.hpp"
#include "hal/store/sqlite/set_aside.hpp"

namespace ilp {
namespace {

// Of a store in memory: the rest is for records without images, and for what a transaction keeps twice.
constexpr double memory_share = 0.5;

Status ended_in_order(Store& store, bool& in_order) {
  StartRecord life;
  const Status found = last(store, life);
  in_order = found.is(StatusCode::not_found) || life.end_ns != 0;
  return found.is(StatusCode::not_found) ? Status{} : found;
}

}  // namespace

Status FlightStore::open_database(const char* path) {
  ILP_TRY(disk_.open(path));
  bool in_order = false;
  Status status = check_checkpoints(disk_, checkpoint_forms());
  if (status.ok()) status = ended_in_order(disk_, in_order);
  if (status.ok() && !in_order) status = disk_.check();
  if (!status.ok()) disk_.close();
  return status;
}

Status FlightStore::begin_anew(const char* path, const Status& fault) {
  std::int64_t number = 0;
  ILP_TRY(set_database_aside(path, number));
  ILP_TRY(open_database(path));
  news_ = {StatusCode::store_set_aside, number, static_cast<std::int64_t>(fault.code)};
  return {};
}

Status FlightStore::begin_in_memory(const Status& fault, MissionParameters& mission) {
  disk_.close();
  ram_ = new (ram_place_) RamStore(memory_);
  in_memory_ = true;
  const double room_mib = memory_share * static_cast<double>(memory_.size()) / 1048576.0;
  mission.storage_budget_mib = std::min(mission.storage_budget_mib, room_mib);
  news_ = {StatusCode::store_in_memory, static_cast<std::int64_t>(fault.code), fault.a};
  return {};
}

Status FlightStore::open(const char* path, StoreTrouble trouble, MissionParameters& mission) {
  Status status = open_database(path);
  const bool unusable =
      status.is(StatusCode::store_damaged) || status.is(StatusCode::store_schema) || status.is(StatusCode::store_build);
  if (trouble == StoreTrouble::fly_on && unusable) status = begin_anew(path, status);
  if (status.ok()) status = disk_.limit(database_limit_bytes(mission));
  if (trouble == StoreTrouble::fly_on && !status.ok()) return begin_in_memory(status, mission);
  return status;
}

void FlightStore::close() {
  disk_.close();
}

}  // namespace ilp
