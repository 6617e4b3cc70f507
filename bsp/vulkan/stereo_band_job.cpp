#include "bsp/vulkan/stereo_band_job.hpp"

#include <cstddef>

#include "bsp/vulkan/stereo_above.spv.hpp"
#include "bsp/vulkan/stereo_along.spv.hpp"
#include "bsp/vulkan/stereo_cost.spv.hpp"
#include "bsp/vulkan/stereo_cost_rounded.spv.hpp"
#include "bsp/vulkan/stereo_winner.spv.hpp"

namespace ilp {
namespace {

// What shaders/stereo_memory.glsl says of the memory, in words.
constexpr std::size_t word = sizeof(std::uint32_t);
constexpr bool is_at(std::size_t offset, std::size_t words) {
  return offset == words * word;
}
static_assert(is_at(offsetof(StereoBandInput, width), 1) && is_at(offsetof(StereoBandInput, rows), 2));
static_assert(is_at(offsetof(StereoBandInput, held_rows), 3) && is_at(offsetof(StereoBandInput, first_row), 4));
static_assert(is_at(offsetof(StereoBandInput, continues), 5) && is_at(offsetof(StereoBandInput, padded), 6));
static_assert(is_at(offsetof(StereoBandInput, disparities), 7) && is_at(offsetof(StereoBandInput, radius), 8));
static_assert(is_at(offsetof(StereoBandInput, min_disparity), 9) && is_at(offsetof(StereoBandInput, lead), 10));
static_assert(is_at(offsetof(StereoBandInput, small_step), 11));
static_assert(is_at(offsetof(StereoBandInput, out_of_view_cost), 12));
static_assert(is_at(offsetof(StereoBandInput, run_count), 14) && is_at(offsetof(StereoBandInput, places), 16));
static_assert(is_at(offsetof(StereoBandPlaces, left), 2) && is_at(offsetof(StereoBandPlaces, left_sum), 4));
static_assert(is_at(offsetof(StereoBandPlaces, paths), 8) && is_at(offsetof(StereoBandPlaces, row_bytes), 9));
static_assert(is_at(offsetof(StereoBandPlaces, row_pixels), 10) && is_at(offsetof(StereoBandPlaces, paths_given), 11));
static_assert(offsetof(StereoBandOutput, rows) == 0 && offsetof(StereoBandPixel, peaks) == word);
static_assert(sizeof(SearchRun) == 4 * word && offsetof(SearchRun, first) == 2 * word);
static_assert(stereo_band_rows == 32 && stereo_band_disparities == 128 && stereo_band_peaks == 5);
static_assert(max_matching_cost == 64 && ncc_one == 16384 && max_large_step == 140 && excluded_sum == 1021);
static_assert(aggregated_paths == 5 && handed_paths == 3 && VulkanDevice::lanes == 64);

// A byte for the cost and each path, two for the correlation.
constexpr std::size_t scratch_bytes =
    std::size_t{8} * stereo_band_rows * static_cast<std::size_t>(stereo_band_width) * stereo_band_disparities;
constexpr std::uint32_t disparities_per_lane = 4;
constexpr std::uint32_t lines_per_group = VulkanDevice::lanes * disparities_per_lane / stereo_band_disparities;

constexpr std::uint32_t groups_of(std::uint32_t things, std::uint32_t per_group) {
  return (things + per_group - 1) / per_group;
}
constexpr auto width = static_cast<std::uint32_t>(stereo_band_width);

}  // namespace

bool StereoBandDeviceJob::record(Step step, std::uint32_t first_row, VkCommandBuffer& commands) {
  if (!job_.begin(commands)) return false;
  const auto dispatch = [&](std::uint32_t row, std::uint32_t x, std::uint32_t y) {
    job_.dispatch(commands, pipelines_[step], row, x, y);
  };
  switch (step) {
    case cost:
      dispatch(first_row, groups_of(width * stereo_band_disparities / disparities_per_lane, VulkanDevice::lanes),
               rows_per_submission);
      break;
    case along:
      dispatch(first_row, groups_of(rows_per_submission, lines_per_group), 2);
      break;
    case above:
      for (std::uint32_t row = first_row; row < first_row + rows_per_submission; ++row) {
        if (row > first_row) VulkanDevice::separate(commands, false);
        dispatch(row, groups_of(width, lines_per_group), handed_paths);
      }
      break;
    case winner:
    case steps:
      dispatch(first_row, groups_of(width, VulkanDevice::lanes), rows_per_submission);
      break;
  }
  return DeviceJob::end(commands);
}

bool StereoBandDeviceJob::prepare(VulkanDevice& device) {
  // Without the promise the comparison at the start of a flight says whether the device rounds as processors do.
  const DeviceJob::Shader costs =
      device.rounds_to_nearest() ? DeviceJob::Shader(stereo_cost_rounded_spv) : stereo_cost_spv;
  const DeviceJob::Shader shaders[] = {costs, stereo_along_spv, stereo_above_spv, stereo_winner_spv};
  if (!job_.make(device, {sizeof(StereoBandInput), scratch_bytes, sizeof(StereoBandOutput)}, shaders, pipelines_)) {
    return false;
  }
  for (std::uint32_t step = 0; step < steps; ++step) {
    for (std::uint32_t part = 0; part < parts; ++part) {
      if (!record(static_cast<Step>(step), part * rows_per_submission, commands_[step * parts + part])) return false;
    }
  }
  return true;
}

bool StereoBandDeviceJob::run(std::span<const std::byte> input, std::span<std::byte> output) {
  return job_.run(commands_, input, output);
}

}  // namespace ilp
