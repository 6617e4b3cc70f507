#include "bsp/flight/flight_store.hpp"

#include <algorithm>
#include <ctime>
#include <new>

#include "fsw/base/argument.hpp"
#include "hal/store/sqlite/disk_file.hpp"

namespace ilp {
namespace {

// Share of a store in memory for the budget. The rest is for records without images, and for second versions during
// transactions.
constexpr double memory_share = 0.5;

}  // namespace

Status FlightStore::begin_in_memory(const Status& fault, MissionParameters& mission) {
  database_.store().close();
  std::span<std::byte> region = memory_;
  if (!fault.ok()) {
    // Whole pages at its end.
    const std::uintptr_t end = reinterpret_cast<std::uintptr_t>(memory_.data() + memory_.size());
    const std::size_t behind = end % stack_page_bytes;
    region = memory_.first(memory_.size() - behind - disk_probe_stack_bytes);
    look_stack_ = memory_.subspan(region.size(), disk_probe_stack_bytes);
  }
  ram_ = new (ram_place_) RamStore(region);
  in_memory_ = true;
  const double free_mib = memory_share * static_cast<double>(memory_.size()) / 1048576.0;
  mission.storage_budget_mib = std::min(mission.storage_budget_mib, free_mib);
  // Where memory was asked for, nothing has happened.
  if (!fault.ok())
    database_.updates().database = {StatusCode::store_in_memory, static_cast<std::int64_t>(fault.code), fault.a};
  return {};
}

Status FlightStore::open(const char* path, StoreTrouble trouble, MissionParameters& mission, DiskWait* wait) {
  const int attempts = trouble == StoreTrouble::fly_on && wait != nullptr ? start_attempts : 1;
  const auto try_to_open = [&](int attempt) {
    return database_.open(path, trouble, mission, wait,
                          attempt + 1 < attempts ? UnreadableCopy::try_again : UnreadableCopy::quarantine);
  };
  Status status = try_to_open(0);
  for (int attempt = 1; attempt < attempts && may_pass(status); ++attempt) {
    const auto fault = static_cast<std::int64_t>(status.code);
    wait->until_next_attempt(attempt, status);
    status = try_to_open(attempt);
    if (status.ok()) database_.updates().opened_late = {StatusCode::store_opened_late, attempt, fault};
  }
  if (status.is(StatusCode::store_in_use)) return status;
  if (trouble == StoreTrouble::fly_on && !status.ok()) return begin_in_memory(status, mission);
  if (!status.ok()) database_.guard().release();
  return status;
}

Status FlightStore::leave_memory(const char* path, DiskWait* wait) {
  if (!in_memory_) return out_of_range(Argument::store);
  MemoryCopyCounts counts;
  return write_memory_copy(*ram_, path, wait, counts);
}

Status FlightStore::join(const char* path, const MissionParameters& mission) {
  ILP_TAKE(const bool exists, look_for(path));
  return exists ? database_.open_among_others(path, mission, Synchronise::later) : Status{StatusCode::not_found};
}

void FlightStore::wait(std::int32_t milliseconds) {
  // What another process has just taken up is often done within a millisecond, so that the first looks are frequent.
  constexpr timespec short_nap{0, 100'000};
  constexpr timespec nap{0, 1'000'000};
  constexpr int short_naps = 10;
  for (int i = 0; i < short_naps && !database_.store().changed_by_others(); ++i) ::nanosleep(&short_nap, nullptr);
  for (std::int32_t i = 1; i < milliseconds && !database_.store().changed_by_others(); ++i) ::nanosleep(&nap, nullptr);
}

}  // namespace ilp
