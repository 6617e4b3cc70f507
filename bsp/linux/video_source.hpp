// Source of images for ilp-onboard: a V4L2 camera.
#pragma once

#include "bsp/linux/image_source.hpp"
#include "bsp/linux/video_camera.hpp"
#include "hal/camera/v4l2/linux_video_device.hpp"

namespace ilp {

class VideoSource final : public ImageSource {
 public:
  static constexpr ImageSourceKind kind = {
      "--v4l2", "DEVICE[,SETTING...]",
      "  --v4l2          a video device, such as /dev/video0; settings: format=NAME rate=HZ input=N exposure_us=N\n"
      "                  gain=N stamp_delay_us=N (docs/onboard.md)\n",
      true};

  explicit VideoSource(const ImageSourceContext& context) : clock_(context.clock), camera_(device_, clock_) {}
  Status find_size(const char* value, std::int32_t& width, std::int32_t& height) override {
    return find_video_size(value, device_, width, height);
  }
  Status open(const char* value, std::int32_t width, std::int32_t height) override {
    return start_video_camera(value, width, height, clock_, camera_);
  }
  [[nodiscard]] Camera& camera() override { return camera_; }
  void follow_clock() override { camera_.set_mission_minus_monotonic(clock_.mission_minus_monotonic()); }

 private:
  RealClock& clock_;
  LinuxVideoDevice device_;
  V4l2Camera camera_;
};

}  // namespace ilp
