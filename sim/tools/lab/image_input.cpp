#include "sim/tools/lab/image_input.hpp"

#include <stdexcept>

#include "cfg/limits.hpp"

namespace ilp::lab {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

GrayImage read_within(const std::string& path, int max_width, int max_height, const char* limit_names) {
  const host::ImageSize size = host::read_image_size(path);
  if (size.width > max_width || size.height > max_height) {
    throw std::runtime_error(path + ": " + size_text(size.width, size.height) +
                             " pixels, the limit of the flight software is " + size_text(max_width, max_height) + " (" +
                             limit_names + " in cfg/limits.hpp, profile " + limits::profile + ")");
  }
  return host::read_gray(path);
}

}  // namespace

GrayImage read_camera_image(const std::string& path) {
  return read_within(path, limits::max_image_width, limits::max_image_height,
                     "limits::max_image_width, limits::max_image_height");
}

GrayImage read_rectified_image(const std::string& path) {
  return read_within(path, limits::max_rectified_width, limits::max_rectified_height,
                     "limits::max_rectified_width, limits::max_rectified_height");
}

void require_same_size(const GrayImage& image, const std::string& path, int width, int height,
                       const std::string& other) {
  if (image.width == width && image.height == height) return;
  throw std::runtime_error(path + " has " + size_text(image.width, image.height) + " pixels, " + other + " has " +
                           size_text(width, height));
}

GrayImage read_mask(const std::string& path, const GrayImage& image, const std::string& image_path) {
  if (path.empty()) return {};
  GrayImage mask = read_camera_image(path);
  require_same_size(mask, path, image.width, image.height, image_path);
  return mask;
}

}  // namespace ilp::lab
