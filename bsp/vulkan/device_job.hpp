// Common parts of the jobs on a Vulkan device: buffers for input, scratch and output, a pipeline for each shader, and
// commands that are recorded once and run for every job.
#pragma once

#include "bsp/vulkan/vulkan_device.hpp"

namespace ilp {

class DeviceJob {
 public:
  using Shader = std::span<const std::uint32_t>;
  /// Sizes of the buffers, bytes.
  struct Sizes {
    std::size_t input, scratch, output;
  };

  /// Makes the buffers and a pipeline for each shader. Shaders find the buffers at the bindings 0 to 2 in the order of
  /// `sizes`.
  bool make(VulkanDevice& device, const Sizes& sizes, std::span<const Shader> shaders, std::span<VkPipeline> pipelines);

  /// Begins to record commands, with the buffers bound.
  bool begin(VkCommandBuffer& commands);
  /// Records x by y workgroups of a shader with the push constant `constant`.
  void dispatch(VkCommandBuffer commands, VkPipeline pipeline, std::uint32_t constant, std::uint32_t x,
                std::uint32_t y) const;
  /// Ends recording with a barrier, so that later commands and the processor see what these commands have written.
  static bool end(VkCommandBuffer commands);

  /// Copies the input to the device, sets the output to zeros, runs the commands one after another, and copies the
  /// output back.
  bool run(std::span<const VkCommandBuffer> commands, std::span<const std::byte> input, std::span<std::byte> output);

 private:
  VulkanDevice* device_ = nullptr;
  VulkanBuffer input_, scratch_, output_;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace ilp
