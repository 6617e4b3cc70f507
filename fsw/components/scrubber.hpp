// Reads through what nobody looks at for long, so that damage is found while something can still be done about it.
#pragma once

#include <span>

#include "cfg/mission.hpp"
#include "fsw/components/checkpoint.hpp"
#include "fsw/executive/component.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

/// Code and constants: bytes that never change while the program runs.
using ImageRegions = std::span<const std::span<const std::byte>>;

/// In every step a slice as long as the pace of the mission's parameters allows: of code and constants, compared with
/// what they were when first seen. Never has more work waiting, so that a flight in virtual time does not go on for it.
class Scrubber final : public Component {
 public:
  Scrubber(Clock& clock, const MissionParameters& mission);

  /// The regions outlive the scrubber; none where they are not known. Before restore().
  void watch(ImageRegions image);

  [[nodiscard]] const char* name() const override { return "scrubber"; }
  Status restore() override;
  StepResult step(TimeNs deadline) override;

  /// Code or constants are not what was loaded: only a new process has them whole.
  [[nodiscard]] bool image_damaged() const { return image_damaged_; }

 private:
  static constexpr std::size_t most_regions = 8;
  /// Where a reading through the image stands.
  struct ImageCursor {
    std::size_t region = 0;
    std::size_t offset = 0;
    std::uint64_t sum = 0;
  };

  [[nodiscard]] std::size_t grant(double bytes_per_s, TimeNs elapsed, std::size_t most) const;
  Status check_image(std::size_t bytes);

  Clock& clock_;
  const MissionParameters& mission_;
  TimeNs stepped_ns_ = -1;
  ImageRegions image_;
  std::array<std::uint64_t, most_regions> image_sums_{};
  ImageCursor image_cursor_;
  bool image_damaged_ = false;
};

}  // namespace ilp
