#include "sim/tools/docgen/xtce/parts.hpp"

#include <array>
#include <cstdio>

#include "bsp/flight/status_text.hpp"
#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/status.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/records/records.hpp"

namespace ilp::docgen {
namespace {

std::vector<Choice> report_choices() {
  std::vector<Choice> choices;
  for (const ReportInfo& report : report_table()) choices.push_back({report.id, report.name, report.description});
  return choices;
}

std::vector<Choice> code_choices(std::size_t octets) {
  std::vector<Choice> choices;
  for (std::size_t i = 1; i < status_code_limit && (octets > 1 || i < 256); ++i) {
    if (!is_status_code(i)) continue;
    const auto status = static_cast<StatusCode>(i);
    choices.push_back({i, status_name(status), status_text(status)});
  }
  return choices;
}

std::vector<Choice> component_choices() {
  std::vector<Choice> choices = {{0, "package", "the executive, or the start of the flight"}};
  for (const Stage& stage : schedule) {
    choices.push_back({static_cast<std::uint64_t>(stage.component), stage.name, ""});
  }
  return choices;
}

std::vector<Choice> parameter_choices() {
  std::vector<Choice> choices;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    choices.push_back({info.number, std::string(info.section) + "_" + info.key, ""});
  }
  return choices;
}

std::vector<Choice> table_choices() {
  std::vector<Choice> choices;
  for (std::uint64_t i = 0; i < static_cast<std::uint64_t>(RecordType::count); ++i)
    choices.push_back({i, record_info(static_cast<RecordType>(i)).name, ""});
  return choices;
}

std::vector<Choice> value_choices(ValueType type, std::size_t octets) {
  switch (type) {
    case ValueType::fault:
      return code_choices(octets);
    case ValueType::component:
      return component_choices();
    case ValueType::parameter:
      return parameter_choices();
    case ValueType::table:
      return table_choices();
    default:
      return choices_of(named_values(type));
  }
}

StatusValue value_of(StatusCode code, char which) {
  const StatusValues values = status_values(code);
  return which == 'a' ? values.a : values.b;
}

std::string hexadecimal(std::uint64_t value, std::size_t octets) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%0*llX", static_cast<int>(2 * octets),
                static_cast<unsigned long long>(value));
  return text.data();
}

}  // namespace

std::string item_type(Side side, const LayoutItem& item, SpaceSystem& root) {
  const std::size_t bits = 8 * item.octets;
  if (item.width == "SID") return root.choice_type(side, "SID", bits, report_choices());
  if (item.width == "event") return root.choice_type(side, "event_code", bits, code_choices(item.octets));
  if (item.width == "failure code") return root.choice_type(side, "failure_code", bits, code_choices(item.octets));
  if (item.width == "reporter") return root.choice_type(side, "component", bits, component_choices());
  if (item.width == "parameter") return root.choice_type(side, "parameter_number", bits, parameter_choices());
  NumberForm form;
  form.bits = bits;
  form.is_signed = item.is_signed;
  form.is_float = item.is_float;
  form.unit = item.unit;
  return root.number_type(side, form);
}

std::string event_value_name(StatusCode code, char which) {
  const StatusValue value = value_of(code, which);
  return std::string(status_name(code)) + "_" + (*value.name != 0 ? std::string(value.name) : std::string(1, which));
}

std::string event_value_type(StatusCode code, char which, std::size_t octets, SpaceSystem& space) {
  const ValueType type = value_of(code, which).type;
  const ValueTypeInfo& info = info_of(type);
  const std::vector<Choice> choices = value_choices(type, octets);
  if (!choices.empty()) return space.choice_type(Side::parameter, info.name, 8 * octets, choices);
  NumberForm form{.bits = 8 * octets, .is_signed = true, .unit = info.unit, .scale = 1.0 / info.per_unit};
  if (type == ValueType::nanoseconds) {
    form.unit = "s";
    form.scale = 1e-9;
  }
  if (type == ValueType::size) form.unit = "";
  return space.number_type(Side::parameter, info.name, form);
}

void comparison(const std::string& parameter, std::uint64_t value, Xml& xml) {
  xml.leaf("Comparison",
           {{"parameterRef", parameter}, {"useCalibratedValue", "false"}, {"value", std::to_string(value)}});
}

std::string fixed_entry(const char* name, std::uint64_t value, std::size_t octets) {
  Xml xml(7);
  xml.leaf("FixedValueEntry",
           {{"name", name}, {"binaryValue", hexadecimal(value, octets)}, {"sizeInBits", std::to_string(8 * octets)}});
  return xml.text();
}

std::string argument_entry(const std::string& name) {
  Xml xml(7);
  xml.leaf("ArgumentRefEntry", {{"argumentRef", name}});
  return xml.text();
}

}  // namespace ilp::docgen
