#include "sim/sil/world_camera.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>

#include "fsw/base/text.hpp"
#include "sim/io/image_io.hpp"
#include "sim/world/flight_check.hpp"
#include "sim/world/flight_files.hpp"

namespace ilp::sim {
namespace fs = std::filesystem;

WorldCamera::WorldCamera(const Scenario& scenario, fs::path folder, bool resume)
    : scenario_(scenario),
      folder_(std::move(folder)),
      terrain_(scenario.world),
      trajectory_(scenario.flight),
      renderer_(terrain_, scenario.flight.camera, scenario.effects, scenario.flight.seed) {
  check_flight(terrain_, scenario.flight.camera, fly(scenario.flight));
  const fs::path list = folder_ / "exposures.txt";
  if (resume) {
    std::ifstream earlier(list);
    if (!earlier) throw std::runtime_error(list.string() + ": the earlier exposures of the flight are not there");
    for (TimeNs time = 0; earlier >> time;) exposures_.push_back(trajectory_.at(time));
  } else {
    begin_flight_files(folder_, scenario);
  }
  list_.open(list, resume ? std::ios::app : std::ios::trunc);
  if (!list_) throw std::runtime_error(list.string() + ": cannot be written");
}

Status WorldCamera::trigger(TimeNs time) {
  trigger_ = (time + granularity_ns / 2) / granularity_ns * granularity_ns;
  return {};
}

std::size_t WorldCamera::expose(TimeNs time) {
  const auto known = std::find_if(exposures_.begin(), exposures_.end(),
                                  [&](const CameraState& state) { return state.time_ns == time; });
  const auto number = static_cast<std::size_t>(known - exposures_.begin()) + 1;
  renderer_.render(trajectory_.motion(time), static_cast<std::int64_t>(number), rendered_);
  if (known != exposures_.end()) return number;
  write_flight_frame(folder_, number, rendered_);
  exposures_.push_back(trajectory_.at(time));
  list_ << time << "\n" << std::flush;
  if (!list_) throw std::runtime_error((folder_ / "exposures.txt").string() + ": cannot be written");
  return number;
}

Status WorldCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  if (!trigger_ || *trigger_ > now || *trigger_ >= trajectory_.end_ns()) {
    return now >= trajectory_.end_ns() ? StatusCode::end_of_stream : StatusCode::not_ready;
  }
  const TimeNs time = *trigger_;
  trigger_.reset();
  const std::size_t number = expose(time);
  frame = {};
  frame.time_ns = time;
  frame.sequence = static_cast<std::int64_t>(number);
  if (scenario_.flight.altimeter) frame.altitude = height_above_ground(terrain_, exposures_[number - 1]);
  copy_text(frame.name, (frame_stem(number) + ".pgm").c_str());
  ILP_TRY(image.resize(rendered_.grey.width, rendered_.grey.height));
  std::copy(rendered_.grey.pixels.begin(), rendered_.grey.pixels.end(), image.view().data);
  return {};
}

void WorldCamera::finish(std::size_t threads) {
  end_flight_files(folder_, scenario_, terrain_, exposures_, threads);
}

}  // namespace ilp::sim
