// Decodes packets of telemetry with the project's own decoders, for the comparison with a reader of XTCE. Standard
// input has a packet in hexadecimal digits per line, standard output an object of JSON for each.
//
//   decode_packets TAILORING

#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bsp/flight/status_text.hpp"
#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/service_verification.hpp"
#include "sim/ground/console/report_values.hpp"
#include "tests/support/hex.hpp"

namespace {

using namespace ilp;
using nlohmann::json;

/// name, value, unit, name of the enumerated value; for values of events also how many of them are one of the unit.
void add(json& values, const std::string& name, const json& value, const std::string& unit = "",
         const std::string& label = "") {
  values.push_back({name, value, unit, label});
}

std::string label_of(EnumValues choices, double value) {
  const EnumValue* const choice = find_value(choices, static_cast<std::uint64_t>(value));
  return choice != nullptr ? choice->name : "";
}

/// As the database has it: the own decoder writes names, and numbers with a unit.
std::string label_of(ValueType type, std::int64_t value) {
  if (type == ValueType::component) return component_name(static_cast<std::uint64_t>(value));
  if (type == ValueType::fault)
    return is_status_code(static_cast<std::uint64_t>(value)) && value != 0 ? status_name(static_cast<StatusCode>(value))
                                                                           : "";
  return value < 0 ? "" : label_of(named_values(type), static_cast<double>(value));
}

void add_count(const Telemetry& packet, std::uint64_t count, json& values) {
  add(values, "TM_" + std::to_string(packet.service) + "_" + std::to_string(packet.subtype) + "_count", count);
}

/// JSON has no NaN.
json number(double value) {
  return value == value ? json(value) : json("nan");
}

std::int64_t signed_number(ByteReader& in, std::size_t octets) {
  const std::uint64_t value = in.number(octets);
  return octets == 4 ? static_cast<std::int32_t>(static_cast<std::uint32_t>(value)) : static_cast<std::int64_t>(value);
}

std::string code_name(std::uint64_t code) {
  return is_status_code(code) ? status_name(static_cast<StatusCode>(code)) : "";
}

void verification_values(const Tailoring& tailoring, const Telemetry& packet, json& values) {
  VerificationReport report;
  if (!decode_verification(tailoring, packet.subtype, packet.data, report).ok()) std::abort();
  add(values, "request_ID", report.request);
  if (packet.subtype == verification::progress) add(values, "step", report.step);
  if (packet.subtype % 2 != 0) return;
  add(values, "failure_code", report.code, "", code_name(report.code));
  ByteReader in(report.failure_data);
  for (const char* const name : {"failure_a", "failure_b"}) add(values, name, signed_number(in, 8));
}

void housekeeping_values(const Tailoring& tailoring, const Telemetry& packet, json& values) {
  console::ReportValues decoded;
  const ReportInfo* const report = decoded.take(tailoring, packet.data);
  if (report == nullptr) std::abort();
  add(values, "SID", report->id, "", report->name);
  const std::vector<double>& numbers = *decoded.of(report->name);
  std::size_t next = 0;
  for (std::size_t repeat = 0; repeat < report->repeats; ++repeat) {
    std::string before = std::string("housekeeping/") + report->name + "/";
    if (report->source == ReportSource::components) before += std::string(component_name(repeat + 1)) + "_";
    if (report->source == ReportSource::nodes) before += std::to_string(repeat) + "_";
    for (const FieldInfo& field : std::span(report->fields, report->field_count)) {
      for (std::size_t i = 0; is_reported(field) && i < field.count; ++i) {
        const double value = numbers.at(next++);
        add(values, before + field.name + (field.count > 1 ? "_" + std::to_string(i) : ""), number(value), field.unit,
            label_of(field.values, value));
      }
    }
  }
}

void time_value(const Tailoring& tailoring, const std::string& name, ByteReader& in, json& values) {
  UtcNs time = 0;
  if (!decode_time(tailoring.time, in, time).ok()) std::abort();
  add(values, name, time, "utc");
}

void event_values(const Tailoring& tailoring, const Telemetry& packet, json& values) {
  ByteReader in(packet.data);
  const std::uint64_t code = in.number(tailoring.event_id), component = in.number(tailoring.event_reporter);
  add(values, "event", code, "", code_name(code));
  add(values, "component", component, "", component_name(component));
  const StatusValues kinds = status_values(static_cast<StatusCode>(code));
  for (const auto& [which, kind] : {std::pair('a', kinds.a), std::pair('b', kinds.b)}) {
    const std::int64_t value = signed_number(in, tailoring.event_value);
    const std::string name = kind.name[0] != 0 ? kind.name : std::string(1, which);
    const bool size = kind.type == ValueType::size;
    const ValueTypeInfo& info = info_of(kind.type);
    values.push_back({"events/" + code_name(code) + "_" + name, value, size ? "" : info.unit,
                      label_of(kind.type, value), info.per_unit});
  }
  add(values, "number", in.u32());
  time_value(tailoring, "event_time", in, values);
  add(values, "text", std::string(in.rest().begin(), in.rest().end()));
}

void list_values(const Tailoring& tailoring, const Telemetry& packet, json& values) {
  ByteReader in(packet.data);
  const std::uint8_t octets = tailoring.event_count == 0 ? 2 : tailoring.event_count;
  const std::uint64_t count = in.number(octets);
  add_count(packet, count, values);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t code = in.number(tailoring.event_id);
    add(values, "event", code, "", code_name(code));
  }
}

void schedule_values(const Tailoring& tailoring, const Telemetry& packet, json& values) {
  ByteReader in(packet.data);
  const std::uint64_t count = in.number(tailoring.schedule_count == 0 ? 2 : tailoring.schedule_count);
  add_count(packet, count, values);
  for (std::uint64_t i = 0; i < count; ++i) {
    if (tailoring.sub_schedule != 0) add(values, "sub_schedule", in.number(tailoring.sub_schedule));
    if (tailoring.group != 0) add(values, "group", in.number(tailoring.group));
    time_value(tailoring, "release_time", in, values);
    if (packet.subtype == scheduling::detail_report) {
      add(values, "telecommand_id", in.u32());
      const std::uint16_t length = in.u16();
      add(values, "telecommand_length", length);
      const auto rest = in.take(std::size_t{length} + 1);
      add(values, "telecommand_octets", to_hex(rest));
      continue;
    }
    if (tailoring.request_id_padding != 0) add(values, "request_padding", in.number(tailoring.request_id_padding));
    for (const char* const name : {"request_source", "request_apid", "request_count"}) add(values, name, in.u16());
  }
}

void parameter_values(const Tailoring& tailoring, const console::Report& report, json& values) {
  ByteReader in(report.data);
  add_count(report.header, read_count(tailoring.parameter_count, in), values);
  const auto lines = console::parameter_words(tailoring, report, [&](std::size_t index, double value) {
    const ParameterInfo& info = parameter_info(index);
    const std::string name = std::string(info.section) + "_" + info.key;
    add(values, "parameter", info.number, "", name);
    add(values, "parameters/" + name, number(value), info.unit, label_of(info.choices, value));
  });
  static_cast<void>(lines);
}

json decode(const Tailoring& tailoring, const std::vector<std::uint8_t>& octets) {
  Telemetry packet;
  if (!decode_telemetry(octets, static_cast<std::uint16_t>(MissionParameters{}.apid), tailoring.time, packet).ok()) {
    std::abort();
  }
  json values = json::array();
  add(values, "sequence_count", packet.primary.sequence_count);
  add(values, "service", packet.service);
  add(values, "subtype", packet.subtype);
  add(values, "message_counter", packet.counter);
  add(values, "destination", packet.destination);
  add(values, "time", packet.time, "utc");
  console::Report report;
  report.header = packet;
  report.data.assign(packet.data.begin(), packet.data.end());
  switch (packet.service) {
    case verification::service:
      verification_values(tailoring, packet, values);
      break;
    case 3:
      housekeeping_values(tailoring, packet, values);
      break;
    case event_reporting::service:
      (packet.subtype == event_reporting::disabled ? list_values : event_values)(tailoring, packet, values);
      break;
    case scheduling::service:
      schedule_values(tailoring, packet, values);
      break;
    case test_service::service:
      if (packet.subtype == test_service::connected) {
        std::uint16_t application = 0;
        if (!decode_connection(packet.data, application).ok()) std::abort();
        add(values, "APID", application);
      }
      break;
    case parameter_management::service:
      parameter_values(tailoring, report, values);
      break;
    default:
      std::abort();
  }
  return values;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const MissionParameters mission;
  const Tailoring tailoring =
      tailoring_of(static_cast<GroundSystem>(std::atoi(argv[1])), false, mission.agency_epoch_s);
  for (std::string line; std::getline(std::cin, line);) {
    std::cout << decode(tailoring, from_hex(line)).dump() << "\n";
  }
  return 0;
}
