#include "sim/ground/viewer/viewer_data.hpp"

#include <map>
#include <nlohmann/json.hpp>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::viewer {

using Json = nlohmann::ordered_json;

Json viewer_links(const intake::Flight& flight) {
  Json out = Json::array();
  for (const LinkRecord& link : flight.links) {
    out.push_back({{"keyframe", link.keyframe_id}, {"place", link.place_id}, {"verdict", name_of(link.verdict)}});
  }
  return out;
}

Json viewer_downlink(const report::Report& report) {
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
  const auto seconds = [](TimeNs time) { return static_cast<double>(time) / 1e9; };
  Json out = Json::array();
  for (const auto& [id, file] : files) {
    out.push_back({seconds(file.sent_ns), file.bytes, file.acknowledged_ns > 0 ? seconds(file.acknowledged_ns) : -1.0});
  }
  return out;
}

}  // namespace ilp::viewer
