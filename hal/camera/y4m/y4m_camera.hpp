// A YUV4MPEG2 stream on a file descriptor, which any video tool can provide.
#pragma once

#include "hal/camera/buffered_reader.hpp"
#include "hal/camera/camera.hpp"

namespace ilp {

/// Takes the luma of every frame; 8-bit 4:2:0, 4:1:1, 4:2:2, 4:4:4 and mono. Times follow from the stream's frame rate.
class Y4mCamera final : public Camera {
 public:
  /// Reads the stream's header. `parse_error` when it is malformed, `unsupported_format` for other samplings or depths
  /// (a = 3) or a missing rate (a = 4), `image_too_large`. The descriptor stays the caller's.
  Status open(int file);
  [[nodiscard]] std::int32_t width() const { return width_; }
  [[nodiscard]] std::int32_t height() const { return height_; }

  /// `truncated` or `parse_error` ends the stream, because the next frame of a damaged stream cannot be found.
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;

 private:
  Status read_header_line();
  Status parse_header();
  Status due_time(TimeNs& due) const;
  Status skip(std::size_t bytes);

  BufferedReader reader_;
  char line_[256] = {};
  std::int32_t width_ = 0, height_ = 0;
  std::int64_t rate_numerator_ = 0, rate_denominator_ = 0;
  std::size_t chroma_bytes_ = 0;
  std::int64_t sequence_ = 0;
  bool ended_ = true;
};

}  // namespace ilp
