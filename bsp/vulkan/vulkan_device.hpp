// A Vulkan device that computes, with everything that its jobs need made before the first one. A function that fails
// says why on standard error and returns false.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// Memory that the processor and the device see.
struct VulkanBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  std::byte* bytes = nullptr;
  std::size_t size = 0;
};

class VulkanDevice {
 public:
  static constexpr std::uint32_t lanes = 64;       ///< invocations of a workgroup, in every shader
  static constexpr std::uint32_t max_buffers = 4;  ///< of one shader

  VulkanDevice() = default;
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;

  /// Takes the first device whose name contains `name`; null: the first one that can do the work.
  bool open(const char* name);
  /// Prints the devices.
  static bool list();
  [[nodiscard]] const char* name() const { return properties_.deviceName; }

  bool make_buffer(std::size_t bytes, VulkanBuffer& buffer);
  /// A descriptor set of storage buffers at the bindings 0, 1, ..., and a layout with one push constant of 32 bits.
  bool make_set(std::span<const VulkanBuffer* const> buffers, VkPipelineLayout& layout, VkDescriptorSet& set);
  bool make_pipeline(std::span<const std::uint32_t> shader, VkPipelineLayout layout, VkPipeline& pipeline);
  bool begin_commands(VkCommandBuffer& commands);
  static bool end_commands(VkCommandBuffer commands);
  /// What a shader wrote is there for the next one, and at the end for the processor, too.
  static void separate(VkCommandBuffer commands, bool last);
  /// Submits the commands and waits until they are done.
  bool run(VkCommandBuffer commands);

 private:
  bool choose(VkInstance instance, const char* name);
  [[nodiscard]] std::uint32_t memory_type(std::uint32_t allowed) const;

  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties_{};
  std::uint32_t family_ = 0;
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  VkCommandPool commands_ = VK_NULL_HANDLE;
  VkDescriptorPool sets_ = VK_NULL_HANDLE;
};

}  // namespace ilp
