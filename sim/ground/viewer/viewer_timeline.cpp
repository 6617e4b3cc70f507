// Events, overlap, link and storage for the viewer's timeline.
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/ground/intake/record_file.hpp"
#include "sim/ground/report/json_parts.hpp"
#include "sim/ground/viewer/viewer_data.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::viewer {
namespace {

using nlohmann::json;

double seconds(TimeNs time) {
  return static_cast<double>(time) / 1e9;
}

// When there are too many, the least severe go first.
std::uint8_t least_severity(const std::vector<EventRecord>& events, std::size_t most) {
  std::uint8_t least = 0;
  const auto kept = [&] {
    return static_cast<std::size_t>(
        std::count_if(events.begin(), events.end(), [&](const EventRecord& e) { return e.severity >= least; }));
  };
  while (least < static_cast<std::uint8_t>(Severity::high) && kept() > most) ++least;
  return least;
}

json events_of(const report::Report& report, std::size_t most) {
  const std::vector<EventRecord>& events = report.flight.events;
  const std::uint8_t least = least_severity(events, most);
  json out = json::array();
  for (const EventRecord& e : events) {
    if (e.severity < least || out.size() >= most) continue;
    out.push_back({{"time_s", seconds(e.time_ns)},
                   {"severity", e.severity},
                   {"severity_name", host::severity_name(e.severity)},
                   {"name", host::event_name(e.code)},
                   {"component", e.component},
                   {"text", host::event_sentence(e)},
                   {"advice", host::event_advice(e.code)},
                   {"place", e.place}});
  }
  return {{"list", out}, {"all", events.size()}};
}

std::map<std::int64_t, TimeNs> frame_times(const report::Report& report) {
  std::map<std::int64_t, TimeNs> times;
  for (const auto& [id, frame] : report.flight.frames) times[id] = frame.time_ns;
  for (const auto& [id, keyframe] : report.flight.keyframes) {
    if (keyframe.record) times[keyframe.record->frame_id] = keyframe.record->time_ns;
  }
  return times;
}

json overlaps_of(const report::Report& report, std::size_t most) {
  const std::map<std::int64_t, TimeNs> times = frame_times(report);
  const std::size_t step = report.flight.overlaps.size() / std::max<std::size_t>(most, 1) + 1;
  json out = json::array();
  std::size_t place = 0;
  for (const auto& [id, overlap] : report.flight.overlaps) {
    const auto time = times.find(id);
    if (time == times.end() || overlap.keyframe_id == 0 || overlap.verdict != OverlapVerdict::ok || place++ % step != 0)
      continue;
    out.push_back({seconds(time->second), overlap.overlap});
  }
  return out;
}

// Files handed to the link: the newest record of each.
json link_of(const report::Report& report) {
  std::map<std::int64_t, DownlinkRecord> files;
  for (const intake::RecordEntry& entry : report.outbox.records) {
    if (entry.type != RecordType::downlink) continue;
    try {
      const auto record = record_of<DownlinkRecord>(entry);
      files[record.id] = record;
    } catch (const intake::BadFile&) {
      continue;
    }
  }
  json out = json::array();
  for (const auto& [id, file] : files) {
    out.push_back({seconds(file.sent_ns), file.bytes, file.acknowledged_ns > 0 ? seconds(file.acknowledged_ns) : -1.0});
  }
  return out;
}

}  // namespace

json viewer_timeline(const report::Report& report, const ViewerBudget& budget) {
  return {{"events", events_of(report, budget.events)},
          {"overlaps", overlaps_of(report, budget.frames)},
          {"link", link_of(report)},
          {"storage", report::storage_json(report.flight)}};
}

}  // namespace ilp::viewer
