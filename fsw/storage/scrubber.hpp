// Reads rarely used data regularly, so that damage is found while it can still be repaired.
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

/// Each step reads a slice of the store, which checks its own checksums, and a slice of code and constants, whose
/// checksum is compared with that of the first reading. The mission's parameters set the rates. Damage in the store is
/// reported once. The scrubber never has pending work, so that it does not prolong a flight in virtual time.
class Scrubber final : public StageComponent<ComponentId::scrubber> {
 public:
  static const CheckpointForm checkpoint;

  /// The regions must outlive the scrubber. The list is empty if they are not known.
  Scrubber(Tables store, Clock& clock, const MissionParameters& mission, ImageRegions image = {});

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

  /// Code or constants have changed since the first reading: only a new process can restore them.
  [[nodiscard]] bool image_damaged() const { return workspace_.image_damaged; }

 private:
  static constexpr std::size_t most_regions = 8;
  static constexpr std::size_t most_known = 64;
  struct Wiring {
    Tables store;
    Clock& clock;
    const MissionParameters& mission;
    ImageRegions image;
    std::array<std::uint64_t, most_regions> image_sums{};  ///< checksums of the first reading
  };
  struct Damaged {
    std::int64_t table = 0;
    std::int64_t id = 0;
  };
  struct State {
    ScrubCursor place;
    TimeNs begun_ns = 0;                       ///< begin of the round
    bool resting = false;                      ///< the round is complete, and the next one is not due
    FixedVector<Damaged, most_known> damaged;  ///< reported damage; the oldest entries are dropped
  };
  /// The position of a reading of code and constants.
  struct ImageCursor {
    std::size_t region = 0;
    std::size_t offset = 0;
    std::uint64_t sum = 0;
  };
  struct Work {
    bool stepped = false;
    TimeNs stepped_ns = 0;
    ImageCursor image;
  };
  struct alignas(8) Workspace {
    std::array<std::uint8_t, blob_chunk_bytes> scratch{};
    bool image_damaged = false;
  };

  [[nodiscard]] static std::size_t grant(double bytes_per_s, TimeNs elapsed, std::size_t most);
  Status check_image(std::size_t bytes);
  Status check_store(std::size_t bytes, TimeNs now);
  bool learn(const Damaged& damaged);
  Status save();

  Wiring wiring_;
  Cursor cursor_;  // counts saves
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
