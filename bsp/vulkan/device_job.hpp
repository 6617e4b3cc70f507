// What every job on a Vulkan device has: memory for its input, what its shaders share, and its output, the shaders, and
// commands that are recorded once.
#pragma once

#include "bsp/vulkan/vulkan_device.hpp"

namespace ilp {

class DeviceJob {
 public:
  using Shader = std::span<const std::uint32_t>;
  struct Sizes {
    std::size_t input, scratch, output;
  };

  /// Makes the memory, which shaders find at the bindings 0 to 2 in the order of `sizes`, and a pipeline of each
  /// shader.
  bool make(VulkanDevice& device, const Sizes& sizes, std::span<const Shader> shaders, std::span<VkPipeline> pipelines);

  /// Begins commands that find the memory.
  bool begin(VkCommandBuffer& commands);
  /// x by y workgroups of a shader, whose push constant is `constant`.
  void dispatch(VkCommandBuffer commands, VkPipeline pipeline, std::uint32_t constant, std::uint32_t x,
                std::uint32_t y) const;
  /// Ends commands: what they wrote is there for the next ones and for the processor.
  static bool end(VkCommandBuffer commands);

  /// Runs commands one after the other, with an output that is zero at first.
  bool run(std::span<const VkCommandBuffer> commands, std::span<const std::byte> input, std::span<std::byte> output);

 private:
  VulkanDevice* device_ = nullptr;
  VulkanBuffer input_, scratch_, output_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace ilp
