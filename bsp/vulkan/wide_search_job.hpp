// Computes jobs of the wide search (fsw/vision/overlap/wide_search.hpp) on a Vulkan device.
#pragma once

#include <array>

#include "bsp/vulkan/device_job.hpp"
#include "fsw/vision/overlap/wide_search.hpp"

namespace ilp {

class WideSearchJob {
 public:
  /// Makes memory, pipelines and commands.
  bool prepare(VulkanDevice& device);
  /// Computes one job. The output has the same bytes as that of search_wide_pose().
  bool run(std::span<const std::byte> input, std::span<std::byte> output);

 private:
  // A few milliseconds of work on a small device: a long submission may hang its driver.
  static constexpr std::size_t poses_per_submission = 4;
  static constexpr std::size_t submissions = wide_job_poses / poses_per_submission;

  enum Step : std::size_t { draw, search, steps };
  bool record(std::size_t submission);

  DeviceJob job_;
  std::array<VkPipeline, steps> pipelines_{};
  std::array<VkCommandBuffer, submissions> commands_{};
};

}  // namespace ilp
