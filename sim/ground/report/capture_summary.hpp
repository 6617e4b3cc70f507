// Summarises the capture records of a flight: their number, the overlaps achieved, the quality of the forecasts.
#pragma once

#include <array>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"

namespace ilp::report {

/// One more than the known values: a record from another software version may hold a value that is unknown here.
inline constexpr std::size_t capture_sources = static_cast<std::size_t>(CaptureSource::count) + 1;
inline constexpr std::size_t capture_states = static_cast<std::size_t>(CaptureState::count) + 1;
[[nodiscard]] std::size_t source_index(const CaptureRecord& capture);  ///< below capture_sources
[[nodiscard]] std::size_t state_index(const CaptureRecord& capture);   ///< below capture_states
[[nodiscard]] const char* capture_source_words(std::size_t source);
[[nodiscard]] const char* capture_state_words(std::size_t state);

/// Mean and deviation of a sample; NaN where the sample is too small.
struct Spread {
  std::size_t count = 0;
  double mean = unknown;
  double deviation = unknown;  ///< standard deviation about the mean, with count - 1
};
[[nodiscard]] Spread spread_of(const std::vector<double>& sample);

/// A capture that carried a forecast and whose frame was measured against the keyframe that was forecast.
struct ForecastCheck {
  std::int64_t capture_id = 0;
  std::int64_t keyframe_id = 0;  ///< that its frame became, 0 for none
  std::size_t source = 0;
  double forecast = 0, measured = 0;  ///< overlap, 0 to 1
  double sigma = unknown;             ///< of the forecast; NaN when it stated none

  [[nodiscard]] double error() const { return forecast - measured; }
};

struct CaptureSummary {
  std::array<std::array<std::size_t, capture_states>, capture_sources> counts{};  ///< by source and state
  std::array<std::size_t, capture_states> by_state{};
  double frames_per_keyframe = unknown;
  Spread achieved;  ///< overlap of keyframes with the previous one, minus the target
  std::vector<ForecastCheck> forecasts;
  std::size_t forecasts_unchecked = 0;  ///< of exposed captures: no overlap measured, or against another keyframe
  Spread forecast_error;                ///< forecast minus measured
  std::size_t with_sigma = 0;
  double within_1_sigma = unknown, within_2_sigma = unknown;  ///< shares of `with_sigma`
};

/// `target_overlap` is 0 to 1, or unknown.
[[nodiscard]] CaptureSummary summarise_captures(const intake::Flight& flight, double target_overlap);

[[nodiscard]] bool is_telecommanded(const CaptureRecord& capture);
/// Exposed minus requested time in ms; NaN without a frame.
[[nodiscard]] double exposure_delay_ms(const CaptureRecord& capture);
/// Why there is no frame, or what speaks against its time; empty when there is nothing to say.
[[nodiscard]] std::string capture_reason(const intake::Flight& flight, const CaptureRecord& capture);

}  // namespace ilp::report
