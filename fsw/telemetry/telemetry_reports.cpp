#include "fsw/telemetry/telemetry_reports.hpp"

#include <array>
#include <cstring>
#include <iterator>

#include "cfg/limits.hpp"
#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"

namespace ilp {
namespace {

#define F(member, unit, description) ILP_FIELD(member, unit, description, EnumValues{})

namespace status {
using R = PackageStatus;
constexpr FieldInfo fields[] = {
    F(mission_time_ns, "ns", "mission time"),
    F(version_major, "", "of the flight software"),
    F(version_minor, "", "of the flight software"),
    F(version_patch, "", "of the flight software"),
    F(contact, "", "1: in a pass"),
    F(parameters_crc32, "", "CRC-32 over all parameters as they are in force: f64, big-endian, in order of number"),
    F(frames_run, "", "minor frames since the last start"),
    F(frame_overruns, "", "of them late"),
    F(events, "", "number of the newest event"),
    F(events_untold, "", "events that wait to be told"),
    F(events_disabled, "", "kinds of events that are not told"),
};
}  // namespace status

namespace link {
using R = LinkCounts;
constexpr FieldInfo fields[] = {
    F(received, "", "packets and PDUs taken in"),
    F(sent, "", "packets and PDUs sent"),
    F(malformed, "", "no packet, or cut short"),
    F(unknown_apid, "", "for another application"),
    F(refused, "", "not authenticated"),
    F(dropped, "", "came faster than they were read, or out of contact"),
    F(reports_sent, "", "packets of telemetry"),
    F(reports_lost, "", "that did not fit while nobody listened"),
    F(reports_waiting, "", "that wait for contact"),
    F(pdus_in, "", "CFDP PDUs read"),
    F(pdus_out, "", "CFDP PDUs written"),
    F(pdus_rejected, "", "malformed"),
    F(pdus_ignored, "", "for nobody here, or of a transaction that is not known"),
    F(files_delivered, "", "files that the ground holds"),
    F(files_refused, "", "transactions that the ground ended without the file"),
    F(files_cancelled, "", "transactions cancelled"),
};
}  // namespace link

namespace components {
using R = ComponentHealth;
constexpr FieldInfo fields[] = {
    F(steps, "", "steps taken since the last start"), F(overruns, "", "steps over budget"),
    F(restarts, "", "restarts from the checkpoint"),  F(faults, "", "steps that returned a fault"),
    F(busy_ns, "ns", "processor time used"),          F(longest_ns, "ns", "longest step"),
};
}  // namespace components

#undef F

ReportInfo of_record(std::uint8_t id, RecordType type, ReportSource source, const char* description) {
  const RecordInfo& info = record_info(type);
  return {id, info.name, description, source, type, info.fields, info.field_count, 1};
}

using Table = std::array<ReportInfo, report_count>;

Table make_table() {
  using enum RecordType;
  using enum ReportSource;
  // The record that only `first` and `newest` look at.
  constexpr RecordType none = RecordType::count;
  return {{
      {1, "status", "the package as a whole", ReportSource::status, none, status::fields, std::size(status::fields), 1},
      {2, "components", "health and time of every component, in the order of the schedule", ReportSource::components,
       none, components::fields, std::size(components::fields), stage_count},
      {3, "link", "packets, reports and PDUs since the last start", ReportSource::link, none, link::fields,
       std::size(link::fields), 1},
      of_record(4, commanding, first, "what became of telecommands and reports"),
      of_record(5, storage, first, "what the store holds and what was given up"),
      of_record(6, capture, newest, "the newest capture"),
      of_record(7, frame, newest, "the newest image"),
      of_record(8, overlap, newest, "overlap of the newest image looked at"),
      of_record(9, strip, newest, "the newest strip"),
      of_record(10, keyframe, newest, "the newest keyframe"),
      of_record(11, camera, first, "the camera's intrinsics"),
      of_record(12, calibration, newest, "what self-calibration said at the newest keyframe"),
      of_record(13, pose, newest, "the newest pose"),
      of_record(14, depth, newest, "the newest depth map"),
      of_record(15, richness, newest, "the newest Image Richness Index"),
      of_record(16, product, newest, "the product of the newest keyframe"),
      of_record(17, downlink, newest, "the newest file handed to the link"),
      of_record(18, transfer, newest, "the newest file on its way to the ground"),
      of_record(19, uplink, newest, "the newest file from the ground"),
      of_record(20, timing, first, "how minor frames keep their time"),
  }};
}

const Table table = make_table();

}  // namespace

std::span<const ReportInfo> report_table() {
  return table;
}

const ReportInfo* find_report(std::uint64_t id) {
  for (const ReportInfo& report : table) {
    if (report.id == id) return &report;
  }
  return nullptr;
}

std::size_t report_bytes(const ReportInfo& report) {
  std::size_t bytes = 0;
  for (std::size_t f = 0; f < report.field_count; ++f) {
    const FieldInfo& field = report.fields[f];
    if (is_reported(field)) bytes += element_bytes(field.type) * field.count;
  }
  return bytes * report.repeats;
}

void write_report_values(const ReportInfo& report, const void* values, ByteWriter& out) {
  const auto* const bytes = static_cast<const std::uint8_t*>(values);
  for (std::size_t f = 0; f < report.field_count; ++f) {
    const FieldInfo& field = report.fields[f];
    if (!is_reported(field)) continue;
    const std::size_t width = element_bytes(field.type);
    for (std::size_t i = 0; i < field.count; ++i) {
      const std::uint8_t* const element = bytes + field.offset + i * width;
      // In memory as the machine has it.
      std::uint64_t value = 0;
      if (width == 1) {
        value = *element;
      } else if (width == 2) {
        std::uint16_t number = 0;
        std::memcpy(&number, element, width);
        value = number;
      } else if (width == 4) {
        std::uint32_t number = 0;
        std::memcpy(&number, element, width);
        value = number;
      } else {
        std::memcpy(&value, element, width);
      }
      out.number(value, width);
    }
  }
}

}  // namespace ilp
