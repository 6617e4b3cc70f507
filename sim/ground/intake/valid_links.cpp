#include "sim/ground/intake/valid_links.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <string>

#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::intake {
namespace {

constexpr std::size_t most_named = 20;

/// All fields of a record that are no whole numbers.
template <typename Record>
bool has_finite_values(const Record& record) {
  const RecordInfo& info = record_info<Record>();
  const auto* const bytes = reinterpret_cast<const std::uint8_t*>(&record);
  for (const FieldInfo& field : std::span(info.fields, info.field_count)) {
    if (field.type != FieldType::f64) continue;
    for (std::size_t i = 0; i < field.count; ++i) {
      double value = 0;
      std::memcpy(&value, bytes + field.offset + i * sizeof(value), sizeof(value));
      if (!std::isfinite(value)) return false;
    }
  }
  return true;
}

bool is_in_another_strip(const Flight& flight, std::int64_t keyframe_id, std::int64_t strip_id) {
  const auto keyframe = flight.keyframes.find(keyframe_id);
  return keyframe != flight.keyframes.end() && keyframe->second.strip_id > 0 && keyframe->second.strip_id != strip_id;
}

/// Empty for a valid one.
std::string fault_of(const Flight& flight, const LinkRecord& link) {
  const auto points = flight.link_points.find(link.id);
  if (link.id / limits::max_links_per_keyframe != link.keyframe_id)
    return "its number is not one of keyframe " + std::to_string(link.keyframe_id);
  if (link.place_id < 1 || link.place_id >= link.keyframe_id || link.place_strip_id > link.strip_id)
    return "it does not lead to an earlier keyframe";
  if (is_in_another_strip(flight, link.keyframe_id, link.strip_id) ||
      is_in_another_strip(flight, link.place_id, link.place_strip_id))
    return "its keyframes are in other strips";
  if (find_value(values_of(link.verdict), static_cast<std::uint8_t>(link.verdict)) == nullptr)
    return "its verdict is unknown";
  if (link.points.bytes % sizeof(LinkPoint) != 0 ||
      (points != flight.link_points.end() && points->second.size() > limits::max_link_points))
    return "no link has " + host::counted(link.points.bytes / sizeof(LinkPoint), "point");
  return has_finite_values(link) ? "" : "one of its values is no number";
}

std::string fault_of(const Flight&, const TieRecord& tie) {
  if (tie.to_strip_id < 1 || tie.to_strip_id >= tie.id) return "it does not lead to an earlier strip";
  return has_finite_values(tie) ? "" : "one of its values is no number";
}

template <typename Word>
bool is_word(Word word) {
  return find_value(values_of(word), static_cast<std::uint8_t>(word)) != nullptr;
}

bool is_a_place(const FixRecord& fix) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis)
    largest = std::max({largest, std::fabs(fix.ground_m[axis]), std::fabs(fix.centre_m[axis])});
  const bool on_body = std::fabs(fix.latitude_deg) <= 90 && std::fabs(fix.map_latitude_deg) <= 90 &&
                       std::fabs(fix.longitude_deg) <= 360 && std::fabs(fix.map_longitude_deg) <= 360;
  const double(&c)[3] = fix.ground_covariance;
  return on_body && is_unit_quaternion(fix.q_cam_from_map) && largest < largest_coordinate && fix.pixel_m > 0 &&
         c[0] > 0 && c[2] > 0 && c[0] * c[2] > c[1] * c[1] && fix.ground_depth >= 0;
}

std::string fault_of(const Keyframe& keyframe, const FixRecord& fix) {
  if (keyframe.strip_id > 0 && fix.strip_id != keyframe.strip_id) return "it is of another strip";
  if (!is_word(fix.verdict) || !is_word(fix.state) || !is_word(fix.sense) || !is_word(fix.prior) || !is_word(fix.body))
    return "one of its words is unknown";
  if (!has_finite_values(fix)) return "one of its values is no number";
  return fix.verdict == MapVerdict::fixed && !is_a_place(fix) ? "its numbers are no place with an error" : "";
}

template <typename Record>
void leave_out_invalid(const char* what, std::vector<Record>& records, Flight& flight) {
  std::size_t left_out = 0;
  std::erase_if(records, [&](const Record& record) {
    const std::string fault = fault_of(flight, record);
    if (!fault.empty() && ++left_out <= most_named) {
      flight.remarks.push_back(std::string(what) + " " + std::to_string(record.id) + " is left out: " + fault);
    }
    return !fault.empty();
  });
  if (left_out > most_named)
    flight.remarks.push_back(host::counted(left_out - most_named, std::string("further ") + what) + " left out");
}

}  // namespace

void leave_out_invalid_fixes(Flight& flight) {
  std::size_t left_out = 0;
  const auto name = [&](const char* what, std::int64_t id, const std::string& fault) {
    if (++left_out <= most_named)
      flight.remarks.push_back(std::string("the ") + what + " of keyframe " + std::to_string(id) +
                               " is left out: " + fault);
  };
  for (auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.navigation && !has_finite_values(*keyframe.navigation)) {
      keyframe.navigation.reset();
      name("navigation", id, "one of its values is no number");
    }
    const std::string fault = keyframe.fix ? fault_of(keyframe, *keyframe.fix) : "";
    if (fault.empty()) continue;
    keyframe.fix.reset();
    name("fix", id, fault);
  }
  if (left_out > most_named)
    flight.remarks.push_back(host::counted(left_out - most_named, "further record") +
                             " of fixes and navigation left out");
}

void leave_out_invalid_links(Flight& flight) {
  leave_out_invalid("link", flight.links, flight);
  leave_out_invalid("tie", flight.ties, flight);
  std::erase_if(flight.link_points, [&](const auto& points) {
    const auto at = std::lower_bound(flight.links.begin(), flight.links.end(), points.first,
                                     [](const LinkRecord& link, std::int64_t id) { return link.id < id; });
    return at == flight.links.end() || at->id != points.first;
  });
}

}  // namespace ilp::intake
