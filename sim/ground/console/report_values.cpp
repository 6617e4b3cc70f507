#include "sim/ground/console/report_values.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "cfg/schedule.hpp"
#include "fsw/packets/service_parameters.hpp"

namespace ilp::console {
namespace {

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
    std::string line = info.repeats > 1 && r < stage_count ? schedule[r].name + std::string(":") : std::string();
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
