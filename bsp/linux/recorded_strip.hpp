// Source of images for ilp-onboard: a recorded strip (DirectoryCamera).
#pragma once

#include "bsp/linux/image_source.hpp"
#include "hal/camera/directory/directory_camera.hpp"

namespace ilp {

class RecordedStrip final : public ImageSource {
 public:
  static constexpr ImageSourceKind kind = {
      "--index", "FILE", "  --index         a recorded strip: one line `time_ns file.pgm [altitude_m]` per frame\n",
      false};

  explicit RecordedStrip(const ImageSourceContext&) {}
  Status find_size(const char* value, std::int32_t& width, std::int32_t& height) override {
    return camera_.find_size(value, width, height);
  }
  Status open(const char* value, std::int32_t width, std::int32_t height) override {
    return camera_.open(value, width, height, nullptr);
  }
  [[nodiscard]] Camera& camera() override { return camera_; }

 private:
  DirectoryCamera camera_;
};

}  // namespace ilp
