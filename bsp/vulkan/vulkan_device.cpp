#include "bsp/vulkan/vulkan_device.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>

namespace ilp {
namespace {

constexpr std::uint32_t max_devices = 8;
constexpr std::uint32_t max_families = 16;
constexpr std::uint32_t max_sets = 8;
constexpr std::uint64_t longest_run_ns = 20'000'000'000;

bool good(VkResult result, const char* what) {
  if (result == VK_SUCCESS) return true;
  std::fprintf(stderr, "ilp-compute-vulkan: %s failed with VkResult %d\n", what, static_cast<int>(result));
  return false;
}

template <typename Info>
Info of_type(VkStructureType type) {
  Info info{};
  info.sType = type;
  return info;
}

bool make_instance(VkInstance& instance) {
  auto application = of_type<VkApplicationInfo>(VK_STRUCTURE_TYPE_APPLICATION_INFO);
  application.pApplicationName = "ilp-compute-vulkan";
  application.apiVersion = VK_API_VERSION_1_1;
  auto info = of_type<VkInstanceCreateInfo>(VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO);
  info.pApplicationInfo = &application;
  return good(vkCreateInstance(&info, nullptr, &instance), "vkCreateInstance");
}

std::uint32_t devices_of(VkInstance instance, VkPhysicalDevice (&devices)[max_devices]) {
  std::uint32_t count = max_devices;
  const VkResult result = vkEnumeratePhysicalDevices(instance, &count, devices);
  return result == VK_SUCCESS || result == VK_INCOMPLETE ? count : 0;
}

bool find_family(VkPhysicalDevice device, std::uint32_t& family) {
  VkQueueFamilyProperties families[max_families];
  std::uint32_t count = max_families;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families);
  for (family = 0; family < count; ++family) {
    if ((families[family].queueFlags & VK_QUEUE_COMPUTE_BIT) != 0) return true;
  }
  return false;
}

}  // namespace

bool VulkanDevice::list() {
  VkInstance instance = VK_NULL_HANDLE;
  if (!make_instance(instance)) return false;
  VkPhysicalDevice devices[max_devices];
  const std::uint32_t count = devices_of(instance, devices);
  for (std::uint32_t i = 0; i < count; ++i) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(devices[i], &properties);
    std::printf("%s, Vulkan %u.%u\n", properties.deviceName, VK_API_VERSION_MAJOR(properties.apiVersion),
                VK_API_VERSION_MINOR(properties.apiVersion));
  }
  vkDestroyInstance(instance, nullptr);
  return count > 0;
}

bool VulkanDevice::choose(VkInstance instance, const char* name) {
  VkPhysicalDevice devices[max_devices];
  const std::uint32_t count = devices_of(instance, devices);
  for (std::uint32_t i = 0; i < count; ++i) {
    vkGetPhysicalDeviceProperties(devices[i], &properties_);
    const VkPhysicalDeviceLimits& limits = properties_.limits;
    const bool wanted = name == nullptr || std::strstr(properties_.deviceName, name) != nullptr;
    const bool able = properties_.apiVersion >= VK_API_VERSION_1_1 && limits.maxComputeWorkGroupInvocations >= lanes &&
                      limits.maxPerStageDescriptorStorageBuffers >= max_buffers;
    if (!wanted || !able || !find_family(devices[i], family_)) continue;
    physical_ = devices[i];
    return true;
  }
  std::fprintf(stderr, "ilp-compute-vulkan: none of %u devices can do the work%s%s\n", count,
               name != nullptr ? " or is named " : "", name != nullptr ? name : "");
  return false;
}

bool VulkanDevice::open(const char* name) {
  VkInstance instance = VK_NULL_HANDLE;
  if (!make_instance(instance) || !choose(instance, name)) return false;
  const float priority = 1;
  auto queue = of_type<VkDeviceQueueCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO);
  queue.queueFamilyIndex = family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  auto device = of_type<VkDeviceCreateInfo>(VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO);
  device.queueCreateInfoCount = 1;
  device.pQueueCreateInfos = &queue;
  if (!good(vkCreateDevice(physical_, &device, nullptr, &device_), "vkCreateDevice")) return false;
  vkGetDeviceQueue(device_, family_, 0, &queue_);
  auto fence = of_type<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
  auto commands = of_type<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
  commands.queueFamilyIndex = family_;
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, max_sets * max_buffers};
  auto sets = of_type<VkDescriptorPoolCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO);
  sets.maxSets = max_sets;
  sets.poolSizeCount = 1;
  sets.pPoolSizes = &size;
  return good(vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence") &&
         good(vkCreateCommandPool(device_, &commands, nullptr, &commands_), "vkCreateCommandPool") &&
         good(vkCreateDescriptorPool(device_, &sets, nullptr, &sets_), "vkCreateDescriptorPool");
}

// Cached by the processor where there is such a type, because reading results is slow otherwise.
std::uint32_t VulkanDevice::memory_type(std::uint32_t allowed) const {
  VkPhysicalDeviceMemoryProperties types;
  vkGetPhysicalDeviceMemoryProperties(physical_, &types);
  constexpr VkMemoryPropertyFlags seen = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  for (const VkMemoryPropertyFlags flags : {seen | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, seen}) {
    for (std::uint32_t i = 0; i < types.memoryTypeCount; ++i) {
      if ((allowed >> i & 1U) != 0 && (types.memoryTypes[i].propertyFlags & flags) == flags) return i;
    }
  }
  return VK_MAX_MEMORY_TYPES;
}

bool VulkanDevice::make_buffer(std::size_t bytes, VulkanBuffer& buffer) {
  auto info = of_type<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = bytes;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  if (!good(vkCreateBuffer(device_, &info, nullptr, &buffer.buffer), "vkCreateBuffer")) return false;
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device_, buffer.buffer, &needs);
  auto allocation = of_type<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  allocation.allocationSize = needs.size;
  allocation.memoryTypeIndex = memory_type(needs.memoryTypeBits);
  void* mapped = nullptr;
  const bool made = good(vkAllocateMemory(device_, &allocation, nullptr, &buffer.memory), "vkAllocateMemory") &&
                    good(vkBindBufferMemory(device_, buffer.buffer, buffer.memory, 0), "vkBindBufferMemory") &&
                    good(vkMapMemory(device_, buffer.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
  if (!made) return false;
  buffer.bytes = static_cast<std::byte*>(mapped);
  buffer.size = bytes;
  std::memset(buffer.bytes, 0, bytes);
  return true;
}

bool VulkanDevice::make_set(std::span<const VulkanBuffer* const> buffers, VkPipelineLayout& layout,
                            VkDescriptorSet& set) {
  const auto count = static_cast<std::uint32_t>(std::min<std::size_t>(buffers.size(), max_buffers));
  VkDescriptorSetLayoutBinding bindings[max_buffers] = {};
  VkDescriptorBufferInfo infos[max_buffers] = {};
  for (std::uint32_t i = 0; i < count; ++i) {
    bindings[i] = {i, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    infos[i] = {buffers[i]->buffer, 0, VK_WHOLE_SIZE};
  }
  auto form = of_type<VkDescriptorSetLayoutCreateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO);
  form.bindingCount = count;
  form.pBindings = bindings;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  if (!good(vkCreateDescriptorSetLayout(device_, &form, nullptr, &set_layout), "vkCreateDescriptorSetLayout")) {
    return false;
  }
  const VkPushConstantRange constant{VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(std::uint32_t)};
  auto pipelines = of_type<VkPipelineLayoutCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO);
  pipelines.setLayoutCount = 1;
  pipelines.pSetLayouts = &set_layout;
  pipelines.pushConstantRangeCount = 1;
  pipelines.pPushConstantRanges = &constant;
  auto allocation = of_type<VkDescriptorSetAllocateInfo>(VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO);
  allocation.descriptorPool = sets_;
  allocation.descriptorSetCount = 1;
  allocation.pSetLayouts = &set_layout;
  if (!good(vkCreatePipelineLayout(device_, &pipelines, nullptr, &layout), "vkCreatePipelineLayout") ||
      !good(vkAllocateDescriptorSets(device_, &allocation, &set), "vkAllocateDescriptorSets")) {
    return false;
  }
  auto write = of_type<VkWriteDescriptorSet>(VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET);
  write.dstSet = set;
  write.descriptorCount = count;
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = infos;
  vkUpdateDescriptorSets(device_, 1, &write, 0, nullptr);
  return true;
}

bool VulkanDevice::make_pipeline(std::span<const std::uint32_t> shader, VkPipelineLayout layout, VkPipeline& pipeline) {
  auto code = of_type<VkShaderModuleCreateInfo>(VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO);
  code.codeSize = shader.size_bytes();
  code.pCode = shader.data();
  VkShaderModule module = VK_NULL_HANDLE;
  if (!good(vkCreateShaderModule(device_, &code, nullptr, &module), "vkCreateShaderModule")) return false;
  auto info = of_type<VkComputePipelineCreateInfo>(VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO);
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.layout = layout;
  const VkResult made = vkCreateComputePipelines(device_, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
  vkDestroyShaderModule(device_, module, nullptr);
  return good(made, "vkCreateComputePipelines");
}

bool VulkanDevice::begin_commands(VkCommandBuffer& commands) {
  auto allocation = of_type<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
  allocation.commandPool = commands_;
  allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocation.commandBufferCount = 1;
  auto begin = of_type<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  return good(vkAllocateCommandBuffers(device_, &allocation, &commands), "vkAllocateCommandBuffers") &&
         good(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
}

bool VulkanDevice::end_commands(VkCommandBuffer commands) {
  return good(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

void VulkanDevice::separate(VkCommandBuffer commands, bool last) {
  auto barrier = of_type<VkMemoryBarrier>(VK_STRUCTURE_TYPE_MEMORY_BARRIER);
  barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
  VkPipelineStageFlags next = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
  if (last) {
    barrier.dstAccessMask |= VK_ACCESS_HOST_READ_BIT;
    next |= VK_PIPELINE_STAGE_HOST_BIT;
  }
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, next, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

bool VulkanDevice::run(VkCommandBuffer commands) {
  auto submission = of_type<VkSubmitInfo>(VK_STRUCTURE_TYPE_SUBMIT_INFO);
  submission.commandBufferCount = 1;
  submission.pCommandBuffers = &commands;
  return good(vkResetFences(device_, 1, &fence_), "vkResetFences") &&
         good(vkQueueSubmit(queue_, 1, &submission, fence_), "vkQueueSubmit") &&
         good(vkWaitForFences(device_, 1, &fence_, VK_TRUE, longest_run_ns), "vkWaitForFences");
}

}  // namespace ilp
