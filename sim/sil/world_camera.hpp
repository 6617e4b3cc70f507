// A triggered camera on a simulated flight, which renders an image when it is triggered.
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

/// Exposes at the commanded time, rounded to 1 ms, until the flight ends. Every exposure is written to the flight's
/// folder (render_flight.hpp) and to exposures.txt. A resumed flight gets an exposure in exposures.txt again without a
/// new file. In real time (`as_time_passes`), rendering begins in another thread when the time is commanded; an image
/// that is not ready at its time is given later, with the commanded time. Without a command the camera exposes at the
/// scenario's regular times, and skips those that have passed.
class WorldCamera final : public Camera {
 public:
  static constexpr TimeNs step_ns = ns_per_ms;

  struct Options {
    bool resume = false;
    bool as_time_passes = false;  ///< real time
    bool unasked = false;         ///< exposes at the scenario's regular times in virtual time too
  };

  /// Throws std::invalid_argument if the flight cannot be rendered, and std::runtime_error if the folder cannot be
  /// written or, for `resume`, has no exposures.txt.
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
  /// Whether the commanded exposure is rendered. In real time the call begins to render the exposure if it is not.
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
  TimeNs latest_ns_ = -1;  ///< time of the newest image given in this boot
  std::optional<TimeNs> trigger_;
  struct Asked {
    ExposureSetting setting;
    std::int64_t images = 0;  ///< images still to be taken with the earlier setting
  };
  ExposureSetting setting_;  ///< of the next image; !known(): the flight cannot set it
  std::deque<Asked> asked_;
  std::ofstream list_;
  std::optional<Exposure> rendered_;
  std::future<Exposure> rendering_;  ///< last member, so that the thread ends before the members that it reads
};

}  // namespace ilp::sil
