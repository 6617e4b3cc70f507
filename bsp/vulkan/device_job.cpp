#include "bsp/vulkan/device_job.hpp"

#include <cstring>

namespace ilp {

bool DeviceJob::make(VulkanDevice& device, const Sizes& sizes, std::span<const Shader> shaders,
                     std::span<VkPipeline> pipelines) {
  device_ = &device;
  const VulkanBuffer* const buffers[] = {&input_, &scratch_, &output_};
  if (!device.make_buffer(sizes.input, input_) || !device.make_buffer(sizes.scratch, scratch_) ||
      !device.make_buffer(sizes.output, output_) || !device.make_set(buffers, layout_, set_)) {
    return false;
  }
  for (std::size_t i = 0; i < shaders.size(); ++i) {
    if (!device.make_pipeline(shaders[i], layout_, pipelines[i])) return false;
  }
  return true;
}

bool DeviceJob::begin(VkCommandBuffer& commands) {
  if (!device_->begin_commands(commands)) return false;
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout_, 0, 1, &set_, 0, nullptr);
  return true;
}

void DeviceJob::dispatch(VkCommandBuffer commands, VkPipeline pipeline, std::uint32_t constant, std::uint32_t x,
                         std::uint32_t y) const {
  vkCmdPushConstants(commands, layout_, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(constant), &constant);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
  vkCmdDispatch(commands, x, y, 1);
}

bool DeviceJob::end(VkCommandBuffer commands) {
  VulkanDevice::separate(commands, true);
  return VulkanDevice::end_commands(commands);
}

bool DeviceJob::run(std::span<const VkCommandBuffer> commands, std::span<const std::byte> input,
                    std::span<std::byte> output) {
  std::memcpy(input_.bytes, input.data(), input.size());
  // What no shader writes is zero.
  std::memset(output_.bytes, 0, output_.size);
  for (const VkCommandBuffer part : commands) {
    if (!device_->run(part)) return false;
  }
  std::memcpy(output.data(), output_.bytes, output.size());
  return true;
}

}  // namespace ilp
