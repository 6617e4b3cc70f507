#include "sim/host/longitude.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ilp::host {

double longitude_near(double longitude_deg, double reference_deg) {
  return longitude_deg + 360 * std::round((reference_deg - longitude_deg) / 360);
}

double LongitudeArc::width_deg() const {
  return east_deg >= west_deg ? east_deg - west_deg : east_deg - west_deg + 360;
}

double LongitudeArc::middle_deg() const {
  return longitude_near(west_deg + 0.5 * width_deg(), 0);
}

LongitudeArc longitude_arc(std::span<const double> longitudes_deg) {
  if (longitudes_deg.empty()) return {};
  // A meridian that is an end of the range is told apart from its other name by its neighbours only.
  std::vector<double> sorted;
  for (const double longitude : longitudes_deg) sorted.push_back(longitude_near(longitude, 0));
  std::sort(sorted.begin(), sorted.end());
  // The largest gap is what the arc leaves out; that over 180 comes first.
  double largest = sorted.front() + 360 - sorted.back();
  std::size_t first = 0;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    const double gap = sorted[i] - sorted[i - 1];
    if (gap <= largest) continue;
    largest = gap;
    first = i;
  }
  return {sorted[first], first == 0 ? sorted.back() : sorted[first - 1]};
}

}  // namespace ilp::host
