#include "bsp/flight/mission_file.hpp"

#include <array>
#include <cstdio>
#include <cstring>

#include "bsp/flight/nearest_word.hpp"

namespace ilp {
namespace {

/// Section and key of the parameter that was perhaps meant.
void add_nearest(const MissionEntry& entry, FixedText<320>& text) {
  NearestWord nearest(entry.key);
  for (std::size_t i = 0; i < parameter_count(); ++i) nearest.offer(parameter_info(i).key);
  for (std::size_t i = 0; nearest.found() != nullptr && i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    if (std::strcmp(info.key, nearest.found()) != 0) continue;
    text.add("; did you mean ").add(info.section).add('.').add(info.key).add('?');
    return;
  }
}

}  // namespace

FixedText<320> fault_of_entry(const MissionEntry& entry) {
  FixedText<320> text;
  const std::size_t index = find_parameter(entry.section, entry.key);
  if (index == parameter_count()) {
    text.add("no such parameter (docs/parameters.md lists them)");
    add_nearest(entry, text);
    return text;
  }
  const ParameterInfo& info = parameter_info(index);
  if (!info.choices.empty()) {
    NearestWord nearest(entry.value);
    for (const EnumValue& choice : info.choices) {
      text.add(text.size() == 0 ? "expected " : " or ").add(choice.name);
      nearest.offer(choice.name);
    }
    if (nearest.found() != nullptr) text.add("; did you mean ").add(nearest.found()).add('?');
    return text;
  }
  std::array<char, 96> range{};
  std::snprintf(range.data(), range.size(), "not a number from %g to %g%s%s", info.minimum, info.maximum,
                *info.unit != 0 ? " " : "", info.unit);
  text.add(range.data());
  if (std::strcmp(info.unit, "rad") == 0) text.add(", or degrees, written 20deg");
  text.add(" (docs/parameters.md)");
  return text;
}

FixedText<512> fault_of_mission(Status status, const MissionEntry& entry) {
  FixedText<512> text;
  if (entry.key[0] != 0) {
    text.add('[').add(entry.section).add("] ").add(entry.key).add(" = ").add(entry.value).add(": ");
    text.add(fault_of_entry(entry).c_str());
  } else if (status.is(StatusCode::parse_error)) {
    text.add("line ").add(status.a).add(": expected [section], key = value, or a comment behind ; or #");
  } else if (status.is(StatusCode::not_found)) {
    text.add("there is no such file; check the path");
  }
  return text;
}

Status read_mission_file(const char* path, MissionParameters& mission, MissionEntry& fault) {
  fault = {};
  std::FILE* const file = std::fopen(path, "r");
  if (file == nullptr) return StatusCode::not_found;
  MissionText text(mission);
  std::array<std::uint8_t, 4096> chunk{};
  std::size_t bytes = chunk.size();
  // Bounded by the file.
  while (bytes == chunk.size()) {
    bytes = std::fread(chunk.data(), 1, chunk.size(), file);
    text.add(std::span(chunk).first(bytes));
  }
  const bool failed = std::ferror(file) != 0;
  static_cast<void>(std::fclose(file));
  if (failed) return StatusCode::io_error;
  const Status status = text.finish(mission);
  fault = text.fault();
  return status;
}

}  // namespace ilp
