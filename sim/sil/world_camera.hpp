// A triggered camera on a simulated flight: its image is rendered when it is triggered.
#pragma once

#include <deque>
#include <filesystem>
#include <fstream>
#include <future>
#include <optional>
#include <vector>

#include "hal/camera/camera.hpp"
#include "sim/world/flight_renderer.hpp"
#include "sim/world/scenario.hpp"

namespace ilp::sil {

/// Exposes at the commanded time, to the millisecond; ends with the flight. Every exposure becomes files of the
/// flight's folder (render_flight.hpp) and a line of exposures.txt, so that a resumed flight goes on: an exposure that
/// is already there is given again. `as_time_passes`: in real time. It renders beside the flight, from when it is told
/// of a time; an image that is not ready at its time is given later, with its own time. Unasked it exposes at the
/// scenario's regular times, and leaves those out that it comes too late for.
class WorldCamera final : public Camera {
 public:
  static constexpr TimeNs step_ns = ns_per_ms;

  struct Options {
    bool resume = false;
    bool as_time_passes = false;
    bool unasked = false;  ///< it also exposes at the scenario's regular times in virtual time
  };

  /// std::invalid_argument for a flight that cannot be rendered, std::runtime_error for a folder that cannot be written
  /// or, with `resume`, does not hold the earlier exposures.
  WorldCamera(const world::Scenario& scenario, std::filesystem::path folder, const Options& options);

  Status capture(TimeNs now, FrameImage& image, CameraFrame& frame) override;
  [[nodiscard]] bool triggered() const override { return true; }
  [[nodiscard]] bool exposes_unasked() const override { return options_.as_time_passes || options_.unasked; }
  Status trigger(TimeNs time) override;
  Status exposure_range(ExposureRange& range) override;
  Status set_exposure(ExposureSetting& setting) override;

  /// Writes the truth of all exposures.
  void finish(std::size_t threads);

 private:
  struct Exposure {
    TimeNs time = 0;
    std::size_t number = 0;  ///< counted from 1
    ExposureSetting setting;
    world::RenderedFrame picture;
  };
  [[nodiscard]] Exposure render(TimeNs time, std::size_t number, const ExposureSetting& setting) const;
  [[nodiscard]] std::size_t number_at(TimeNs time) const;
  [[nodiscard]] TimeNs next_regular() const;
  /// Whether the wanted exposure is rendered. In real time the call begins to render it if it is not.
  bool ready();
  void keep(const Exposure& exposure);
  void set_shutter(TimeNs time);
  void count_down();
  void take_over();

  world::Scenario scenario_;
  std::filesystem::path folder_;
  Options options_;
  world::FlightRenderer renderer_;
  std::vector<world::CameraState> exposures_;
  TimeNs now_ = 0;
  TimeNs latest_ns_ = -1;  ///< that was given in this boot
  std::optional<TimeNs> trigger_;
  struct Asked {
    ExposureSetting setting;
    std::int64_t images = 0;  ///< that it still takes with the earlier one
  };
  ExposureSetting setting_;  ///< of the next image; not known: the flight cannot set it
  std::deque<Asked> asked_;
  std::ofstream list_;
  std::optional<Exposure> rendered_;
  std::future<Exposure> rendering_;  ///< last: what it reads outlives it
};

}  // namespace ilp::sil
