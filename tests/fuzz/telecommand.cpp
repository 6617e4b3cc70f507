#include <algorithm>
#include <array>

#include "fsw/packets/pus.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/service_verification.hpp"
#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {
namespace {

constexpr std::uint16_t apid = 0x0EF;

bool within(Octets part, Octets whole) {
  return part.empty() || (part.data() >= whole.data() && part.data() + part.size() <= whole.data() + whole.size());
}

class Copy {
 public:
  ByteWriter& out() { return out_; }
  void is(Octets data, const char* what) const { require(out_.ok() && std::ranges::equal(out_.written(), data), what); }

 private:
  std::array<std::uint8_t, 8192> octets_{};
  ByteWriter out_{octets_};
};

void lists(const Tailoring& tailoring, Octets data) {
  ReportList reports;
  if (decode_report_list(tailoring, data, reports).ok()) {
    Copy copy;
    encode_report_list(tailoring, reports, copy.out());
    copy.is(data, "list of reports");
  }
  IntervalList intervals;
  if (decode_interval_list(tailoring, data, intervals).ok()) {
    for (const ReportInterval& item : intervals) require(item.interval_ns >= 0, "interval");
    Copy copy;
    encode_interval_list(tailoring, intervals, copy.out());
    require(copy.out().ok() && copy.out().size() == data.size(), "list of intervals");
    if (!tailoring.interval_in_seconds) copy.is(data, "list of intervals");
  }
  EventList events;
  if (decode_event_list(tailoring, data, events).ok() && !events.all) {
    Copy copy;
    encode_disabled_events(tailoring, {events.ids.data(), events.ids.size()}, copy.out());
    require(copy.out().ok(), "list of events");
    if (tailoring.event_count != 0) copy.is(data, "list of events");
  }
  ParameterList parameters;
  if (decode_parameter_list(tailoring, data, parameters).ok()) {
    Copy copy;
    write_count(tailoring.parameter_count, parameters.size(), copy.out());
    for (const std::uint32_t id : parameters) copy.out().number(id, tailoring.parameter_id);
    copy.is(data, "list of parameters");
  }
  ScheduledIdList ids;
  static_cast<void>(decode_scheduled_ids(tailoring, data, ids));
  std::int32_t ms = 0;
  static_cast<void>(decode_shift(tailoring, data, ms, ids));
  static_cast<void>(decode_shift_all(data, ms));
}

void values(Octets data) {
  ByteReader in(data);
  for (const FieldType type : {FieldType::u8, FieldType::u16, FieldType::u32, FieldType::i32, FieldType::i64,
                               FieldType::f32, FieldType::f64}) {
    static_cast<void>(read_value(type, in));
  }
}

void inserts(const Tailoring& tailoring, Octets data) {
  InsertReader reader(tailoring, data);
  ScheduleItem item;
  std::uint32_t items = 0;
  while (reader.next(item)) {
    require(within(item.packet, data) && item.release >= 0, "item of an insertion");
    Telecommand inner;
    static_cast<void>(decode_telecommand(item.packet, apid, inner));
    require(++items <= data.size(), "more items than octets");
  }
  if (reader.status().ok()) require(items == reader.count(), "number of items");
}

void functions(Octets data) {
  FunctionCall call;
  if (decode_function(data, call).ok()) {
    Copy copy;
    encode_function(call, copy.out());
    copy.is(data, "function");
  }
  std::uint16_t application = 0;
  if (decode_connection(data, application).ok()) require(data.size() == 2, "connection");
}

void reports(const Tailoring& tailoring, std::uint8_t subtype, Octets data) {
  VerificationReport report;
  if (decode_verification(tailoring, subtype, data, report).ok()) {
    Copy copy;
    encode_verification(tailoring, report, copy.out());
    copy.is(data, "verification report");
  }
  Telemetry telemetry;
  static_cast<void>(decode_telemetry(data, apid, tailoring.time, telemetry));
  ByteReader in(data);
  UtcNs utc = 0;
  const std::uint8_t p_field = data.empty() ? 0 : data.front();
  if (decode_time(tailoring.time, in, utc).ok()) {
    require(utc >= 0, "time before 1958");
    if (p_field == p_field_of(tailoring.time)) {
      // A leap second is the first second of the next day: the instant is the same.
      Copy copy;
      require(encode_time(tailoring.time, utc, copy.out()).ok(), "time that was read");
      ByteReader again(copy.out().written());
      UtcNs second = 0;
      require(copy.out().size() == in.offset() && decode_time(tailoring.time, again, second).ok() && second == utc,
              "time");
    }
  }
}

void packet(Octets octets) {
  Telecommand telecommand;
  const Status status = decode_telecommand(octets, apid, telecommand);
  if (!status.ok()) {
    require(static_cast<bool>(status_text(status.code)), "a reason without a text");
    return;
  }
  require(within(telecommand.data, octets), "data outside of their packet");
  std::vector<std::uint8_t> again(octets.size());
  std::size_t bytes = 0;
  require(encode_telecommand(telecommand, again, bytes).ok() && bytes == octets.size(), "length");
  require(std::ranges::equal(again, octets), "telecommand");
}

/// With the header and CRC that it needs to be looked at.
void mended(Octets body, std::uint8_t service, std::uint8_t subtype) {
  Telecommand telecommand;
  telecommand.primary.apid = apid;
  telecommand.service = service;
  telecommand.subtype = subtype;
  telecommand.data = body;
  std::vector<std::uint8_t> octets(body.size() + telecommand_overhead_bytes);
  std::size_t bytes = 0;
  require(encode_telecommand(telecommand, octets, bytes).ok() && bytes == octets.size(), "encoding");
  Telecommand read;
  require(decode_telecommand(octets, apid, read).ok(), "what was encoded");
  require(read.service == service && read.subtype == subtype && std::ranges::equal(read.data, body), "what was said");
}

}  // namespace

void telecommand(Octets input) {
  Choices choices(input);
  const std::uint8_t choice = choices.byte();
  const std::uint8_t service = choices.byte();
  const std::uint8_t subtype = choices.byte();
  const Octets data = choices.take(limits::max_packet_bytes);
  packet(data);
  Octets first;
  if (first_packet(data, first).ok()) packet(first);
  if (data.size() <= 4096) {
    mended(data, service, subtype);
    const Tailoring& tailoring = tailorings()[choice % tailoring_count];
    lists(tailoring, data);
    values(data);
    inserts(tailoring, data);
    functions(data);
    reports(tailoring, subtype, data);
  }
}

}  // namespace ilp::fuzz
