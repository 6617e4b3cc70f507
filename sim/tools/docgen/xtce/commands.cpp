// Telecommands and mission parameters of the XTCE database. A list in a message becomes a single item in its command.
#include <cmath>
#include <regex>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "fsw/commanding/function_table.hpp"
#include "fsw/packets/message_table.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "sim/tools/docgen/xtce/parts.hpp"

namespace ilp::docgen {
namespace {

constexpr const char* octets_suffix = "_octets";

/// Arguments and entries of one command.
class Body {
 public:
  Body(const XtceMission& mission, SpaceSystem& root) : mission_(mission), root_(root) {}

  void add(const std::vector<LayoutItem>& items) {
    for (const LayoutItem& item : items) add(item);
  }
  void argument(const std::string& name, const std::string& type, const std::string& description,
                const std::string& initial = "") {
    arguments.push_back({name, type, initial, description});
    entries += argument_entry(name);
  }
  /// In CUC of the CCSDS epoch, which is one number, with as many octets as the tailoring's own time. The flight reads
  /// every code by its P-field.
  void time(const std::string& name) {
    TimeFormat format;
    format.code = TimeCode::cuc_ccsds;
    const std::size_t octets = time_bytes(mission_.tailoring.time) - 1;
    format.fine_octets = static_cast<std::uint8_t>(octets - format.coarse_octets);
    entries += fixed_entry("p_field", p_field_of(format), 1);
    const double resolution = std::ldexp(1.0, -8 * format.fine_octets);
    argument(name, root_.time_type(Side::argument, "cuc_tai", 8 * octets, resolution, 0, "", "TAI"), "UTC");
  }

  std::vector<CommandArgument> arguments;
  std::string entries;

 private:
  void add(const LayoutItem& item) {
    switch (item.kind) {
      case ItemKind::number:
        return argument(xtce_name(item.name), item_type(Side::argument, item, root_), item.name);
      case ItemKind::count:
        if (item.octets != 0) entries += fixed_entry("count", 1, item.octets);
        return;
      case ItemKind::list:
        return add(item.items);
      case ItemKind::time:
        return time(item.name);
      case ItemKind::request:
        return request();
      case ItemKind::telecommand:
        return telecommand(item.name);
      default:
        throw std::runtime_error("a telecommand has no '" + item.name + "'");
    }
  }
  void request() {
    const std::uint8_t padding = mission_.tailoring.request_id_padding;
    if (padding != 0) entries += fixed_entry("padding", 0, padding);
    for (const char* const part : {"request_source", "request_apid", "request_count"}) {
      argument(part, root_.number_type(Side::argument, {.bits = 16}), "of the telecommand that waits for its time");
    }
  }
  /// Its length is an argument that is not in the packet.
  void telecommand(const std::string& name) {
    arguments.push_back(
        {name + octets_suffix, root_.number_type(Side::argument, {.bits = 16}), "", "octets of the telecommand"});
    argument(name, root_.sized_type(Side::argument, "Binary", name, name + octets_suffix, 8, 0),
             "a whole packet with its CRC");
  }

  const XtceMission& mission_;
  SpaceSystem& root_;
};

/// The abstract command of all: primary and secondary header. A ground system fills in the length, the sequence count
/// and the CRC, which comes after the last entry.
void add_base(const XtceMission& mission, SpaceSystem& root) {
  Xml& xml = root.commands;
  const NumberForm octet;
  xml.open("MetaCommand", {{"name", "telecommand"}, {"abstract", "true"}});
  xml.leaf("LongDescription", {},
           "The ground system fills in the sequence count and the packet length, and adds the CRC: CRC-16, polynomial "
           "0x1021, start 0xFFFF, over all octets before it.");
  xml.open("ArgumentList");
  NumberForm flags;
  flags.bits = 4;
  flags.min = 0;
  flags.max = 15;
  xml.leaf("Argument", {{"name", "acknowledgement"},
                        {"argumentTypeRef", root.number_type(Side::argument, "acknowledgement", flags)},
                        {"initialValue", "15"},
                        {"shortDescription", "1 acceptance, 2 start, 4 progress, 8 completion"}});
  const std::string number = root.number_type(Side::argument, octet);
  xml.leaf("Argument", {{"name", "service"}, {"argumentTypeRef", number}});
  xml.leaf("Argument", {{"name", "subtype"}, {"argumentTypeRef", number}});
  xml.leaf("Argument", {{"name", "source"},
                        {"argumentTypeRef", root.number_type(Side::argument, {.bits = 16})},
                        {"initialValue", "1"},
                        {"shortDescription", "reports and replies are sent to it"}});
  xml.close();
  xml.open("CommandContainer", {{"name", "telecommand"}});
  xml.open("EntryList");
  // Version 0, type 1, secondary header; unsegmented.
  xml.append(fixed_entry("packet_id", 0x1800U | mission.apid, 2));
  xml.append(fixed_entry("sequence", 0xC000, 2));
  xml.append(fixed_entry("packet_length", 0, 2));
  xml.leaf("FixedValueEntry", {{"name", "pus_version"}, {"binaryValue", "02"}, {"sizeInBits", "4"}});
  for (const char* const name : {"acknowledgement", "service", "subtype", "source"}) xml.append(argument_entry(name));
  xml.close();
  xml.close();
  xml.close();
}

/// `u32 interval in ms`, `f64 distance in m` of the arguments' text.
void function_argument(const std::string& text, Body& body, std::size_t& octets, SpaceSystem& root) {
  static const std::regex form(R"(\s*(u|f)(8|16|32|64) (\w+)(.*))"), in_unit(R"( in (\w+))");
  std::smatch match, unit;
  if (!std::regex_match(text, match, form)) return;
  const std::string rest = match[4];
  NumberForm number;
  number.bits = std::stoul(match[2]);
  number.is_float = number.is_signed = match[1] == "f";
  if (std::regex_match(rest, unit, in_unit)) number.unit = unit[1];
  octets += number.bits / 8;
  body.argument(match[3], root.number_type(Side::argument, number), match[3].str() + rest);
}

void add_function(const XtceMission& mission, const FunctionInfo& info, SpaceSystem& root) {
  Body body(mission, root);
  std::uint64_t name = 0;
  const std::string text = info.name;
  for (std::size_t i = 0; i < function_name_bytes; ++i) {
    name = name << 8U | (i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0U);
  }
  body.entries += fixed_entry("function", name, function_name_bytes);
  if (info.has_time) body.time("at");
  std::size_t octets = 0;
  std::string part;
  for (const char c : std::string(info.arguments) + ",") {
    if (c != ',') {
      part += c;
      continue;
    }
    function_argument(part, body, octets, root);
    part.clear();
  }
  if (octets != info.bytes) throw std::runtime_error("the arguments of " + text + " are not understood");
  if (info.optional != 0) {
    body.argument("tag", root.bytes_type(Side::argument, "tag", info.optional), "kept with the capture",
                  std::string(std::size_t{2} * info.optional, '0'));
  }
  add_command(text, info.description, function_management::service, function_management::perform, body.arguments,
              body.entries, root);
}

std::string value_type(Side side, const ParameterInfo& info, SpaceSystem& space) {
  const std::string name = std::string(info.section) + "_" + info.key;
  const std::size_t bits = 8 * element_bytes(info.type);
  if (!info.choices.empty()) return space.choice_type(side, name, bits, choices_of(info.choices));
  NumberForm form;
  form.bits = bits;
  form.is_float = info.type == FieldType::f32 || info.type == FieldType::f64;
  form.is_signed = form.is_float || info.type == FieldType::i32 || info.type == FieldType::i64;
  form.unit = info.unit;
  form.min = info.minimum;
  form.max = info.maximum;
  return space.number_type(side, name, form);
}

}  // namespace

void add_command(const std::string& name, const std::string& description, std::uint8_t service, std::uint8_t subtype,
                 const std::vector<CommandArgument>& arguments, const std::string& entries, SpaceSystem& space) {
  Xml& xml = space.commands;
  xml.open("MetaCommand", {{"name", space.named(name)}, {"shortDescription", description}});
  xml.open("BaseMetaCommand", {{"metaCommandRef", "telecommand"}});
  xml.open("ArgumentAssignmentList");
  xml.leaf("ArgumentAssignment", {{"argumentName", "service"}, {"argumentValue", std::to_string(service)}});
  xml.leaf("ArgumentAssignment", {{"argumentName", "subtype"}, {"argumentValue", std::to_string(subtype)}});
  xml.close();
  xml.close();
  if (!arguments.empty()) {
    xml.open("ArgumentList");
    for (const CommandArgument& argument : arguments) {
      xml.leaf("Argument", {{"name", argument.name},
                            {"argumentTypeRef", argument.type},
                            {"initialValue", argument.initial},
                            {"shortDescription", argument.description}});
    }
    xml.close();
  }
  xml.open("CommandContainer", {{"name", space.named(name)}});
  xml.open("EntryList");
  xml.append(entries);
  xml.close();
  xml.leaf("BaseContainer", {{"containerRef", "telecommand"}});
  xml.close();
  xml.close();
}

SpaceSystem parameters(const XtceMission& mission, SpaceSystem& root) {
  SpaceSystem space(parameters_space, "parameters of service 20", mission.prefix_of(parameters_space));
  LayoutItem number;
  number.width = "parameter";
  number.octets = mission.tailoring.parameter_id;
  root.parameter("parameter", item_type(Side::parameter, number, root), "parameter");
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const ParameterInfo& info = parameter_info(i);
    const std::string name = std::string(info.section) + "_" + info.key;
    const std::string when = info.acts == Acts::next_start ? ". It takes effect with the next start" : "";
    space.parameter(name, value_type(Side::parameter, info, space), info.description);
    std::string entries;
    const std::uint8_t count = mission.tailoring.parameter_count;
    if (count != 0) entries += fixed_entry("count", 1, count);
    entries += fixed_entry("parameter", info.number, mission.tailoring.parameter_id) + argument_entry("value");
    add_command("set_" + name, info.description + when, parameter_management::service, parameter_management::set,
                {{"value", value_type(Side::argument, info, space), "", info.unit}}, entries, space);
  }
  return space;
}

void add_telecommands(const XtceMission& mission, SpaceSystem& root) {
  add_base(mission, root);
  for (const MessageInfo& info : message_table()) {
    const bool by_name = info.service == function_management::service;
    const bool by_parameter =
        info.service == parameter_management::service && info.subtype == parameter_management::set;
    if (!info.telecommand || by_name || by_parameter) continue;
    Body body(mission, root);
    // Where the tailoring has no list of events, every event is meant.
    const bool bare = info.service == 5 && mission.tailoring.events_one_and_all;
    if (!bare) body.add(read_layout(info.layout, mission.tailoring));
    add_command(xtce_name(info.name), info.name, info.service, info.subtype, body.arguments, body.entries, root);
  }
  for (const FunctionInfo& info : function_table()) add_function(mission, info, root);
}

}  // namespace ilp::docgen
