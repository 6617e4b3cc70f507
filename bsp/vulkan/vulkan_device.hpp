// Opens a Vulkan device for computing, and makes buffers, pipelines and commands for its jobs. A function that fails
// prints the reason on standard error and returns false.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace ilp {

/// A storage buffer that the processor and the device share. It begins with zeros.
struct VulkanBuffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  std::byte* bytes = nullptr;
  std::size_t size = 0;
};

class VulkanDevice {
 public:
  static constexpr std::uint32_t lanes = 64;       ///< invocations in a workgroup of every shader
  static constexpr std::uint32_t max_buffers = 4;  ///< limit of a shader's storage buffers

  VulkanDevice() = default;
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;

  /// Opens the first suitable device whose name contains `name`; null: the first suitable device.
  bool open(const char* name);
  /// Prints the names of all devices. Returns false if there is none.
  static bool list();
  [[nodiscard]] const char* name() const { return properties_.deviceName; }

  bool make_buffer(std::size_t bytes, VulkanBuffer& buffer);
  /// Makes a descriptor set with the buffers at the bindings 0, 1, ..., and a layout with a push constant of 32 bits.
  bool make_set(std::span<const VulkanBuffer* const> buffers, VkPipelineLayout& layout, VkDescriptorSet& set);
  bool make_pipeline(std::span<const std::uint32_t> shader, VkPipelineLayout layout, VkPipeline& pipeline);
  bool begin_commands(VkCommandBuffer& commands);
  static bool end_commands(VkCommandBuffer commands);
  /// Records a barrier, so that the next shader sees what the previous one has written. With `last` the processor sees
  /// it too.
  static void separate(VkCommandBuffer commands, bool last);
  /// Submits the commands and waits until they are done, at most 20 s.
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
