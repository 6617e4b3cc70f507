// Measurement at one time from the vehicle's samples: a line fitted to the samples near that time, without outliers.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/navigation_sample.hpp"

namespace ilp::navigation {

/// Samples at most this far from a keyframe in time belong to it.
inline constexpr TimeNs window_ns = 500 * ns_per_ms;
inline constexpr std::size_t max_window_samples = 32;
using WindowSamples = FixedVector<NavigationSample, max_window_samples>;
/// Adds a sample within the window about `time`. A full list keeps the samples nearest to that time.
void add_near(const NavigationSample& sample, TimeNs time, WindowSamples& samples);

struct SampleCounts {
  std::uint32_t offered = 0;  ///< samples in the window
  std::uint32_t refused = 0;  ///< values that contradict their neighbours
};

/// The measurement at `time`. Each quantity comes from the samples that have it. A quantity is unknown (sigma 0) if no
/// sample has it, or if all samples are on the same side of `time` and farther away than a fifth of the window.
[[nodiscard]] NavigationSample measure_at(const WindowSamples& samples, TimeNs time, SampleCounts& counts);

}  // namespace ilp::navigation
