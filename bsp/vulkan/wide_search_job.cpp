#include "bsp/vulkan/wide_search_job.hpp"

#include <cstddef>

#include "bsp/vulkan/wide_draw.spv.hpp"
#include "bsp/vulkan/wide_search.spv.hpp"

namespace ilp {
namespace {

// What shaders/wide_memory.glsl says of the memory, in words.
constexpr std::size_t word = sizeof(std::uint32_t);
constexpr std::size_t canvas_words = 22;
static_assert(wide_max_side == 160 && wide_plane_rows == 40 && wide_plane_stride == 16 * word);
static_assert(offsetof(WideInput, width) == 0 && offsetof(WideInput, height) == word);
static_assert(offsetof(WideInput, pose_count) == 2 * word && offsetof(WideInput, a) == 4 * word);
static_assert(offsetof(WideInput, b) == 4 * word + 160 * 160);
static_assert(offsetof(WideInput, poses) == offsetof(WideInput, b) + 16 * 40 * 16 * word);
static_assert(sizeof(WidePose) == 12 * word && offsetof(WidePose, step_x) == 2 * word);
static_assert(offsetof(WidePose, columns) == 4 * word && offsetof(WidePose, left) == 6 * word);
static_assert(offsetof(WidePose, shifts_x) == 8 * word && offsetof(WidePose, min_count) == 10 * word);
static_assert(wide_max_shifts == 192 && wide_shift_bits == 8 && wide_unrelated == 36 && wide_shift_px == 2);
static_assert(wide_canvas_side == 85 && canvas_words * word >= wide_canvas_side && wide_sample_px == 4);

constexpr std::uint32_t canvas_groups =
    (wide_canvas_side * canvas_words + VulkanDevice::lanes - 1) / VulkanDevice::lanes;

}  // namespace

bool WideSearchJob::record(std::size_t submission) {
  VkCommandBuffer& commands = commands_[submission];
  if (!job_.begin(commands)) return false;
  const auto first = static_cast<std::uint32_t>(submission * poses_per_submission);
  job_.dispatch(commands, pipelines_[draw], first, canvas_groups, poses_per_submission);
  VulkanDevice::separate(commands, false);
  job_.dispatch(commands, pipelines_[search], first, wide_max_shifts, poses_per_submission);
  return DeviceJob::end(commands);
}

bool WideSearchJob::prepare(VulkanDevice& device) {
  const DeviceJob::Shader shaders[] = {wide_draw_spv, wide_search_spv};
  constexpr std::size_t canvases = wide_job_poses * wide_canvas_side * canvas_words * word;
  if (!job_.make(device, {sizeof(WideInput), canvases, sizeof(WideOutput)}, shaders, pipelines_)) return false;
  for (std::size_t i = 0; i < submissions; ++i) {
    if (!record(i)) return false;
  }
  return true;
}

bool WideSearchJob::run(std::span<const std::byte> input, std::span<std::byte> output) {
  return job_.run(commands_, input, output);
}

}  // namespace ilp
