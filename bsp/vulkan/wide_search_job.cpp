#include "bsp/vulkan/wide_search_job.hpp"

#include <cstddef>
#include <cstring>

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

bool WideSearchJob::record(std::size_t submission, VkPipelineLayout layout, VkDescriptorSet set) {
  VkCommandBuffer& commands = commands_[submission];
  if (!device_->begin_commands(commands)) return false;
  const auto first = static_cast<std::uint32_t>(submission * poses_per_submission);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0, nullptr);
  vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(first), &first);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, draw_);
  vkCmdDispatch(commands, canvas_groups, poses_per_submission, 1);
  VulkanDevice::separate(commands, false);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, search_);
  vkCmdDispatch(commands, wide_max_shifts, poses_per_submission, 1);
  VulkanDevice::separate(commands, true);
  return VulkanDevice::end_commands(commands);
}

bool WideSearchJob::prepare(VulkanDevice& device) {
  device_ = &device;
  const VulkanBuffer* const buffers[] = {&input_, &canvases_, &output_};
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorSet set = VK_NULL_HANDLE;
  if (!device.make_buffer(sizeof(WideInput), input_) ||
      !device.make_buffer(wide_job_poses * wide_canvas_side * canvas_words * word, canvases_) ||
      !device.make_buffer(sizeof(WideOutput), output_) || !device.make_set(buffers, layout, set) ||
      !device.make_pipeline(wide_draw_spv, layout, draw_) || !device.make_pipeline(wide_search_spv, layout, search_)) {
    return false;
  }
  for (std::size_t i = 0; i < submissions; ++i) {
    if (!record(i, layout, set)) return false;
  }
  return true;
}

bool WideSearchJob::run(std::span<const std::byte> input, std::span<std::byte> output) {
  std::memcpy(input_.bytes, input.data(), input.size());
  for (const VkCommandBuffer commands : commands_) {
    if (!device_->run(commands)) return false;
  }
  std::memcpy(output.data(), output_.bytes, output.size());
  return true;
}

}  // namespace ilp
