// Source of images for ilp-onboard: a YUV4MPEG2 stream (Y4mCamera).
#pragma once

#include "bsp/linux/image_source.hpp"
#include "hal/camera/y4m/y4m_camera.hpp"

namespace ilp {

/// The stream is a file, or standard input for `-`. In real time a stream that is no regular file is live (Y4mArrival).
/// The descriptor stays open until the program ends. The calls return the statuses of Y4mCamera::open(), and `io_error`
/// (first value: errno) if the file cannot be opened.
class StreamSource final : public ImageSource {
 public:
  static constexpr ImageSourceKind kind = {
      "--y4m", "FILE|-",
      "  --y4m           a YUV4MPEG2 stream, - for standard input; times follow from the frame rate of the stream\n",
      false};

  explicit StreamSource(const ImageSourceContext& context) : real_time_(context.real_time) {}
  Status find_size(const char* value, std::int32_t& width, std::int32_t& height) override;
  Status open(const char* value, std::int32_t width, std::int32_t height) override;
  [[nodiscard]] Camera& camera() override { return camera_; }

 private:
  Status read_header(const char* file);

  bool real_time_;
  bool opened_ = false;
  Y4mCamera camera_;
};

}  // namespace ilp
