// What the vehicle's samples say about one moment: a line through the samples near it, without their outliers.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/navigation_sample.hpp"

namespace ilp::navigation {

/// Samples within this time of a keyframe belong to it.
inline constexpr TimeNs window_ns = 500 * ns_per_ms;
inline constexpr std::size_t max_window_samples = 32;
using WindowSamples = FixedVector<NavigationSample, max_window_samples>;
/// Adds a sample within the window about `time`. A full list keeps the samples nearest to that time.
void add_near(const NavigationSample& sample, TimeNs time, WindowSamples& samples);

struct SampleCounts {
  std::uint32_t offered = 0;
  std::uint32_t refused = 0;  ///< values that contradict their neighbours
};

/// The measurement at `time`, each quantity from those samples that have it. A quantity is not measured (sigma 0) if
/// no sample has it, or if all samples lie on one side and farther than a fifth of the window.
[[nodiscard]] NavigationSample measure_at(const WindowSamples& samples, TimeNs time, SampleCounts& counts);

}  // namespace ilp::navigation
