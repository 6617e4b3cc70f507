// A flight without an end in short: storage manager, downlink, executive and store are the flight's own; what takes and
// processes images is a stub that writes the same records, with images of 64 x 64 pixels and products coded beforehand.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "cfg/mission.hpp"
#include "fsw/downlink/downlink.hpp"
#include "fsw/executive/executive.hpp"
#include "fsw/storage/storage_manager.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/link.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp::test {

/// The ground: loses files, damages files, and confirms the others some time later.
class LossyGround final : public Link {
 public:
  LossyGround(Clock& clock, double lost_share, double damaged_share)
      : clock_(clock), lost_share_(lost_share), damaged_share_(damaged_share) {}

  Status begin_file(const char* name) override;
  Status write(std::span<const std::uint8_t> bytes) override;
  Status end_file() override;
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override;

  /// Whether a file of this product was confirmed.
  [[nodiscard]] bool confirmed(std::int64_t product_id) const { return confirmed_.contains(product_id); }
  [[nodiscard]] std::int64_t files() const { return files_; }
  [[nodiscard]] std::int64_t bytes() const { return bytes_; }
  bool contact = true;

 private:
  struct File {
    std::uint32_t bytes = 0, crc32 = 0;
    TimeNs reports_ns = 0;
  };
  Clock& clock_;
  double lost_share_, damaged_share_;
  std::string name_;
  File open_;
  std::map<std::string, File> held_;
  std::set<std::int64_t> confirmed_;
  std::int64_t files_ = 0, bytes_ = 0;
};

/// Camera, overlap checker, motion, depth, richness and compressor: one keyframe every two seconds, frames between
/// them, a strip every 40 keyframes, poses final five keyframes later. Takes its work up again after a restart.
class StubStages final : public Component {
 public:
  StubStages(Store& store, Clock& clock, std::int64_t keyframes);

  [[nodiscard]] const char* name() const override { return "stub_stages"; }
  Status restore() override;
  StepResult step() override;
  [[nodiscard]] std::int64_t keyframes() const { return state_.keyframe; }

 private:
  struct State {
    std::int64_t keyframe = 0, frame = 0, coded = 0;
    TimeNs next_ns = 0;
  };
  static const CheckpointForm form;
  struct Coded {
    ProductRecord record;
    std::vector<std::uint8_t> file;
  };
  Status take_frames(State& after);
  Status begin_keyframe(State& after);
  Status finish_keyframe(std::int64_t id);
  Status make_product(std::int64_t keyframe_id, ProductKind kind);

  Store& store_;
  Clock& clock_;
  std::int64_t keyframes_;
  State state_;
  std::vector<Coded> coded_;
};

struct EndlessOptions {
  std::int64_t keyframes = 500;
  double lost_share = 0.02, damaged_share = 0.01;
  /// Contact with the ground lasts for this part of every period; minor frames.
  std::int64_t pass_frames = 600, pass_period_frames = 6000;
  std::int64_t restart_every_frames = 7000;     ///< the program starts over; 0: never
  TimeNs longest_pause_ns = 10 * ns_per_s;      ///< between two keyframes
  TimeNs clock_back_ns = 0;                     ///< how far the clock goes back at every restart
  std::int64_t behind_from = 0, behind_to = 0;  ///< minor frames in which the account may lag
  /// Called before each minor frame, for what else a test lets happen.
  std::function<void(Store& store, std::int64_t frame)> happen;
};

struct EndlessResult {
  std::int64_t keyframes = 0;
  std::int64_t minor_frames = 0;
  std::int64_t most_database_bytes = 0, most_log_bytes = 0, most_held_bytes = 0;
  std::int64_t most_rows = 0;
  std::int64_t database_bytes_at_quarter = 0;
  std::int64_t resident_kib_at_quarter = 0, resident_kib_at_end = 0;
  StorageRecord account;
  std::map<StatusCode, std::int64_t> events;
  std::int64_t files = 0, bytes = 0;
};

/// Missions of the test: storage for about 100 keyframes.
[[nodiscard]] MissionParameters endless_mission();

/// Flies, and checks after every minor frame: the account says what is there; what was handed to the link is there, or
/// confirmed; what is not coded has its image; capture has not stopped; and now and then that the store is valid.
EndlessResult fly_endlessly(const std::string& database, const MissionParameters& mission,
                            const EndlessOptions& options);

}  // namespace ilp::test
