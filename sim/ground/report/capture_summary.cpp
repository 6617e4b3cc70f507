#include "sim/ground/report/capture_summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim/host/status_error.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::report {
namespace {

// The checker makes a keyframe of the frame itself; otherwise the one that it was compared with stays the latest.
std::int64_t latest_keyframe_after(const intake::Flight& flight, const OverlapRecord& overlap) {
  const auto decision = overlap.decision;
  if (decision != OverlapDecision::selected && decision != OverlapDecision::new_strip) return overlap.keyframe_id;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.record && keyframe.record->frame_id == overlap.id) return id;
  }
  return 0;
}

// A capture is planned once the overlap of the last frame before it is known. 0 when that is not on record.
std::int64_t keyframe_of_forecast(const intake::Flight& flight, const CaptureRecord& capture) {
  auto frame = flight.frames.lower_bound(capture.frame_id);
  while (frame != flight.frames.begin()) {
    --frame;
    const auto overlap = flight.overlaps.find(frame->first);
    if (frame->second.time_ns > capture.issued_ns || overlap == flight.overlaps.end()) continue;
    const std::int64_t keyframe = latest_keyframe_after(flight, overlap->second);
    if (keyframe != 0) return keyframe;
  }
  return 0;
}

bool is_overlap(double value) {
  return value >= 0 && value <= 1;
}

std::int64_t keyframe_of_frame(const intake::Flight& flight, std::int64_t frame_id) {
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.record && keyframe.record->frame_id == frame_id) return id;
  }
  return 0;
}

void check_forecast(const intake::Flight& flight, const CaptureRecord& capture, CaptureSummary& summary) {
  if (capture.state != CaptureState::exposed || !is_overlap(capture.overlap)) return;
  const auto found = flight.overlaps.find(capture.frame_id);
  if (found == flight.overlaps.end() || found->second.verdict != OverlapVerdict::ok || found->second.keyframe_id == 0 ||
      !is_overlap(found->second.overlap) || found->second.keyframe_id != keyframe_of_forecast(flight, capture)) {
    ++summary.forecasts_unchecked;
    return;
  }
  ForecastCheck check;
  check.capture_id = capture.id;
  check.keyframe_id = keyframe_of_frame(flight, capture.frame_id);
  check.source = source_index(capture);
  check.forecast = capture.overlap;
  check.measured = found->second.overlap;
  if (std::isfinite(capture.overlap_sigma) && capture.overlap_sigma > 0) check.sigma = capture.overlap_sigma;
  summary.forecasts.push_back(check);
}

void summarise_forecasts(CaptureSummary& summary) {
  std::vector<double> errors;
  std::size_t inside_1 = 0, inside_2 = 0;
  for (const ForecastCheck& check : summary.forecasts) {
    errors.push_back(check.error());
    if (!std::isfinite(check.sigma)) continue;
    ++summary.with_sigma;
    inside_1 += std::fabs(check.error()) <= check.sigma ? 1U : 0U;
    inside_2 += std::fabs(check.error()) <= 2 * check.sigma ? 1U : 0U;
  }
  summary.forecast_error = spread_of(errors);
  if (summary.with_sigma == 0) return;
  summary.within_1_sigma = static_cast<double>(inside_1) / static_cast<double>(summary.with_sigma);
  summary.within_2_sigma = static_cast<double>(inside_2) / static_cast<double>(summary.with_sigma);
}

const EventRecord* event_of(const intake::Flight& flight, StatusCode code, std::int64_t number) {
  for (const EventRecord& event : flight.events) {
    if (event.code == static_cast<std::uint16_t>(code) && event.a == number) return &event;
  }
  return nullptr;
}

bool too_many_ahead(const intake::Flight& flight) {
  return std::any_of(flight.events.begin(), flight.events.end(), [](const EventRecord& event) {
    return event.code == static_cast<std::uint16_t>(StatusCode::capacity_exceeded) &&
           std::strncmp(event.component, "capture_clock", sizeof(event.component)) == 0;
  });
}

double milliseconds_between(TimeNs from, TimeNs to) {
  return (static_cast<double>(to) - static_cast<double>(from)) / 1e6;
}

std::string rejection(const intake::Flight& flight, const CaptureRecord& capture) {
  if (capture.requested_ns < capture.issued_ns) {
    return "in the past by " +
           host::duration_text(milliseconds_between(capture.requested_ns, capture.issued_ns) / 1e3) +
           " when it arrived";
  }
  if (const EventRecord* event = event_of(flight, StatusCode::capture_too_soon, capture.command_id)) {
    return "nearer to another capture than the camera's least interval of " +
           host::duration_text(static_cast<double>(event->b) / 1e6);
  }
  return too_many_ahead(flight) ? "too many captures were commanded ahead"
                                : "too near to another capture, or too many commanded ahead";
}

std::string time_remark(const intake::Flight& flight, const CaptureRecord& capture) {
  const auto frame = flight.frames.find(capture.frame_id);
  if (frame == flight.frames.end()) return "no record of its frame";
  if (frame->second.time_doubt == TimeDoubt::none) return "";
  return frame->second.time_doubt == TimeDoubt::off_command
             ? "stamped far from the command: the commanded time stands"
             : "stamped far from the camera's period: the period's time stands";
}

}  // namespace

std::size_t source_index(const CaptureRecord& capture) {
  return std::min(static_cast<std::size_t>(capture.source), capture_sources - 1);
}

std::size_t state_index(const CaptureRecord& capture) {
  return std::min(static_cast<std::size_t>(capture.state), capture_states - 1);
}

const char* capture_source_words(std::size_t source) {
  constexpr std::array<const char*, capture_sources> words{"regular",     "forecast", "on the way",    "safe interval",
                                                           "telecommand", "burst",    "unknown source"};
  return words[std::min(source, capture_sources - 1)];
}

const char* capture_state_words(std::size_t state) {
  constexpr std::array<const char*, capture_states> words{"pending",  "exposed",    "no frame",
                                                          "rejected", "superseded", "unknown state"};
  return words[std::min(state, capture_states - 1)];
}

Spread spread_of(const std::vector<double>& sample) {
  Spread spread;
  spread.count = sample.size();
  const auto count = static_cast<double>(sample.size());
  if (sample.empty()) return spread;
  spread.mean = 0;
  for (const double value : sample) spread.mean += value / count;
  if (sample.size() < 2) return spread;
  double squares = 0;
  for (const double value : sample) squares += (value - spread.mean) * (value - spread.mean);
  spread.deviation = std::sqrt(squares / (count - 1));
  return spread;
}

CaptureSummary summarise_captures(const intake::Flight& flight, double target_overlap) {
  CaptureSummary summary;
  for (const auto& [id, capture] : flight.captures) {
    ++summary.counts[source_index(capture)][state_index(capture)];
    ++summary.by_state[state_index(capture)];
    check_forecast(flight, capture, summary);
  }
  summarise_forecasts(summary);
  std::vector<double> achieved;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (!keyframe.record || keyframe.record->index <= 0 || !is_overlap(keyframe.record->overlap)) continue;
    if (std::isfinite(target_overlap)) achieved.push_back(keyframe.record->overlap - target_overlap);
  }
  summary.achieved = spread_of(achieved);
  if (!flight.keyframes.empty() && !flight.frames.empty()) {
    summary.frames_per_keyframe =
        static_cast<double>(flight.frames.size()) / static_cast<double>(flight.keyframes.size());
  }
  return summary;
}

bool is_telecommanded(const CaptureRecord& capture) {
  return capture.source == CaptureSource::telecommand;
}

double exposure_delay_ms(const CaptureRecord& capture) {
  if (capture.state != CaptureState::exposed) return unknown;
  return milliseconds_between(capture.requested_ns, capture.exposed_ns);
}

std::string capture_reason(const intake::Flight& flight, const CaptureRecord& capture) {
  switch (capture.state) {
    case CaptureState::pending:
      return "still waited for when the record ends";
    case CaptureState::exposed:
      return time_remark(flight, capture);
    case CaptureState::no_frame: {
      const EventRecord* event = event_of(flight, StatusCode::capture_missed, capture.id);
      return event == nullptr ? "the camera gave no frame in time"
                              : "the camera gave no frame within " + std::to_string(event->b) + " ms";
    }
    case CaptureState::rejected:
      return rejection(flight, capture);
    case CaptureState::superseded:
      return "a telecommanded capture was near";
    case CaptureState::count:
      break;
  }
  return "";
}

}  // namespace ilp::report
