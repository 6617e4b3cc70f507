// A YUV4MPEG2 stream on a file descriptor, which any video tool can provide.
#pragma once

#include <array>

#include "hal/camera/camera.hpp"
#include "hal/camera/picture/reduction.hpp"
#include "hal/posix/buffered_reader.hpp"

namespace ilp {

/// Frames in so many seconds; 0: not known.
struct FrameRate {
  std::int64_t frames = 0, seconds = 0;
};

/// How a stream arrives, and when it begins.
struct Y4mArrival {
  /// An encoder fills the stream as time passes. The camera never waits longer than a slice for it, and goes on with a
  /// frame in the next call. The stream begins with the time at which its first frame is asked for and has begun to
  /// arrive, and its counter starts over with every start of the software. Otherwise the stream is a recording: its
  /// first frame was taken at mission time 0, and reading waits for the source.
  bool live = false;
  /// Of a stream whose header states none.
  FrameRate rate = {};
};

/// Takes the luma of every frame; 8-bit 4:2:0, 4:1:1, 4:2:2, 4:4:4 and mono. Pictures that are larger than the flight's
/// images are reduced (find_reduction). Times follow from the stream's frame rate.
class Y4mCamera final : public Camera {
 public:
  /// Reads the stream's header. `parse_error` when it is malformed, `unsupported_format` for other samplings or depths
  /// (a = 3; bits_per_sample() tells them apart) or a missing rate (a = 4), `image_too_large`, `not_ready` when a live
  /// stream has no header after 10 s. The descriptor stays the caller's.
  Status open(int file, const Y4mArrival& arrival = {});
  /// Size of the stream's pictures.
  [[nodiscard]] std::int32_t width() const { return width_; }
  [[nodiscard]] std::int32_t height() const { return height_; }
  /// Of a header, also of one that open() has refused.
  [[nodiscard]] std::int32_t bits_per_sample() const { return bits_; }
  /// Whether the lines of a picture were taken at two times.
  [[nodiscard]] bool interlaced() const { return interlaced_; }
  /// Whether the header says that pixels are no squares.
  [[nodiscard]] bool pixels_are_wide() const {
    return aspect_width_ > 0 && aspect_height_ > 0 && aspect_width_ != aspect_height_;
  }
  /// What ended the stream before its end; ok otherwise.
  [[nodiscard]] Status broken() const { return broken_; }

  /// `truncated` or `parse_error` ends the stream, because the next frame of a damaged stream cannot be found.
  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool restarts_counter() const override { return live_; }

 private:
  /// The part of a frame that arrives next.
  enum class Part : std::uint8_t { line, luma, chroma };

  Status read_line();
  Status parse_header();
  Status due_time(TimeNs& due) const;
  Status read_frame(TimeNs now);
  Status read_luma();
  Status skip_chroma();

  BufferedReader reader_;
  char line_[256] = {};
  std::size_t line_size_ = 0, skipped_ = 0;
  bool in_comment_ = false;  ///< of the line
  FrameRate rate_;
  bool interlaced_ = false;
  std::int32_t bits_ = 8;
  std::int64_t aspect_width_ = 0, aspect_height_ = 0;
  Status broken_;
  std::int32_t width_ = 0, height_ = 0;
  std::int64_t rate_numerator_ = 0, rate_denominator_ = 0;
  std::size_t chroma_bytes_ = 0;
  std::int64_t sequence_ = 0;
  bool live_ = false;
  bool begun_ = false;  ///< the first frame has begun to arrive, at `begin_ns_`
  TimeNs begin_ns_ = 0;
  Part part_ = Part::line;
  std::size_t got_ = 0;  ///< bytes of the part that have arrived
  Reduction reduction_;
  RowReducer rows_;
  std::array<std::uint8_t, static_cast<std::size_t>(limits::max_sensor_side)> row_{};
  FrameImage luma_;
  bool ended_ = true;
};

}  // namespace ilp
