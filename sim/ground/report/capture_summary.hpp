// Summarises the capture records of a flight: their number, the achieved overlaps, and the quality of the forecasts.
#pragma once

#include <array>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::report {

/// Numbers of sources and states: the known values, and one for unknown values from other software versions.
inline constexpr std::size_t capture_sources = static_cast<std::size_t>(CaptureSource::count) + 1;
inline constexpr std::size_t capture_states = static_cast<std::size_t>(CaptureState::count) + 1;
[[nodiscard]] std::size_t source_index(const CaptureRecord& capture);  ///< 0 to capture_sources - 1
[[nodiscard]] std::size_t state_index(const CaptureRecord& capture);   ///< 0 to capture_states - 1
[[nodiscard]] const char* capture_source_words(std::size_t source);
[[nodiscard]] const char* capture_state_words(std::size_t state);

/// Mean and standard deviation of a sample; NaN if the sample is too small.
struct Spread {
  std::size_t count = 0;
  double mean = unknown;
  double deviation = unknown;  ///< standard deviation about the mean, with count - 1
};
[[nodiscard]] Spread spread_of(const std::vector<double>& sample);

/// An exposed capture with a forecast, whose overlap was measured with the keyframe of the forecast.
struct ForecastCheck {
  std::int64_t capture_id = 0;
  std::int64_t keyframe_id = 0;       ///< keyframe that its frame became; 0: none
  std::size_t source = 0;             ///< source_index
  double forecast = 0, measured = 0;  ///< overlap, 0 to 1
  double sigma = unknown;             ///< estimated standard deviation of the forecast; NaN: none

  [[nodiscard]] double error() const { return forecast - measured; }
};

struct CaptureSummary {
  std::array<std::array<std::size_t, capture_states>, capture_sources> counts{};  ///< indices: source, state
  std::array<std::size_t, capture_states> by_state{};
  double frames_per_keyframe = unknown;
  Spread achieved;  ///< overlap of keyframes with the keyframe before, minus the target
  std::vector<ForecastCheck> forecasts;
  std::size_t forecasts_unchecked = 0;  ///< exposed captures whose overlap was not measured, or with another keyframe
  Spread forecast_error;                ///< forecast minus measured overlap
  std::size_t with_sigma = 0;           ///< number of `forecasts` with a sigma
  double within_1_sigma = unknown, within_2_sigma = unknown;  ///< shares of these with an error within the sigmas
};

/// `target_overlap`: 0 to 1; NaN: unknown.
[[nodiscard]] CaptureSummary summarise_captures(const intake::Flight& flight, double target_overlap);

[[nodiscard]] bool is_telecommanded(const CaptureRecord& capture);
/// Exposed minus requested time in ms; NaN without a frame.
[[nodiscard]] double exposure_delay_ms(const CaptureRecord& capture);
/// Why there is no frame, or why its time is suspect; else empty.
[[nodiscard]] std::string capture_reason(const intake::Flight& flight, const CaptureRecord& capture);

}  // namespace ilp::report
