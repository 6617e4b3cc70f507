// ilp-camera-check: tests a video camera before a flight with the flight's own code. It grades the driver and requests
// frames at regular times as the flight does. It prints the time differences between request and frame and all reports.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "bsp/linux/status_line.hpp"
#include "bsp/linux/video_camera.hpp"
#include "bsp/version/build_version.hpp"
#include "cfg/limits.hpp"
#include "cfg/schedule.hpp"
#include "cfg/version.hpp"
#include "hal/camera/v4l2/linux_video_device.hpp"

namespace {

using namespace ilp;

constexpr const char* usage =
    "Tests a video camera as the flight uses it: grades the driver, requests frames at regular times, and prints their "
    "time differences\n"
    "usage: ilp-camera-check DEVICE[,SETTING...] WIDTH HEIGHT [SECONDS [INTERVAL_S]]\n"
    "  settings as for ilp-onboard --v4l2 (docs/onboard.md); 30 seconds by default, a frame every second\n"
    "Example: ilp-camera-check /dev/video0,format=YUYV,rate=10 640 480 30\n"
    "Exit status: 0 done, 1 the camera cannot be used, 2 wrong call\n";

/// A flight waits for a camera that is not there; on the bench nobody wants to. True if the device can be opened.
bool is_there(const char* settings) {
  std::array<char, 256> path{};
  const std::size_t letters = std::strcspn(settings, ",");
  if (letters >= path.size()) return true;  // start() refuses it
  std::memcpy(path.data(), settings, letters);
  const int device = ::open(path.data(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (device >= 0) {
    ::close(device);
    return true;
  }
  const int error = errno;
  const char* advice = "see what the kernel says of it with `dmesg`";
  if (error == ENOENT || error == ENXIO || error == ENODEV)
    advice = "connect the camera, and name a device that `v4l2-ctl --list-devices` or `ls /dev/video*` shows";
  if (error == EACCES || error == EPERM) advice = "run as root, or add the user to the group of the device (video)";
  if (error == EBUSY) advice = "end the other program that uses the camera";
  std::fprintf(stderr, "ilp-camera-check: %s cannot be opened: %s; %s\n", path.data(), std::strerror(error), advice);
  return false;
}

constexpr TimeNs answer_patience_ns = 500 * ns_per_ms;  // in addition to the camera's granularity
constexpr std::size_t max_answers = 100'000;

volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int) {
  stop_requested = 1;
}

class Check {
 public:
  Check() : camera_(device_, clock_) {}

  Status start(const char* settings, std::int32_t width, std::int32_t height) {
    return start_video_camera(settings, width, height, clock_, camera_);
  }

  void run(TimeNs length, TimeNs interval) {
    const TimeNs begin = clock_.now();
    wanted_ns_ = begin + interval;
    TimeNs next = begin;
    while (stop_requested == 0 && clock_.now() < begin + length) {
      const TimeNs now = clock_.now();
      if (now > wanted_ns_ + camera_.granularity() + answer_patience_ns) {
        std::printf("%9.3f  no frame for %.3f\n", seconds(now), seconds(wanted_ns_));
        ++unanswered_;
        wanted_ns_ += interval;
      }
      listen(interval);
      longest_call_ns_ = std::max(longest_call_ns_, clock_.now() - now);
      next += minor_frame_ns;
      clock_.sleep_until(next);
    }
  }

  void print_summary() {
    std::sort(errors_ns_.begin(), errors_ns_.begin() + static_cast<std::ptrdiff_t>(answers_));
    std::printf("%zu frames, %d times without one; longest minor frame %.1f ms\n", answers_, unanswered_,
                static_cast<double>(longest_call_ns_) * 1e-6);
    if (answers_ == 0) return;
    std::printf("frame time minus wanted time, ms: least %.2f, 5 %% %.2f, median %.2f, 95 %% %.2f, most %.2f\n",
                error_ms(0), error_ms(5), error_ms(50), error_ms(95), error_ms(100));
  }

 private:
  static double seconds(TimeNs time) { return static_cast<double>(time) * 1e-9; }
  [[nodiscard]] double error_ms(std::size_t percent) const {
    return static_cast<double>(errors_ns_[(answers_ - 1) * percent / 100]) * 1e-6;
  }

  /// Takes the camera's reports and frames of this minor frame.
  void listen(TimeNs interval) {
    constexpr int most_answers = 64;
    for (int i = 0; i < most_answers; ++i) {
      static_cast<void>(camera_.trigger(wanted_ns_));
      const TimeNs now = clock_.now();
      CameraFrame frame;
      const Status status = camera_.capture(now, image_, frame);
      if (status.is(StatusCode::not_ready)) return;
      if (!status.ok()) {
        std::printf("%9.3f  %s: %s\n", seconds(now), status_name(status.code), status_words(status).c_str());
        continue;
      }
      if (answers_ < max_answers) errors_ns_[answers_++] = frame.time_ns - wanted_ns_;
      wanted_ns_ += interval;
    }
  }

  LinuxVideoDevice device_;
  RealClock clock_;
  V4l2Camera camera_;
  FrameImage image_;
  TimeNs wanted_ns_ = 0;
  std::array<TimeNs, max_answers> errors_ns_{};
  std::size_t answers_ = 0;
  int unanswered_ = 0;
  TimeNs longest_call_ns_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::strcmp(argv[1], "--version") == 0) {
    std::printf("ilp-camera-check %s, commit %s, profile %s\n", ilp::software_version, ilp::build_commit(),
                ilp::limits::profile);
    return 0;
  }
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) {
    std::fputs(usage, stdout);
    return 0;
  }
  if (argc < 4 || argc > 6) {
    std::fputs(usage, stderr);
    return 2;
  }
  const double length_s = argc > 4 ? std::strtod(argv[4], nullptr) : 30;
  const double interval_s = argc > 5 ? std::strtod(argv[5], nullptr) : 1;
  if (!(length_s > 0 && length_s < 1e6 && interval_s >= 0.01 && interval_s < 1e6)) {
    std::fputs(usage, stderr);
    return 2;
  }
  if (!is_there(argv[1])) return 1;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  std::signal(SIGTERM, request_stop);
  std::signal(SIGINT, request_stop);
  static Check check;
  const Status status = check.start(argv[1], static_cast<std::int32_t>(std::strtol(argv[2], nullptr, 10)),
                                    static_cast<std::int32_t>(std::strtol(argv[3], nullptr, 10)));
  if (!status.ok()) {
    std::fprintf(stderr, "ilp-camera-check: %s: %s\n", status_words(status).c_str(), status_advice(status.code));
    return 1;
  }
  check.run(ns_from_seconds(length_s), ns_from_seconds(interval_s));
  check.print_summary();
  return 0;
}
