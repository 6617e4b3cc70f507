// Images and cameras of the command line, checked against each other and against the flight limits.
#pragma once

#include <cstdint>
#include <string>

#include "fsw/base/geometry.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::lab {

using GrayImage = host::Raster<std::uint8_t>;

/// Refuses what is larger than a camera image of the flight software may be.
[[nodiscard]] GrayImage read_camera_image(const std::string& path);
/// Refuses what is larger than a rectified image may be.
[[nodiscard]] GrayImage read_rectified_image(const std::string& path);

/// std::runtime_error naming both when the sizes differ.
void require_same_size(const GrayImage& image, const std::string& path, int width, int height,
                       const std::string& other);

/// The mask at `path`, of the image's size; an empty image for an empty path. 0 is outside, anything else inside.
[[nodiscard]] GrayImage read_mask(const std::string& path, const GrayImage& image, const std::string& image_path);

}  // namespace ilp::lab
