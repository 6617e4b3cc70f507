// Reads through what nobody looks at for long, so that damage is found while something can still be done about it.
#pragma once

#include <array>
#include <span>

#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/scrub.hpp"

namespace ilp {

/// Code and constants: bytes that never change while the program runs.
using ImageRegions = std::span<const std::span<const std::byte>>;

/// In every step one slice of the store, whose checksums are compared by reading, and one of code and constants, which
/// are compared with what they were when first seen: as long as the paces of the mission's parameters allow. What is
/// damaged in the store is told once. Never has more work waiting, so that a flight in virtual time does not go on for
/// it.
class Scrubber final : public StageComponent<ComponentId::scrubber> {
 public:
  static const CheckpointForm checkpoint;

  Scrubber(Tables store, Clock& clock, const MissionParameters& mission);

  /// The regions outlive the scrubber; none where they are not known. Before restore().
  void watch(ImageRegions image);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory(cursor_, state_, image_cursor_).of(*this);
  }

  /// Code or constants are not what was loaded: only a new process has them whole.
  [[nodiscard]] bool image_damaged() const { return image_damaged_; }

 private:
  static constexpr std::size_t most_regions = 8;
  static constexpr std::size_t most_known = 64;
  struct Damaged {
    std::int64_t table = 0;
    std::int64_t id = 0;
  };
  struct State {
    ScrubCursor place;
    TimeNs begun_ns = 0;                       ///< the round
    bool resting = false;                      ///< it is complete, and the next one not due
    FixedVector<Damaged, most_known> damaged;  ///< that have been told of; the oldest are forgotten
  };
  /// Where a reading through the image stands.
  struct ImageCursor {
    std::size_t region = 0;
    std::size_t offset = 0;
    std::uint64_t sum = 0;
  };

  [[nodiscard]] static std::size_t grant(double bytes_per_s, TimeNs elapsed, std::size_t most);
  Status check_image(std::size_t bytes);
  Status check_store(std::size_t bytes, TimeNs now);
  bool learn(const Damaged& damaged);
  Status save(const State& after);

  Tables store_;
  Clock& clock_;
  const MissionParameters& mission_;
  Cursor cursor_;  // counts what was saved
  State state_;
  TimeNs stepped_ns_ = -1;
  std::array<std::uint8_t, blob_chunk_bytes> scratch_{};
  ImageRegions image_;
  std::array<std::uint64_t, most_regions> image_sums_{};
  ImageCursor image_cursor_;
  bool image_damaged_ = false;
};

}  // namespace ilp
