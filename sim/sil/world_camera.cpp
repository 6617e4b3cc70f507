#include "sim/sil/world_camera.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

#include "fsw/base/text.hpp"
#include "sim/host/image_io.hpp"
#include "sim/world/flight.hpp"
#include "sim/world/render_flight.hpp"

namespace ilp::sil {
namespace fs = std::filesystem;

WorldCamera::WorldCamera(const world::Scenario& scenario, fs::path folder, const Options& options)
    : scenario_(scenario), folder_(std::move(folder)), options_(options), renderer_(scenario) {
  const world::CameraEffects& effects = scenario.effects;
  if (effects.settable_us > 0) {
    setting_.exposure_us = std::llround(effects.first_us > 0 ? effects.first_us : effects.settable_us);
  }
  world::check_flight(renderer_.terrain(), scenario.flight.camera, fly(scenario.flight));
  const fs::path list = folder_ / "exposures.txt";
  if (options.resume) {
    std::ifstream earlier(list);
    if (!earlier) throw std::runtime_error(list.string() + ": the earlier exposures of the flight are not there");
    for (TimeNs time = 0; earlier >> time;) exposures_.push_back(renderer_.trajectory().at(time));
  } else {
    world::begin_flight_files(folder_, scenario, renderer_.terrain());
  }
  list_.open(list, options.resume ? std::ios::app : std::ios::trunc);
  if (!list_) throw std::runtime_error(list.string() + ": cannot be written");
}

Status WorldCamera::trigger(TimeNs time) {
  if (time == any_time) {
    trigger_ = next_regular();
  } else {
    trigger_ = (time + step_ns / 2) / step_ns * step_ns;
  }
  if (options_.as_time_passes) ready();
  return {};
}

TimeNs WorldCamera::next_regular() const {
  // What is being rendered stays wanted, though it was not ready in time.
  if (trigger_ && *trigger_ > latest_ns_) {
    const auto& regular = renderer_.trajectory().exposures();
    if (std::binary_search(regular.begin(), regular.end(), *trigger_)) return *trigger_;
  }
  const auto& regular = renderer_.trajectory().exposures();
  const auto found = std::upper_bound(regular.begin(), regular.end(), std::max(latest_ns_, now_ - 1));
  return found != regular.end() ? *found : renderer_.trajectory().end_ns();
}

WorldCamera::Exposure WorldCamera::render(TimeNs time, std::size_t number, const ExposureSetting& setting) const {
  Exposure exposure;
  exposure.time = time;
  exposure.number = number;
  exposure.setting = setting;
  renderer_.render(time, static_cast<std::int64_t>(number), exposure.picture);
  return exposure;
}

std::size_t WorldCamera::number_at(TimeNs time) const {
  const auto known = std::find_if(exposures_.begin(), exposures_.end(),
                                  [&](const world::CameraState& state) { return state.time_ns == time; });
  return static_cast<std::size_t>(known - exposures_.begin()) + 1;
}

bool WorldCamera::ready() {
  const TimeNs time = *trigger_;
  if (time < 0 || time >= renderer_.trajectory().end_ns()) return false;
  if (!options_.as_time_passes) {
    set_shutter(time);
    rendered_ = render(time, number_at(time), setting_);
  }
  if (rendering_.valid() && rendering_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
    rendered_ = rendering_.get();
  }
  if (rendered_ && rendered_->time == time) return true;
  if (!rendering_.valid()) {
    rendered_.reset();
    set_shutter(time);
    rendering_ = std::async(std::launch::async, [this, time, number = number_at(time), setting = setting_] {
      return render(time, number, setting);
    });
  }
  return false;
}

void WorldCamera::keep(const Exposure& exposure) {
  if (exposure.number <= exposures_.size()) return;
  world::write_flight_frame(folder_, exposure.number, exposure.picture);
  exposures_.push_back(renderer_.trajectory().at(exposure.time));
  list_ << exposure.time << "\n" << std::flush;
  if (!list_) throw std::runtime_error((folder_ / "exposures.txt").string() + ": cannot be written");
}

Status WorldCamera::exposure_range(ExposureRange& range) {
  if (!setting_.known()) return StatusCode::camera_control_missing;
  range = {.least_us = 10, .most_us = 1'000'000, .step_us = 10, .least_gain_milli = 1000, .most_gain_milli = 16'000};
  return {};
}

Status WorldCamera::set_exposure(ExposureSetting& setting) {
  if (!setting_.known()) return StatusCode::camera_control_missing;
  asked_.push_back({setting, static_cast<std::int64_t>(scenario_.effects.obeys_after)});
  take_over();
  return {};
}

/// An image has been taken.
void WorldCamera::count_down() {
  for (Asked& asked : asked_) --asked.images;
  take_over();
}

/// Settings whose time has come are those of the next image.
void WorldCamera::take_over() {
  while (!asked_.empty() && asked_.front().images <= 0) {
    setting_ = asked_.front().setting;
    asked_.pop_front();
  }
}

void WorldCamera::set_shutter(TimeNs time) {
  if (!setting_.known()) return;
  renderer_.set_effects(world::exposed_with(scenario_.effects, static_cast<double>(setting_.exposure_us),
                                            1e-3 * static_cast<double>(setting_.gain_milli),
                                            world::light_at(scenario_.effects, time)));
}

Status WorldCamera::capture(TimeNs now, FrameImage& image, CameraFrame& frame) {
  now_ = now;
  if (!trigger_ || *trigger_ > now || *trigger_ >= renderer_.trajectory().end_ns()) {
    return now >= renderer_.trajectory().end_ns() ? StatusCode::end_of_stream : StatusCode::not_ready;
  }
  if (!ready()) return StatusCode::not_ready;
  trigger_.reset();
  const Exposure exposure = std::move(*rendered_);
  rendered_.reset();
  latest_ns_ = std::max(latest_ns_, exposure.time);
  keep(exposure);
  count_down();
  frame = {};
  frame.exposure = exposure.setting;
  frame.time_ns = exposure.time;
  frame.sequence = static_cast<std::int64_t>(exposure.number);
  if (scenario_.flight.altimeter)
    frame.altitude = world::height_above_ground(renderer_.terrain(), exposures_[exposure.number - 1]);
  copy_text(frame.name, (world::frame_stem(exposure.number) + ".pgm").c_str());
  ILP_TRY(image.resize(exposure.picture.grey.width, exposure.picture.grey.height));
  std::copy(exposure.picture.grey.samples.begin(), exposure.picture.grey.samples.end(), image.view().data);
  return {};
}

void WorldCamera::finish(std::size_t threads) {
  world::end_flight_files(folder_, scenario_, renderer_.terrain(), exposures_, threads);
}

}  // namespace ilp::sil
