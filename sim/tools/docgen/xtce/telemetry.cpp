// Telemetry of the XTCE database: packet headers, reports, housekeeping values and events.
#include <array>
#include <chrono>
#include <cstdio>

#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/packets/message_table.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "sim/tools/docgen/xtce/parts.hpp"

namespace ilp::docgen {
namespace {

constexpr const char* packet_length = "packet_length";
constexpr std::size_t crc_bits = 16;

/// A dateTime of XML, in whole seconds.
std::string epoch_text(UtcNs utc) {
  using namespace std::chrono;
  const std::int64_t second = utc / ns_per_s;
  const year_month_day day = sys_days{year{1958} / 1 / 1} + days{second / seconds_per_day};
  const auto of_day = static_cast<int>(second % seconds_per_day);
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(day.year()),
                static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()), of_day / 3600, of_day / 60 % 60,
                of_day % 60);
  return text.data();
}

void entry(const std::string& parameter, Xml& xml) {
  xml.leaf("ParameterRefEntry", {{"parameterRef", parameter}});
}

/// The entries of one container, with the parameters that they need.
class Entries {
 public:
  Entries(const XtceMission& mission, SpaceSystem& root, std::string message)
      : mission_(mission), root_(root), message_(std::move(message)) {}

  void add(const std::vector<LayoutItem>& items) {
    for (const LayoutItem& item : items) add(item);
  }
  void number(const std::string& name, const NumberForm& form, const std::string& description) {
    root_.parameter(name, root_.number_type(Side::parameter, form), description);
    entry(name, xml);
    octets_ += form.bits / 8;
  }
  void time(const std::string& name, const std::string& description) {
    number(name + "_p_field", {.bits = 8}, "P-field of " + name);
    const TimeFormat& format = mission_.tailoring.time;
    octets_ += time_bytes(format) - 1;
    if (format.code == TimeCode::cds) {
      // The days count from 1958 and have 86400 s each, as UNIX time does.
      constexpr double unix_of_1958 = -4383.0 * static_cast<double>(seconds_per_day);
      const std::string day = name + "_day";
      root_.parameter(day, root_.time_type(Side::parameter, "utc_day", 16, seconds_per_day, unix_of_1958, "", "UNIX"),
                      "day of " + name);
      root_.parameter(name, root_.time_type(Side::parameter, name + "_of_day", 32, 1e-3, 0, day, ""), description);
      entry(day, xml);
    } else {
      const std::string epoch = epoch_text(format.agency_epoch);
      root_.parameter(name, root_.time_type(Side::parameter, "cuc", 56, 0x1p-24, 0, "", epoch), description);
    }
    entry(name, xml);
  }
  [[nodiscard]] std::size_t octets() const { return octets_; }

  Xml xml{6};

 private:
  void add(const LayoutItem& item) {
    switch (item.kind) {
      case ItemKind::number:
        return plain(item);
      case ItemKind::count:
        return number(message_ + "_count", {.bits = 8 * (item.octets == 0 ? 2 : item.octets)},
                      "number of items that follow");
      case ItemKind::list:
        return list(item);
      case ItemKind::time:
        return time(item.name, "UTC");
      case ItemKind::request:
        for (const char* const part : {"request_source", "request_apid", "request_count"}) request(part);
        return;
      case ItemKind::telecommand:
        return telecommand();
      case ItemKind::text:
        return text();
      case ItemKind::value:
        return values();
      case ItemKind::report:  // a container of its own for each report
      case ItemKind::function:
      case ItemKind::arguments:
        return;
    }
  }
  void plain(const LayoutItem& item) {
    if (item.width == "event value") return event_value(item);
    const std::string name = xtce_name(item.name);
    root_.parameter(name, item_type(Side::parameter, item, root_), item.name);
    entry(name, xml);
    octets_ += item.octets;
  }
  /// The value of each event of this severity has a parameter of its own.
  void event_value(const LayoutItem& item) {
    const char which = item.name.back();
    for (std::size_t i = 0; i < status_code_limit; ++i) {
      const auto code = static_cast<StatusCode>(i);
      const int subtype = event_reporting::informative + static_cast<int>(status_severity(code));
      if (!is_status_code(i) || message_ != "TM_5_" + std::to_string(subtype)) continue;
      const std::string name = event_value_name(code, which);
      xml.open("ParameterRefEntry", {{"parameterRef", mission_.reference(events_space, name)}});
      xml.open("IncludeCondition");
      comparison("event", i, xml);
      xml.close();
      xml.close();
    }
    octets_ += item.octets;
  }
  /// A container of the items, repeated.
  void list(const LayoutItem& item) {
    const std::string name = message_ + "_item";
    Entries inner(mission_, root_, name);
    inner.add(item.items);
    root_.containers.open("SequenceContainer", {{"name", name}});
    root_.containers.open("EntryList");
    root_.containers.append(inner.xml.text());
    root_.containers.close();
    root_.containers.close();
    xml.open("ContainerRefEntry", {{"containerRef", name}});
    xml.open("RepeatEntry");
    xml.open("Count");
    xml.open("DynamicValue");
    xml.leaf("ParameterInstanceRef", {{"parameterRef", message_ + "_count"}});
    xml.close();
    xml.close();
    xml.close();
    xml.close();
  }
  void request(const char* part) {
    if (mission_.tailoring.request_id_padding != 0 && std::string(part) == "request_source") {
      number("request_padding", {.bits = std::size_t{8} * mission_.tailoring.request_id_padding}, "zeros");
    }
    number(part, {.bits = 16}, "of a telecommand that waits for its time");
  }
  void telecommand() {
    number("telecommand_id", {.bits = 32}, "request ID of a telecommand that waits for its time");
    number("telecommand_length", {.bits = 16}, "octets after this field, minus 1");
    root_.parameter("telecommand_octets",
                    root_.sized_type(Side::parameter, "Binary", "telecommand_octets", "telecommand_length", 8, 8),
                    "the telecommand after its primary header");
    entry("telecommand_octets", xml);
  }
  void text() {
    const std::size_t before = telemetry_header_bytes + time_bytes(mission_.tailoring.time) + octets_;
    const auto intercept = 8 - static_cast<std::int64_t>(8 * before + crc_bits);
    root_.parameter("text", root_.sized_type(Side::parameter, "String", "text", packet_length, 8, intercept),
                    "place of a failed assertion");
    entry("text", xml);
  }
  void values() {
    for (std::size_t i = 0; i < parameter_count(); ++i) {
      const ParameterInfo& info = parameter_info(i);
      xml.open("ParameterRefEntry",
               {{"parameterRef", mission_.reference(parameters_space, std::string(info.section) + "_" + info.key)}});
      xml.open("IncludeCondition");
      comparison("parameter", info.number, xml);
      xml.close();
      xml.close();
    }
  }

  const XtceMission& mission_;
  SpaceSystem& root_;
  std::string message_;
  std::size_t octets_ = 0;
};

void base(const char* container, const std::vector<std::pair<std::string, std::uint64_t>>& equal, Xml& xml) {
  xml.open("BaseContainer", {{"containerRef", container}});
  xml.open("RestrictionCriteria");
  if (equal.size() > 1) xml.open("ComparisonList");
  for (const auto& [parameter, value] : equal) comparison(parameter, value, xml);
  if (equal.size() > 1) xml.close();
  xml.close();
  xml.close();
}

void bits(const char* name, std::size_t count, const char* description, SpaceSystem& root, Xml& entries) {
  NumberForm form;
  form.bits = count;
  root.parameter(name, root.number_type(Side::parameter, form), description);
  entry(name, entries);
}

void container(const std::string& name, const std::string& description, bool abstract, SpaceSystem& space) {
  space.containers.open(
      "SequenceContainer",
      {{"name", space.named(name)}, {"shortDescription", description}, {"abstract", abstract ? "true" : ""}});
}

/// The length of a packet and its CRC, for readers that check them.
void packet_form(Xml& xml) {
  xml.open("BinaryEncoding");
  xml.open("ErrorDetectCorrect");
  xml.open("CRC", {{"width", "16"}, {"bitsFromReference", "0"}, {"reference", "end"}});
  xml.leaf("Polynomial", {}, "1021");
  xml.leaf("InitRemainder", {}, "FFFF");
  xml.close();
  xml.close();
  xml.open("SizeInBits");
  xml.open("DynamicValue");
  xml.leaf("ParameterInstanceRef", {{"parameterRef", packet_length}});
  // The primary header has 48 bits, and the length lacks one octet.
  xml.leaf("LinearAdjustment", {{"slope", "8"}, {"intercept", "56"}});
  xml.close();
  xml.close();
  xml.close();
}

void packet(SpaceSystem& root) {
  Xml entries(6);
  bits("packet_version", 3, "0", root, entries);
  bits("packet_type", 1, "0: telemetry", root, entries);
  bits("secondary_header", 1, "1: there is one", root, entries);
  bits("apid", 11, "application process", root, entries);
  bits("sequence_flags", 2, "3: unsegmented", root, entries);
  bits("sequence_count", 14, "one count for the APID", root, entries);
  bits(packet_length, 16, "octets after this field, minus 1", root, entries);
  container("packet", "CCSDS space packet", true, root);
  root.containers.open("EntryList");
  root.containers.append(entries.text());
  root.containers.close();
  root.containers.close();
}

void telemetry(const XtceMission& mission, SpaceSystem& root) {
  Entries entries(mission, root, "telemetry");
  bits("pus_version", 4, "2", root, entries.xml);
  bits("time_status", 4, "0", root, entries.xml);
  entries.number("service", {.bits = 8}, "service of ECSS-E-ST-70-41C");
  entries.number("subtype", {.bits = 8}, "message of the service");
  entries.number("message_counter", {.bits = 16}, "counts the messages of this destination, service and subtype");
  entries.number("destination", {.bits = 16}, "source of the telecommand; 0: housekeeping and events");
  entries.time("time", "UTC of the report");
  container("telemetry", "telemetry packet of PUS-C", true, root);
  packet_form(root.containers);
  root.containers.open("EntryList");
  root.containers.append(entries.xml.text());
  root.containers.close();
  base("packet", {{"packet_type", 0}, {"secondary_header", 1}, {"apid", mission.apid}}, root.containers);
  root.containers.close();
  root.parameter("packet_crc", root.number_type(Side::parameter, {.bits = crc_bits}), "CRC-16 of the packet");
}

void files(SpaceSystem& root) {
  root.parameter("pdu", root.sized_type(Side::parameter, "Binary", "pdu", packet_length, 8, 8), "CFDP PDU");
  container("cfdp", "a PDU of CCSDS 727.0-B-5", false, root);
  root.containers.open("EntryList");
  entry("pdu", root.containers);
  root.containers.close();
  base("packet", {{"packet_type", 0}, {"apid", cfdp_apid}}, root.containers);
  root.containers.close();
}

void message(const XtceMission& mission, const MessageInfo& info, SpaceSystem& root) {
  const std::string name = "TM_" + std::to_string(info.service) + "_" + std::to_string(info.subtype);
  const bool values = info.service == ilp::housekeeping::service;
  Entries entries(mission, root, name);
  entries.add(read_layout(info.layout, mission.tailoring));
  if (!values) entry("packet_crc", entries.xml);
  container(name, info.name, values, root);
  root.containers.open("EntryList");
  root.containers.append(entries.xml.text());
  root.containers.close();
  base("telemetry", {{"service", info.service}, {"subtype", info.subtype}}, root.containers);
  root.containers.close();
}

/// The name of a field without its unit, where the value is calibrated to another one.
std::string value_name(const FieldInfo& field) {
  const std::string name = field.name;
  return field.unit == std::string("ns") && name.ends_with("_ns") ? name.substr(0, name.size() - 3) : name;
}

std::string field_type(const FieldInfo& field, SpaceSystem& root, SpaceSystem& own) {
  const std::size_t bits = 8 * element_bytes(field.type);
  if (!field.values.empty()) {
    return own.choice_type(Side::parameter, std::string(field.name) + "_choice", bits, choices_of(field.values));
  }
  NumberForm form;
  form.bits = bits;
  form.is_float = field.type == FieldType::f32 || field.type == FieldType::f64;
  form.is_signed = form.is_float || field.type == FieldType::i32 || field.type == FieldType::i64;
  form.unit = field.unit;
  if (form.unit != "ns") return root.number_type(Side::parameter, form);
  form.unit = "s";
  form.scale = 1e-9;
  return root.number_type(Side::parameter, "i64_ns_in_s", form);
}

/// "" for a report of one record; otherwise the name of the component or the number of the process.
std::string repeat_name(const ReportInfo& info, std::size_t repeat) {
  if (info.repeats == 1) return "";
  const Stage* const stage = info.source == ReportSource::components ? find_stage(repeat + 1) : nullptr;
  return (stage == nullptr ? std::to_string(repeat) : stage->name) + "_";
}

SpaceSystem report(const XtceMission& mission, const ReportInfo& info, SpaceSystem& root) {
  SpaceSystem space(info.name, info.description, mission.prefix_of(std::string(housekeeping_space) + "_" + info.name));
  Xml entries(6);
  for (std::size_t r = 0; r < info.repeats; ++r) {
    for (const FieldInfo& field : std::span(info.fields, info.field_count)) {
      for (std::size_t i = 0; is_reported(field) && i < field.count; ++i) {
        const std::string index = field.count > 1 ? "_" + std::to_string(i) : "";
        const std::string name = repeat_name(info, r) + value_name(field) + index;
        entry(space.parameter(name, field_type(field, root, space), field.description), entries);
      }
    }
  }
  entry("packet_crc", entries);
  container("report", info.description, false, space);
  space.containers.open("EntryList");
  space.containers.append(entries.text());
  space.containers.close();
  base("TM_3_25", {{"SID", info.id}}, space.containers);
  space.containers.close();
  return space;
}

}  // namespace

void add_telemetry(const XtceMission& mission, SpaceSystem& root) {
  packet(root);
  telemetry(mission, root);
  files(root);
  for (const MessageInfo& info : message_table()) {
    if (!info.telecommand) message(mission, info, root);
  }
}

SpaceSystem events(const XtceMission& mission) {
  SpaceSystem space(events_space, "values of the events of service 5", mission.prefix_of(events_space));
  for (std::size_t i = 0; i < status_code_limit; ++i) {
    if (!is_status_code(i)) continue;
    const auto code = static_cast<StatusCode>(i);
    for (const char which : {'a', 'b'}) {
      space.parameter(event_value_name(code, which),
                      event_value_type(code, which, mission.tailoring.event_value, space), status_text(code));
    }
  }
  return space;
}

SpaceSystem housekeeping(const XtceMission& mission, SpaceSystem& root) {
  SpaceSystem space(housekeeping_space, "reports of service 3");
  for (const ReportInfo& info : report_table()) space.children.push_back(report(mission, info, root));
  return space;
}

}  // namespace ilp::docgen
