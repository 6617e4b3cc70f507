// The capture clock over a camera that the test triggers in thought.
#pragma once

#include <memory>
#include <vector>

#include "fsw/imaging/capture_clock.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp::test {

inline TimeNs at_s(double seconds) {
  return static_cast<TimeNs>(seconds * 1e9 + 0.5);
}

class IdleCamera final : public Camera {
 public:
  Status capture(TimeNs, FrameImage&, CameraFrame&) override { return StatusCode::not_ready; }
  [[nodiscard]] bool triggered() const override { return is_triggered; }
  bool is_triggered = true;
};

class CaptureFixture : public ComponentTest {
 protected:
  /// Its id.
  std::int64_t send(CommandRecord command) {
    command.id = number_of<CommandRecord>() + 1;
    command.time_ns = clock.now();
    write(command);
    return command.id;
  }
  /// A record without an id where the command has no capture.
  CaptureRecord of_command(std::int64_t command) {
    for (const CaptureRecord& capture : records_of<CaptureRecord>(store)) {
      if (capture.command_id == command) return capture;
    }
    return {};
  }

  std::int64_t keyframes = 0;
  std::vector<Status> faults;
  IdleCamera camera;
  std::unique_ptr<CaptureClock> planner;
};

}  // namespace ilp::test
