#include "sim/tools/docgen/interface_document.hpp"

#include <cstring>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/commanding/function_table.hpp"
#include "fsw/navigation/vehicle_packets.hpp"
#include "fsw/packets/cfdp_pdu.hpp"
#include "fsw/packets/message_table.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/pus.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/tailoring.hpp"
#include "sim/tools/docgen/markdown.hpp"
#include "sim/tools/docgen/records_document.hpp"
#include "sim/tools/docgen/xtce/layout.hpp"

namespace ilp::docgen {
namespace {

std::string text_of(std::size_t value) {
  return std::to_string(value);
}

std::string packets() {
  std::string text =
      "What ground software needs to operate the flight. [Parameters](parameters.md), [events](events.md) and "
      "[records](records.md) are parts of this page. [Commanding](commanding.md) explains the services, [file "
      "delivery](file-delivery.md) the transfers; `ilp-xtce` writes the same as an XTCE database. Numbers are "
      "big-endian; u8, u16, u32 are unsigned, i32, i64 two's complement, f32, f64 IEEE 754.\n\n"
      "## Packets\n\n";
  text += table_head({"octets", "field", "value"});
  const MissionParameters defaults;
  text += table_row({"0-1", "version (3 bits), type (1), secondary header flag (1), APID (11)",
                     "version 0; type 1 up, 0 down; flag 1; APID `link.apid`, " + number(defaults.apid)});
  text += table_row({"2-3", "sequence flags (2), sequence count (14)", "flags 3: unsegmented; one count for the APID"});
  text += table_row({"4-5", "packet data length", "octets after this field, minus 1"});
  text += table_row({"6", "PUS version (4), acknowledgement flags up, time status down (4)",
                     "version 2; flags 1 acceptance, 2 start, 4 progress, 8 completion; time status 0"});
  text += table_row({"7, 8", "service, subtype", ""});
  text += table_row({"up 9-10", "source ID", "any value; reports and replies are sent to it"});
  text +=
      table_row({"down 9-10", "message type counter", "counts the messages of this destination, service and subtype"});
  text += table_row({"down 11-12", "destination ID", "0: housekeeping and events"});
  text += table_row({"down 13-", "time", "TIME of the tailoring"});
  text += table_row({"last 2", "packet CRC", "CRC-16 0x1021, start 0xFFFF, over everything before it"});
  text += "\nUp at most " + text_of(limits::max_packet_bytes) + " octets, down at most " +
          text_of(limits::max_report_bytes) +
          ". A datagram holds one or more whole packets; a stream is cut by the "
          "length fields. APID " +
          text_of(cfdp_apid) + " holds CFDP PDUs, one each,\nwithout secondary header and packet CRC. At most " +
          text_of(limits::max_list_items) + " items in a list, " + text_of(limits::max_event_list) + " of events.\n";
  return text;
}

std::string tailoring() {
  std::string text = "\n## Tailoring\n\nWidths w(name) of the messages in octets, by `link.tailoring`:\n\n";
  Cells titles = {"w(...)"};
  std::size_t index = 0;
  for (const Tailoring& t : tailorings()) titles.push_back(code(t.name) + " (" + text_of(index++) + ")");
  text += table_head(titles);
  for (const Width& width : tailoring_widths()) {
    Cells cells = {width.name};
    for (const Tailoring& t : tailorings()) {
      const std::uint8_t octets = t.*width.octets;
      cells.push_back(octets == 0 && width.none[0] != 0 ? width.none : text_of(octets));
    }
    text += table_row(cells);
  }
  Cells interval = {"interval"};
  Cells time = {"TIME"};
  for (const Tailoring& t : tailorings()) {
    interval.push_back(t.interval_in_seconds ? "f32 s" : "u32 ms");
    time.push_back(text_of(time_bytes(t.time)) +
                   " octets: " + (t.time.code == TimeCode::cds ? "CDS short, P-field 0x40" : "CUC 4+3, P-field 0x2F"));
  }
  text += table_row(interval) + table_row(time);
  text +=
      "\nCDS counts UTC days since 1958-01-01 and milliseconds of the day. CUC counts seconds since "
      "`link.agency_epoch_s`. `link.cuc_time` 1 takes CUC in every tailoring. Telecommands may carry\nany CDS or "
      "CUC with its P-field. A *request* of service 11 is w(request padding) of zeros, source u16, APID u16, "
      "sequence count u16. A *request ID* of service 1 is the first four octets of the\ntelecommand.\n";
  return text;
}

std::string message_id(const MessageInfo& info) {
  return std::string(info.telecommand ? "TC" : "TM") + "[" + text_of(info.service) + "," + text_of(info.subtype) + "]";
}

/// Neighbours with the same data and the same remark share a row, as the four severities of events do.
std::string messages() {
  std::string text = "\n## Messages\n\n" + table_head({"message", "name", "data", ""});
  const auto table = message_table();
  for (std::size_t i = 0; i < table.size();) {
    const MessageInfo& first = table[i];
    std::string name = first.name, id = message_id(first);
    std::size_t next = i + 1;
    for (; next < table.size() && first.layout[0] != 0 && std::strcmp(table[next].layout, first.layout) == 0 &&
           std::strcmp(table[next].remark, first.remark) == 0;
         ++next) {
      name += "; " + std::string(table[next].name);
      id += ", " + message_id(table[next]);
    }
    text += table_row({id, cell(name), cell(first.layout), cell(first.remark)});
    i = next;
  }
  text += "\nAny other telecommand is answered by TM[1,2] with `service_unknown` or `subtype_unknown`.\n";
  return text;
}

std::string functions() {
  std::string text =
      "\n## Functions of TC[8,1]\n\nNames are padded with zeros to 8 characters. A function is completed when it is "
      "noted "
      "if the table says nothing else.\n\n";
  text += table_head({"name", "arguments", "octets", "what it does"});
  for (const FunctionInfo& info : function_table()) {
    std::string octets = text_of(info.bytes) + (info.has_time ? " + TIME" : "");
    if (info.optional != 0) octets += " + 0 to " + text_of(info.optional);
    text += table_row({code(info.name), cell(info.arguments), octets, cell(info.description)});
  }
  return text;
}

std::string parameters() {
  return "\n## Parameters of service 20\n\nThe ID is the column *no.* of [parameters](parameters.md). The value has "
         "the "
         "octets of its type.\n";
}

std::string layout(const ReportInfo& info) {
  std::string text = "\n### SID " + text_of(info.id) + ": " + info.name + "\n\n";
  if (info.repeats > 1) {
    text += text_of(info.repeats) + " times these " + text_of(report_bytes(info) / info.repeats) +
            " octets, in the order of their numbers ([schedule](schedule.md)).\n\n";
  }
  text += table_head({"octet", "value, type, unit", "meaning"});
  std::size_t offset = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (!is_reported(field)) continue;
    text += table_row({text_of(offset), declaration_cell(field), meaning_cell(field)});
    offset += element_bytes(field.type) * field.count;
  }
  return text;
}

std::string housekeeping_reports() {
  std::string text =
      "\n## Housekeeping: TM[3,25]\n\nA report has the fields of the linked table in their order, without padding, "
      "text and blobs; octets count from the end of the SID. Values of a record that does not exist yet are 0, unknown "
      "ones NaN, times in ns since the mission epoch. At first all reports are disabled, with an interval of 10 "
      "s.\n\n" +
      table_head({"SID", "fields", "octets", "what it says"});
  for (const ReportInfo& info : report_table()) {
    const std::string name = info.name;
    const bool of_record = info.record != RecordType::count;
    const std::string anchor = "#sid-" + text_of(info.id) + "-" + name;
    text += table_row({text_of(info.id), "[" + name + "](" + (of_record ? "records.md#" + name : anchor) + ")",
                       text_of(report_bytes(info)), cell(info.description)});
  }
  for (const ReportInfo& info : report_table()) {
    if (info.record == RecordType::count) text += layout(info);
  }
  return text;
}

std::string codes() {
  return "\n## Events and failure codes\n\nThe codes of [events](events.md) are event IDs of service 5 and failure "
         "codes of service 1; `%a` and `%b` of a text are the two values of the message. Severity info is TM[5,1], low "
         "TM[5,2], medium TM[5,3], high TM[5,4]. The reporter is the number of a component in the "
         "[schedule](schedule.md), or 0: the executive, or the start of the flight.\n";
}

std::string files() {
  std::string text =
      "\n## Files: CFDP class 2\n\nCCSDS 727.0-B-5, acknowledged mode, sender of products and receiver of uplinked "
      "files. PDUs of at most " +
      text_of(limits::max_pdu_bytes) + " octets come in space packets of APID " + text_of(cfdp_apid) +
      ", or raw, one in each datagram, where the link for files has a port of its own. Entity IDs and sequence numbers "
      "of 1 to 8 octets are accepted and answered with the same lengths; 64-bit sizes of files are read. Checksum "
      "types "
      "are 0 (modular), 2 (CRC-32C), 3 (CRC-32) and 15 (none). An uplinked file has at most " +
      text_of(limits::max_uplink_bytes) +
      " octets. [Parameters](parameters.md) whose names begin with `cfdp_` set the rest. A rejected PDU is an event "
      "`pdu_rejected` with its [reason](events.md#types-of-values), `pdu_fault`.\n";
  return text;
}

std::string vehicle_packets() {
  std::string text =
      "\n## Packets of the vehicle's computer\n\nMeasurements ([navigation.md](navigation.md)) come to a port of their "
      "own in space packets: TM[3,25] of the APID `navigation.vehicle_apid`, with SID " +
      text_of(navigation_report_id) +
      " and a packet CRC. The time is that of the measurement in UTC, CDS with a P-field, no earlier than the previous "
      "one and at most " +
      number(static_cast<double>(VehiclePackets::most_ahead_ns) / 1e9) +
      " s ahead of the package's clock. A datagram of at most " + text_of(limits::max_vehicle_datagram_bytes) +
      " octets holds one or more packets. Other packets are passed over; of refused ones the first and every "
      "thousandth "
      "is an event `navigation_refused`. After the SID, a u8, come these f64; where a sigma is 0, its quantity was not "
      "measured:\n\n";
  const char* separator = "";
  for (const NavigationColumn& column : navigation_columns()) {
    if (column.value == nullptr) continue;
    text += separator + code(column.name);
    separator = ", ";
  }
  return text + "\n";
}

}  // namespace

std::string interface_document() {
  return packets() + tailoring() + messages() + functions() + parameters() + housekeeping_reports() + codes() +
         files() + vehicle_packets();
}

}  // namespace ilp::docgen
