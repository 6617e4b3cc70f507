#include "bsp/flight/mission_epoch.hpp"

#include <algorithm>

#include "fsw/base/text.hpp"
#include "fsw/packets/time_code.hpp"
#include "fsw/records/records.hpp"

namespace ilp {
namespace {

constexpr const char* section = "link";
constexpr const char* key = "mission_epoch_s";

std::int64_t setting_id() {
  return parameter_info(find_parameter(section, key)).number;
}

Status keep(Store& store, double epoch_s) {
  SettingRecord setting;
  setting.id = setting_id();
  FixedText<sizeof(setting.name)> name;
  name.add(section).add('.').add(key);
  copy_text(setting.name, name.c_str());
  setting.value = epoch_s;
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, setting));
  return transaction.commit();
}

template <typename Record>
Status check(Store& store, TimeNs Record::*member, TimeNs& latest) {
  Record record;
  const Status found = last(store, record);
  // Other records have a time that is hardly earlier.
  if (is_gone(found)) return {};
  ILP_TRY(found);
  latest = std::max(latest, record.*member);
  return {};
}

}  // namespace

Status begin_mission_time(Store& store, FlightMemory& memory, EpochChoice choice, std::int64_t utc,
                          MissionParameters& mission, MissionTimeBegin& begin) {
  SettingRecord known;
  const Status found = get(store, setting_id(), known);
  if (!found.ok() && !is_gone(found)) return found;
  const FlightMemoryContent& kept = memory.content();
  double epoch_s = found.ok() ? known.value : kept.epoch_known != 0 ? kept.mission_epoch_s : mission.mission_epoch_s;
  if (!found.ok() && kept.epoch_known == 0 && choice == EpochChoice::first_start) {
    const std::int64_t whole_seconds = utc / ns_per_s;
    const ParameterInfo& info = parameter_info(find_parameter(section, key));
    // A calendar clock that is later than any epoch is wrong.
    const auto today_s = static_cast<double>(whole_seconds);
    if (today_s <= info.maximum) epoch_s = today_s;
  }
  ILP_TRY(set_parameter(mission, section, key, epoch_s));
  TimeNs latest = 0;
  ILP_TRY(latest_known_time(store, latest));
  latest = std::max(latest, kept.latest_ns);
  const TimeNs reported = MissionTime(epoch_s).mission(utc);
  begin = {};
  if (reported > longest_duration_ns) {
    begin.now = latest;
    begin.updates = {StatusCode::time_out_of_range, utc / (seconds_per_day * ns_per_s), reported / ns_per_s};
    return found.ok() ? Status{} : keep(store, epoch_s);
  }
  begin.now = std::max(reported, latest);
  if (reported < latest) begin.updates = {StatusCode::clock_behind, (latest - reported) / ns_per_s, latest / ns_per_s};
  return found.ok() ? Status{} : keep(store, epoch_s);
}

bool LateCalendar::caught_up(std::int64_t utc, const MissionParameters& mission, TimeNs now, TimeNs& time,
                             Status& updates) {
  if (!behind_) return false;
  time = MissionTime(mission.mission_epoch_s).mission(utc);
  if (time <= now || time > longest_duration_ns) return false;
  behind_ = false;
  updates = {StatusCode::clock_caught_up, (time - now) / ns_per_s, time / ns_per_s};
  return true;
}

Status latest_known_time(Store& store, TimeNs& time) {
  time = 0;
  ILP_TRY(check(store, &FrameRecord::time_ns, time));
  ILP_TRY(check(store, &EventRecord::time_ns, time));
  ILP_TRY(check(store, &DownlinkRecord::sent_ns, time));
  return check(store, &StartRecord::alive_ns, time);
}

}  // namespace ilp
