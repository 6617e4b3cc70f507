#include "sim/ground/console/report_values.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/status.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "sim/ground/console/utc_text.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::console {
namespace {

std::int64_t signed_number(ByteReader& in, std::size_t octets) {
  const std::uint64_t value = in.number(octets);
  return octets == 4 ? static_cast<std::int32_t>(static_cast<std::uint32_t>(value)) : static_cast<std::int64_t>(value);
}

bool known(std::uint32_t code) {
  return is_status_code(code);
}

// The meaning of an event, and its advice if it has one.
std::string sentence(std::uint32_t code, std::int64_t a, std::int64_t b) {
  if (!known(code)) return "code " + std::to_string(code) + ", unknown to this program";
  const auto status = static_cast<StatusCode>(code);
  return std::string(status_name(status)) + ": " + host::status_sentence({status, a, b}) +
         ". To do: " + status_advice(status);
}

std::string parameter_text(double value) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.10g", value);
  return text.data();
}

/// The name of a choice, otherwise the number. A damaged report may hold any number.
std::string value_words(const ParameterInfo& info, double value) {
  const bool whole = value >= 0 && value <= 255 && std::floor(value) == value;
  const EnumValue* const choice = whole ? find_value(info.choices, static_cast<std::uint64_t>(value)) : nullptr;
  return choice != nullptr ? choice->name : parameter_text(value);
}

std::span<const FieldInfo> fields(const ReportInfo& report) {
  return {report.fields, report.field_count};
}

const ReportInfo* find(const std::string& name) {
  for (const ReportInfo& report : report_table()) {
    if (name == report.name) return &report;
  }
  return nullptr;
}

std::string number_text(double value) {
  if (std::isnan(value)) return "not known";
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), std::fabs(value) < 1e15 && value == std::floor(value) ? "%.0f" : "%.6g",
                value);
  return text.data();
}

}  // namespace

std::string event_words(const Tailoring& tailoring, const Report& report) {
  ByteReader in(report.data);
  const auto code = static_cast<std::uint32_t>(in.number(tailoring.event_id));
  const std::uint64_t component = in.number(tailoring.event_reporter);
  const std::int64_t a = signed_number(in, tailoring.event_value), b = signed_number(in, tailoring.event_value);
  const std::uint32_t id = in.u32();
  UtcNs time = report.header.time;
  if (!decode_time(tailoring.time, in, time).ok() || !in.ok()) return "an event report that is cut short";
  const std::string place(in.rest().begin(), in.rest().end());
  return "event " + std::to_string(id) + " " +
         host::severity_name(static_cast<std::uint8_t>(report.header.subtype - event_reporting::informative)) + " at " +
         clock_text(time) + " " + host::component_name(component) + " " + sentence(code, a, b) +
         (place.empty() ? "" : " (" + place + ")");
}

std::vector<std::string> parameter_words(const Tailoring& tailoring, const Report& report,
                                         const std::function<void(std::size_t index, double value)>& see) {
  std::vector<std::string> lines;
  ByteReader in(report.data);
  const std::uint32_t count = read_count(tailoring.parameter_count, in);
  for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
    const std::uint64_t id = in.number(tailoring.parameter_id);
    const std::size_t index = find_parameter(id);
    if (!in.ok() || index == parameter_count()) {
      lines.emplace_back("a parameter that is unknown to this program");
      break;
    }
    const double value = read_value(parameter_info(index).type, in);
    if (!in.ok()) break;
    if (see) see(index, value);
    const ParameterInfo& info = parameter_info(index);
    lines.push_back(std::string(info.section) + "." + info.key + " = " + value_words(info, value) +
                    (*info.unit ? " " + std::string(info.unit) : ""));
  }
  return lines;
}

std::vector<std::string> schedule_words(const Tailoring& tailoring, const Report& report,
                                        const std::function<std::string(std::uint32_t request)>& name_of) {
  ByteReader in(report.data);
  const std::uint64_t count = in.number(tailoring.schedule_count == 0 ? 2 : tailoring.schedule_count);
  std::vector<std::string> lines = {std::to_string(count) + " telecommands wait for their time"};
  for (std::uint64_t i = 0; i < count && in.ok(); ++i) {
    in.take(std::size_t{tailoring.sub_schedule} + tailoring.group);
    UtcNs release = 0;
    if (!decode_time(tailoring.time, in, release).ok()) break;
    in.take(tailoring.request_id_padding);
    const std::uint16_t source = in.u16(), apid = in.u16(), sequence = in.u16();
    if (!in.ok()) break;
    // The first four octets of the request's packet: an unsegmented telecommand with a secondary header.
    const std::uint32_t request = (0x1800U | apid) << 16 | 0xC000U | sequence;
    lines.push_back("  " + utc_text(release) + " " + name_of(request) + " (source " + std::to_string(source) +
                    ", count " + std::to_string(sequence) + ")");
  }
  return lines;
}

std::string failure_words(std::uint32_t code, std::span<const std::uint8_t> failure_data) {
  ByteReader in(failure_data);
  const auto a = static_cast<std::int64_t>(in.number(8)), b = static_cast<std::int64_t>(in.number(8));
  return sentence(code, a, b);
}

const ReportInfo* ReportValues::take(const Tailoring& tailoring, std::span<const std::uint8_t> data) {
  ByteReader in(data);
  const std::uint64_t id = in.number(tailoring.report_id);
  for (const ReportInfo& report : report_table()) {
    if (report.id != id || in.left() != report_bytes(report)) continue;
    std::vector<double> values;
    for (std::size_t r = 0; r < report.repeats; ++r) {
      for (const FieldInfo& field : fields(report)) {
        for (std::size_t i = 0; is_reported(field) && i < field.count; ++i)
          values.push_back(read_value(field.type, in));
      }
    }
    values_[report.name] = std::move(values);
    return &report;
  }
  return nullptr;
}

const std::vector<double>* ReportValues::of(const std::string& report) const {
  const auto found = values_.find(report);
  return found == values_.end() ? nullptr : &found->second;
}

std::optional<double> ReportValues::value(const std::string& report, const std::string& field, std::size_t index,
                                          std::size_t repeat) const {
  const std::vector<double>* values = of(report);
  if (!values) return std::nullopt;
  const ReportInfo& info = *find(report);
  const std::size_t each = values->size() / info.repeats;
  std::size_t at = 0;
  for (const FieldInfo& candidate : fields(info)) {
    if (!is_reported(candidate)) continue;
    if (field == candidate.name && index < candidate.count && repeat < info.repeats) {
      return (*values)[repeat * each + at + index];
    }
    at += candidate.count;
  }
  return std::nullopt;
}

std::vector<std::string> ReportValues::lines(const std::string& report) const {
  const std::vector<double>* values = of(report);
  if (!values) return {"no report " + report + " has come"};
  const ReportInfo& info = *find(report);
  std::vector<std::string> lines;
  std::size_t at = 0;
  for (std::size_t r = 0; r < info.repeats; ++r) {
    std::string line = info.repeats > 1 ? std::string(component_name(r + 1)) + ":" : std::string();
    for (const FieldInfo& field : fields(info)) {
      if (!is_reported(field)) continue;
      std::string text = field.name;
      for (std::size_t i = 0; i < field.count; ++i) text += " " + number_text((*values)[at++]);
      if (*field.unit) text += std::string(" ") + field.unit;
      if (info.repeats == 1) {
        lines.push_back(text);
      } else {
        line += " " + text;
      }
    }
    if (info.repeats > 1) lines.push_back(line);
  }
  return lines;
}

}  // namespace ilp::console
