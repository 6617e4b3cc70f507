// A camera that reads a YUV4MPEG2 stream from a file descriptor. Common video tools write such streams.
#pragma once

#include <array>

#include "hal/camera/camera.hpp"
#include "hal/camera/picture/reduction.hpp"
#include "hal/posix/buffered_reader.hpp"

namespace ilp {

/// The frame rate `frames` / `seconds`; both 0: not known.
struct FrameRate {
  std::int64_t frames = 0, seconds = 0;
};

/// How a stream arrives, and when it begins.
struct Y4mArrival {
  /// True: an encoder fills the stream as time passes. capture() waits at most 20 ms for it and continues an incomplete
  /// frame in the next call. The first frame has the mission time at which capture() finds that it has begun to arrive.
  /// The frame counter starts again with every start of the software.
  ///
  /// False: the stream is a recording. The first frame has mission time 0, and reading waits for the source.
  bool live = false;
  /// Frame rate of a stream whose header states none.
  FrameRate rate = {};
};

/// Reads the luma of every frame. Accepts 8-bit 4:2:0, 4:1:1, 4:2:2, 4:4:4 and mono. Pictures that are larger than the
/// flight's images are reduced (find_reduction). The times of frames follow from the stream's frame rate.
class Y4mCamera final : public Camera {
 public:
  /// Reads the stream's header. The caller closes the descriptor. Returns `parse_error` if the header is malformed,
  /// `truncated` if the stream ends within it, `not_ready` if a live stream has no header after 10 s, and
  /// `image_too_large` as find_reduction(). Returns `unsupported_format` (first value: FormatFault) for another
  /// sampling, for other than 8 bits (see bits_per_sample()), or if no frame rate is known.
  Status open(int file, const Y4mArrival& arrival = {});
  /// Width and height of the stream's pictures, px.
  [[nodiscard]] std::int32_t width() const { return width_; }
  [[nodiscard]] std::int32_t height() const { return height_; }
  /// Bits of a sample in the latest header, also if open() has refused it.
  [[nodiscard]] std::int32_t bits_per_sample() const { return bits_; }
  /// Whether a picture consists of two fields that were exposed at different times.
  [[nodiscard]] bool interlaced() const { return interlaced_; }
  /// Whether the header states pixels that are not square.
  [[nodiscard]] bool pixels_are_wide() const {
    return aspect_width_ > 0 && aspect_height_ > 0 && aspect_width_ != aspect_height_;
  }
  /// The error at which capture() stopped reading; ok: none.
  [[nodiscard]] Status broken() const { return broken_; }

  /// Returns `truncated` or `parse_error` for a damaged frame. That ends the stream, because the beginning of the next
  /// frame cannot be found.
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
  bool in_comment_ = false;  ///< the next byte belongs to a comment of the line
  FrameRate rate_;           ///< Y4mArrival::rate
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
