// A free-running camera driven through Linux's V4L2 interface, which selects the frames nearest to the wanted times.
#pragma once

#include "fsw/base/status_values.hpp"
#include "hal/camera/camera.hpp"
#include "hal/camera/v4l2/buffer_pool.hpp"
#include "hal/camera/v4l2/driver_grade.hpp"
#include "hal/camera/v4l2/frame_clock.hpp"
#include "hal/camera/v4l2/grey_picture.hpp"
#include "hal/camera/v4l2/video_format.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

/// Counts that are reported together at intervals, so that a camera that is always wrong does not fill the store with
/// events.
struct CameraTally {
  std::int64_t count = 0;
  std::int64_t latest = 0;
};
struct CameraReports {
  CameraUpdates updates;
  CameraTally refused, stamps, gaps;
  bool tallied = false;
  TimeNs tallied_ns = 0;
};

/// From the first failure to the first consistent frame.
struct CameraOutage {
  bool out = false;
  bool ever_recovered = false;
  TimeNs since_ns = 0;
  TimeNs recovered_ns = 0;
  TimeNs retry_ns = std::numeric_limits<TimeNs>::min();
  TimeNs pause_ns = 0;
  std::int32_t attempts = 0;
  Status reported;
  Status latest;
};

/// Numbers that the driver gives its frames.
struct DriverSequence {
  std::uint32_t latest = 0;
  bool any = false;
};

struct HeldFrame {
  VideoBuffer buffer;
  TimeNs time_ns = 0;
  TimeMeaning meaning = TimeMeaning::arrival;
};
struct HeldFrames {
  FixedVector<HeldFrame, limits::max_held_frames + 1> frames;  ///< in order of time
  bool wanted = false;
  TimeNs wanted_ns = 0;
  TimeNs hopeless_ns = Camera::any_time;  ///< a wanted time without a frame that is near enough
};

/// Once the flight sets the exposure.
struct OwnExposure {
  bool set = false;
  ExposureSetting asked, before, now;
  TimeNs set_ns = 0;
};

/// To the flight it is a triggered camera with a coarse granularity: the answer to a trigger is the frame whose
/// exposure began nearest to its time. The newest frames stay in the driver's buffers until that one is known; all
/// others are returned unread. No call blocks: an unfinished one returns `not_ready` and the next call continues it.
/// Opening takes one step per call.
///
/// No report of the driver is trusted. Its first frames are graded (DriverGrade) before any is delivered. After an
/// outage of any kind the stream, or the device, is started again at growing intervals. A device with another name is
/// graded and reported like a new one. The Status of `capture` reports this: camera_fault, camera_absent,
/// camera_changed (another device than the first one), camera_silent, camera_recovered, camera_graded,
/// camera_distrusted, camera_frames_refused, camera_stamps_refused, frame_gap and the reports of negotiation.
class V4l2Camera final : public Camera {
 public:
  V4l2Camera(VideoDevice& device, Clock& clock) : clock_(clock), device_(device), pool_(device) {}
  ~V4l2Camera();

  /// Mission time is the monotonic clock plus `mission_minus_monotonic`. Frames of another size than `width` x `height`
  /// are refused; the images are those of find_reduction() for this size. `image_too_large`.
  Status configure(const V4l2Options& options, std::int32_t width, std::int32_t height, TimeNs mission_minus_monotonic);
  /// Mission time was set.
  void set_mission_minus_monotonic(TimeNs offset) { mission_minus_monotonic_ = offset; }
  /// For start-up: opens the camera and waits for its verdict, `limit` at most. Without a verdict it returns the latest
  /// reason, `not_ready` if the camera is only slow; `capture` continues from there.
  Status prepare(TimeNs limit);

  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool triggered() const override { return true; }
  Status trigger(TimeNs time) override;
  [[nodiscard]] bool restarts_counter() const override { return true; }
  /// These wait for the driver as long as it takes to set a control, a few milliseconds on USB.
  Status exposure_range(ExposureRange& range) override;
  Status set_exposure(ExposureSetting& setting) override;
  /// Every delivered frame is at most this far from its trigger.
  [[nodiscard]] TimeNs granularity() const override;

  /// The verdict on the driver's first frames; with `frames` == 0 there is none yet.
  [[nodiscard]] const CameraVerdict& verdict() const { return verdict_; }
  [[nodiscard]] const VideoFormat& format() const { return format_; }
  [[nodiscard]] const Reduction& reduction() const { return reduction_; }

 private:
  enum class Stage : std::uint8_t { closed, open, agreed, mapped, streaming };

  Status advance(TimeNs now);
  Status advance_from(Stage stage, TimeNs now);
  void meet(const DeviceName& name);
  void begin_stream(TimeNs now);
  Status fail(const Status& reason, TimeNs now);
  void let_go();

  Status collect();
  /// True when `frame` may be delivered.
  bool evaluate(const VideoBuffer& buffer, TimeNs now, HeldFrame& frame);
  void grade(const FrameArrival& arrival);
  Status deliver(FrameImage& image, CameraFrame& frame);

  Clock& clock_;
  VideoDevice& device_;
  BufferPool pool_;
  V4l2Options options_;
  std::int32_t width_ = 0, height_ = 0;
  TimeNs mission_minus_monotonic_ = 0;

  Stage stage_ = Stage::closed;
  DeviceName first_name_, name_;  ///< of the first device that gave frames, and of the latest one
  VideoFormat format_;
  Reduction reduction_;
  GreyConverter converter_;
  CameraReports reports_;
  CameraOutage outage_;
  bool ever_delivered_ = false;
  bool known_ = false;  ///< the latest device has delivered

  DriverGrade grade_;
  bool grading_ = false;
  CameraVerdict verdict_;
  FrameClock frame_clock_;
  std::int32_t consistent_ = 0;
  TimeNs received_ns_ = 0;  ///< when the driver last gave a frame
  TimeNs empty_ns_ = 0;     ///< when the driver last had no frame
  DriverSequence driver_sequence_;

  HeldFrames held_;
  std::int64_t sequence_ = 0;
  OwnExposure exposure_;
};

/// The camera cannot deliver what was requested, and further attempts cannot change that.
[[nodiscard]] bool is_refusal(const Status& status);

}  // namespace ilp
