// Stereo bands (fsw/vision/stereo/band/stereo_band.hpp) on a Vulkan device.
#pragma once

#include <array>

#include "bsp/vulkan/device_job.hpp"
#include "fsw/vision/stereo/band/stereo_band.hpp"

namespace ilp {

class StereoBandDeviceJob {
 public:
  /// Makes memory, pipelines and commands.
  bool prepare(VulkanDevice& device);
  /// Does one job. The bytes are those of compute_stereo_band_unit().
  bool run(std::span<const std::byte> input, std::span<std::byte> output);

 private:
  // A few milliseconds of work on a small device: a long submission may hang its driver.
  static constexpr std::uint32_t rows_per_submission = 8;
  static constexpr std::uint32_t parts = stereo_band_rows / rows_per_submission;

  enum Step : std::uint32_t { cost, along, above, winner, steps };
  bool record(Step step, std::uint32_t first_row, VkCommandBuffer& commands);

  DeviceJob job_;
  std::array<VkPipeline, steps> pipelines_{};
  std::array<VkCommandBuffer, std::size_t{steps} * parts> commands_{};  ///< step by step
};

}  // namespace ilp
