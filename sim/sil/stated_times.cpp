#include "sim/sil/stated_times.hpp"

#include <algorithm>
#include <cstdlib>
#include <ostream>
#include <set>
#include <string>

#include "sim/host/text_format.hpp"

namespace ilp::sil {
namespace {

using StatedTime = std::optional<std::int64_t> host::PhotographFacts::*;

constexpr std::int64_t second_ns = 1'000'000'000, longest_flight_ns = 30 * 86'400 * second_ns;

std::optional<std::int64_t> time_of(const Photo& photo, StatedTime time) {
  return photo.header ? (*photo.header).*time : std::nullopt;
}

std::vector<std::int64_t> sorted_times(const std::vector<Photo>& strip, StatedTime time) {
  std::vector<std::int64_t> times;
  for (const Photo& photo : strip) {
    if (const auto stated = time_of(photo, time)) times.push_back(*stated);
  }
  std::sort(times.begin(), times.end());
  return times;
}

std::size_t different(const std::vector<std::int64_t>& sorted) {
  return std::set<std::int64_t>(sorted.begin(), sorted.end()).size();
}

/// What is left out for one reason, with the first of it.
struct LeftOut {
  std::size_t count = 0;
  std::string first;

  void add(const Photo& photo) {
    if (++count == 1) first = photo.frame.file.string();
  }
  void report(const char* why, std::ostream& messages) const {
    if (count > 0)
      messages << "left out: " << host::counted(count, "photograph") << " " << why << "; the first is " << first
               << "\n";
  }
};

/// Photographs with equal times follow each other within their second; no time comes twice.
void spread(std::vector<std::int64_t>& times) {
  constexpr std::int64_t least_ns = 1'000'000;
  for (std::size_t begin = 0; begin < times.size();) {
    std::size_t end = begin;
    while (end < times.size() && times[end] == times[begin]) ++end;
    const auto count = static_cast<std::int64_t>(end - begin);
    const std::int64_t step = times[begin] % second_ns == 0 ? second_ns / count : least_ns;
    for (std::size_t i = begin + 1; i < end; ++i) times[i] += static_cast<std::int64_t>(i - begin) * step;
    begin = end;
  }
  for (std::size_t i = 1; i < times.size(); ++i) times[i] = std::max(times[i], times[i - 1] + least_ns);
}

StripEpoch epoch_of(const Photo& first, StatedTime time, std::int64_t time_ns) {
  if (time == &host::PhotographFacts::gps_time_ns) return {time_ns, true};
  if (first.header->zone_s) return {time_ns - *first.header->zone_s * second_ns, true};
  return {time_ns, false};
}

}  // namespace

std::optional<StripEpoch> take_stated_times(std::vector<Photo>& strip, std::ostream& messages) {
  if (strip.size() < 2 || !strip.front().frame.time_is_assumed) return std::nullopt;
  const auto camera = sorted_times(strip, &host::PhotographFacts::time_ns);
  const auto gps = sorted_times(strip, &host::PhotographFacts::gps_time_ns);
  const bool by_camera = different(camera) >= different(gps);
  const StatedTime time = by_camera ? &host::PhotographFacts::time_ns : &host::PhotographFacts::gps_time_ns;
  const std::vector<std::int64_t>& times = by_camera ? camera : gps;
  if (times.empty()) return std::nullopt;
  const std::int64_t middle = times[times.size() / 2];
  const auto odd = [middle](std::int64_t stated) { return std::llabs(stated - middle) > longest_flight_ns; };
  const auto usable = times.size() - static_cast<std::size_t>(std::count_if(times.begin(), times.end(), odd));
  // Two or three photographs may come in one second.
  if (2 * usable <= strip.size() || different(times) < 2 || 4 * different(times) < usable) {
    messages << "the times of EXIF are not used: "
             << (2 * usable <= strip.size() ? "only " + std::to_string(usable) + " of " + std::to_string(strip.size()) +
                                                  " photographs state one near the others'"
                                            : "only " + std::to_string(different(times)) + " of them differ")
             << "\n";
    return std::nullopt;
  }
  LeftOut without, far;
  for (const Photo& photo : strip) {
    const auto stated = time_of(photo, time);
    if (!stated) without.add(photo);
    if (stated && odd(*stated)) far.add(photo);
  }
  without.report("without a time in EXIF, which the others state", messages);
  far.report("with a time in EXIF that is more than 30 days from the others'", messages);
  std::erase_if(strip, [&](const Photo& photo) {
    const auto stated = time_of(photo, time);
    return !stated || odd(*stated);
  });
  const std::string first_by_name = strip.front().frame.file.filename().string();
  const auto earlier = [time](const Photo& a, const Photo& b) { return *time_of(a, time) < *time_of(b, time); };
  const bool in_order = std::is_sorted(strip.begin(), strip.end(), earlier);
  std::stable_sort(strip.begin(), strip.end(), earlier);
  std::vector<std::int64_t> spread_times = sorted_times(strip, time);
  spread(spread_times);
  for (std::size_t i = 0; i < strip.size(); ++i) {
    strip[i].frame.time_ns = spread_times[i] - spread_times[0];
    strip[i].frame.time_is_assumed = false;
  }
  messages << "the times are those that EXIF states" << (by_camera ? "" : " with the positions")
           << ", from the first image on\n";
  if (!in_order)
    messages << "the order is that of the times, which is not that of the names: the first image is "
             << strip.front().frame.file.filename().string() << ", by its name it would be " << first_by_name << "\n";
  return epoch_of(strip.front(), time, spread_times[0]);
}

}  // namespace ilp::sil
