// The store as a process sees it that shares the flight: between the stages and the database.
#pragma once

#include "bsp/flight/stage_set.hpp"
#include "cfg/mission.hpp"
#include "fsw/executive/executive.hpp"
#include "hal/store/forwarding_store.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp {

/// Notes which tables others have changed, and whether this process has changed one that wakes a stage anywhere.
/// Parameters that were set by telecommand are followed before the next step: the primary writes them into the store.
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

  /// For a process that is not the primary: from now on `in_force`, which `executive` guards, follows the settings in
  /// the store over the parameters of `file`.
  void follow(const MissionParameters& file, MissionParameters& in_force, Executive& executive);
  /// Transactions so far that can wake a stage of another process.
  [[nodiscard]] std::int64_t waking_commits() const { return waking_commits_; }
  /// Whatever has been read or committed since the previous call is on the disk when it is ok: it may be told to the
  /// ground.
  Status commit_read(StoreSharing& sharing);
  /// True once after each change of one of these tables that poll() has reported.
  bool changed(RecordMask tables);

 private:
  void follow_settings();

  const MissionParameters* file_ = nullptr;
  MissionParameters* in_force_ = nullptr;
  Executive* executive_ = nullptr;
  bool settings_changed_ = false;
  RecordMask written_ = 0;  ///< in the open transaction
  RecordMask updates_ = 0;
  bool has_updates_ = false;  ///< something was read or committed since the latest commit_read()
  std::int64_t waking_commits_ = 0;
};

}  // namespace ilp
