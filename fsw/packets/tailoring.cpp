#include "fsw/packets/tailoring.hpp"

namespace ilp {
namespace {

constexpr UtcNs year_2000 = std::int64_t{15340} * seconds_per_day * ns_per_s;

constexpr TimeFormat cuc_4_3() {
  TimeFormat format;
  format.code = TimeCode::cuc_agency;
  format.agency_epoch = year_2000;
  return format;
}

constexpr Tailoring fsfw() {
  Tailoring t;
  t.name = "fsfw";
  t.report_count = 0;
  t.report_id = 8;
  t.interval_in_seconds = true;
  t.event_count = 0;
  t.event_reporter = 4;
  t.event_value = 4;
  t.events_one_and_all = true;
  t.insert_count = 0;
  t.schedule_count = 0;
  t.request_id_padding = 2;
  return t;
}

constexpr Tailoring yamcs() {
  Tailoring t;
  t.name = "yamcs";
  t.failure_code = 4;
  t.report_count = 1;
  t.report_id = 4;
  t.event_count = 1;
  t.event_id = 1;
  t.insert_count = 1;
  t.sub_schedule = 1;
  t.parameter_count = 1;
  t.time = cuc_4_3();
  return t;
}

constexpr Tailoring plain() {
  Tailoring t;
  t.name = "standard";
  return t;
}

constexpr Tailoring every_tailoring[tailoring_count] = {plain(), fsfw(), yamcs()};

}  // namespace

std::span<const Tailoring, tailoring_count> tailorings() {
  return every_tailoring;
}

Tailoring tailoring_of(GroundSystem tailoring, bool cuc_time, double agency_epoch_s) {
  const auto row = static_cast<std::size_t>(tailoring);
  Tailoring chosen = every_tailoring[row < tailoring_count ? row : 0];
  if (cuc_time) chosen.time = cuc_4_3();
  if (chosen.time.code == TimeCode::cuc_agency) {
    chosen.time.agency_epoch = static_cast<std::int64_t>(agency_epoch_s) * ns_per_s;
  }
  return chosen;
}

}  // namespace ilp
