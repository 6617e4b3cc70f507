// A store between the stages and the database of a process that shares the flight. It notes changes of other processes
// and commits that may give them work.
#pragma once

#include "bsp/flight/stage_set.hpp"
#include "cfg/mission.hpp"
#include "fsw/executive/executive.hpp"
#include "hal/store/forwarding_store.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp {

/// Notes which tables have changed, and counts the commits that can wake a stage of another process. Parameters that
/// the primary has set by telecommand and written into the store take effect before the next step.
class SharedFlightStore final : public ForwardingStore {
 public:
  explicit SharedFlightStore(Store& inner) : ForwardingStore(inner) {}

  Status begin() override;
  Status commit() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status get(const RecordInfo& info, std::int64_t id, void* record) override;
  Status next(const RecordInfo& info, std::int64_t after, void* record) override;
  Status last(const RecordInfo& info, void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status count(const RecordInfo& info, std::int64_t& records) override;
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override;
  Status poll(RecordMask& changed) override;

  /// For a process that is not the primary: keeps `in_force` equal to the parameters of `file` with the settings in the
  /// store from now on. `executive` guards `in_force`. All three outlive the store.
  void follow(const MissionParameters& file, MissionParameters& in_force, Executive& executive);
  /// Number of commits that can wake a stage of another process.
  [[nodiscard]] std::int64_t waking_commits() const { return waking_commits_; }
  /// Waits until everything that was read or committed since the previous call is on the disk. If it returns ok, these
  /// data may be sent to the ground.
  Status commit_read(StoreSharing& sharing);
  /// Returns true once after each change of one of these tables that poll() has reported.
  bool changed(RecordMask tables);

 private:
  /// Sets `in_force_` by the settings in the store.
  void follow_settings();

  const MissionParameters* file_ = nullptr;
  MissionParameters* in_force_ = nullptr;
  Executive* executive_ = nullptr;
  bool settings_changed_ = false;
  RecordMask written_ = 0;    ///< tables that the open transaction has changed
  RecordMask updates_ = 0;    ///< tables that poll() has reported, for changed()
  bool has_updates_ = false;  ///< something was read or committed since the latest commit_read()
  std::int64_t waking_commits_ = 0;
};

}  // namespace ilp
