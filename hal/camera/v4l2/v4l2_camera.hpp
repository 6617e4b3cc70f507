// Drives a free-running camera through Linux's V4L2 interface and delivers the frames nearest to the wanted times.
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

/// Incidents of one kind since the latest report. They are reported together at intervals, so that a camera that is
/// always wrong does not fill the store with events.
struct CameraTally {
  std::int64_t count = 0;   ///< number of incidents
  std::int64_t latest = 0;  ///< value of the latest incident
};
struct CameraReports {
  CameraUpdates updates;  ///< statuses that the next calls of capture() return, one in each call
  /// Damaged frames (value: FrameDamage), suspect stamps (value: stamp minus arrival, us), and missing frames (value:
  /// sequence number of the frame after the gap).
  CameraTally refused, stamps, gaps;
  bool tallied = false;   ///< `tallied_ns` is valid
  TimeNs tallied_ns = 0;  ///< when the incidents were last reported
};

/// An outage lasts from the first failure until consistent frames arrive again.
struct CameraOutage {
  bool out = false;
  bool ever_recovered = false;
  TimeNs since_ns = 0;                                   ///< first failure
  TimeNs recovered_ns = 0;                               ///< end of the outage before
  TimeNs retry_ns = std::numeric_limits<TimeNs>::min();  ///< no attempt is made before this time
  TimeNs pause_ns = 0;                                   ///< next pause between attempts; it grows
  std::int32_t attempts = 0;
  Status reported;  ///< reason that capture() has returned last
  Status latest;    ///< latest reason
};

/// The driver's sequence numbers.
struct DriverSequence {
  std::uint32_t latest = 0;
  bool any = false;  ///< `latest` is valid
};

/// A frame that stays in the driver's buffer.
struct HeldFrame {
  VideoBuffer buffer;
  TimeNs time_ns = 0;  ///< start of exposure, mission time
  TimeMeaning meaning = TimeMeaning::arrival;
};
struct HeldFrames {
  FixedVector<HeldFrame, limits::max_held_frames + 1> frames;  ///< in order of time
  bool wanted = false;                                         ///< there is a pending trigger
  TimeNs wanted_ns = 0;                                        ///< time of the latest trigger, or `any_time`
  TimeNs hopeless_ns = Camera::any_time;                       ///< latest trigger for which no frame was near enough
};

/// Exposure that the flight has set.
struct OwnExposure {
  bool set = false;  ///< set_exposure() was successful
  /// The latest requested setting, and the settings in force before and after `set_ns`.
  ExposureSetting asked, before, now;
  TimeNs set_ns = 0;
};

/// To the flight this is a triggered camera with a coarse granularity. The answer to a trigger is the frame whose
/// exposure began nearest to the trigger's time. The newest frames stay in the driver's buffers until that frame is
/// known; all others are returned unread. Only prepare(), exposure_range() and set_exposure() block. Every other call
/// with unfinished work returns `not_ready`, and the next call continues the work. Opening the camera takes several
/// calls of capture().
///
/// No report of the driver is trusted. Its first frames are graded (DriverGrade) before any frame is delivered. After
/// an outage the stream or the device is started again at growing intervals. A device with another name is graded and
/// reported like a new one. The Status of capture() reports these incidents: camera_fault, camera_absent,
/// camera_changed (another device than the first one), camera_silent, camera_recovered, camera_graded,
/// camera_distrusted, camera_frames_refused, camera_stamps_refused, frame_gap and the statuses of negotiate() and
/// set_controls().
class V4l2Camera final : public Camera {
 public:
  V4l2Camera(VideoDevice& device, Clock& clock) : clock_(clock), device_(device), pool_(device) {}
  ~V4l2Camera();

  /// Sets options and the size of the device's pictures, px; other sizes are refused. Images have the size that
  /// find_reduction() gives. Mission time is the monotonic clock plus `mission_minus_monotonic`. Returns
  /// `image_too_large` if there is no reduction or an image would be smaller than limits::min_image_side.
  Status configure(const V4l2Options& options, std::int32_t width, std::int32_t height, TimeNs mission_minus_monotonic);
  /// Call it after mission time was set.
  void set_mission_minus_monotonic(TimeNs offset) { mission_minus_monotonic_ = offset; }
  /// For start-up: opens the camera and waits for the verdict on its driver, at most `limit`. Without a verdict it
  /// returns the latest failure, or `not_ready` if there was none; capture() then continues.
  Status prepare(TimeNs limit);

  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool triggered() const override { return true; }
  Status trigger(TimeNs time) override;
  [[nodiscard]] bool restarts_counter() const override { return true; }
  /// exposure_range() and set_exposure() block while the driver sets controls: a few milliseconds on USB.
  Status exposure_range(ExposureRange& range) override;
  Status set_exposure(ExposureSetting& setting) override;
  /// The exposure of a delivered frame differs from its trigger by at most this time.
  [[nodiscard]] TimeNs granularity() const override;

  /// The verdict on the driver's first frames; `frames` is 0 while there is none.
  [[nodiscard]] const CameraVerdict& verdict() const { return verdict_; }
  [[nodiscard]] const VideoFormat& format() const { return format_; }
  [[nodiscard]] const Reduction& reduction() const { return reduction_; }

 private:
  /// Progress of opening the camera; `agreed`: the format was negotiated.
  enum class Stage : std::uint8_t { closed, open, agreed, mapped, streaming };

  /// Takes one step towards `streaming`, unless the pause after a failure lasts.
  Status advance(TimeNs now);
  Status advance_from(Stage stage, TimeNs now);
  /// Compares the device with the latest one.
  void meet(const DeviceName& name);
  void begin_stream(TimeNs now);
  /// Begins or continues an outage. Returns the reason if it is new, else `not_ready`.
  Status fail(const Status& reason, TimeNs now);
  /// Closes the device.
  void let_go();

  /// Takes frames from the driver until the frame for the trigger is known or none is left.
  Status collect();
  /// Estimates the time of a frame. Returns true if `frame` may be delivered.
  bool evaluate(const VideoBuffer& buffer, TimeNs now, HeldFrame& frame);
  void grade(const FrameArrival& arrival);
  /// Converts the frame nearest to the trigger and releases it and all earlier ones.
  Status deliver(FrameImage& image, CameraFrame& frame);

  Clock& clock_;
  VideoDevice& device_;
  BufferPool pool_;
  V4l2Options options_;
  std::int32_t width_ = 0, height_ = 0;
  TimeNs mission_minus_monotonic_ = 0;

  Stage stage_ = Stage::closed;
  DeviceName first_name_, name_;  ///< names of the first device that gave frames, and of the latest device
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
  std::int32_t consistent_ = 0;  ///< consecutive undamaged frames since the stream began, up to a limit
  TimeNs received_ns_ = 0;       ///< when the driver last gave a frame
  TimeNs empty_ns_ = 0;          ///< when the driver last had no frame
  DriverSequence driver_sequence_;

  HeldFrames held_;
  std::int64_t sequence_ = 0;
  OwnExposure exposure_;
};

/// Whether the status means that the device cannot deliver what was requested, so that trying again is useless.
[[nodiscard]] bool is_refusal(const Status& status);

}  // namespace ilp
