#include "fsw/commanding/configuration.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "cfg/relations.hpp"
#include "fsw/commanding/settings.hpp"
#include "fsw/packets/link_settings.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/packets/time_code.hpp"
#include "fsw/shared/camera_on_record.hpp"

namespace ilp {
namespace {

constexpr TimeNs between_keeping_ns = 60 * ns_per_s;
/// A longer gap between two steps is a freeze, in which nothing could be received.
constexpr TimeNs longest_step_ns = ns_per_s;

/// Parameters that affect contact at once, besides those of [contact].
constexpr const char* deciding[] = {"link_bytes_per_s", "pass_period_s",      "pass_length_s", "pass_start_s",
                                    "pass_count",       "telecommands_per_s", "authentication"};

bool tentative(const FlightMemoryContent& content, std::size_t index, const MissionParameters& base) {
  const KeptSetting* const wanted = content.wanted.find(parameter_info(index).number);
  const KeptSetting* const good = content.good.find(parameter_info(index).number);
  return wanted != nullptr && wanted->value != (good != nullptr ? good->value : parameter_value(base, index));
}

/// Whether what is wanted is in force.
bool acts(const FlightMemoryContent& content, std::size_t index, const MissionParameters& mission) {
  const KeptSetting* const wanted = content.wanted.find(parameter_info(index).number);
  return wanted != nullptr && parameter_value(mission, index) == wanted->value;
}

/// Parameters of the software itself, with what the ground knows the package by.
MissionParameters built_in(const ConfigurationState& own, Reader<CameraRecord> store) {
  const MissionParameters& good = own.good;
  MissionParameters mission;
  // The ground identifies the package by these names and keys.
  mission.cfdp_entity = good.cfdp_entity;
  mission.cfdp_ground_entity = good.cfdp_ground_entity;
  mission.apid = good.apid;
  mission.tailoring = good.tailoring;
  mission.cuc_time = good.cuc_time;
  mission.mission_epoch_s = good.mission_epoch_s;
  mission.agency_epoch_s = good.agency_epoch_s;
  mission.authentication = good.authentication;
  mission.seed = good.seed;
  if (own.base.link_bytes_per_s > 0) mission.link_bytes_per_s = own.base.link_bytes_per_s;
  // The stored data stays stored.
  const auto keep = [&](auto MissionParameters::*value) {
    mission.*value = std::max(mission.*value, own.wanted.*value);
  };
  keep(&MissionParameters::storage_budget_mib);
  keep(&MissionParameters::frame_share);
  keep(&MissionParameters::depth_share);
  keep(&MissionParameters::product_share);
  keep(&MissionParameters::history_frames);
  keep(&MissionParameters::history_keyframes);
  if (own.most_storage_mib > 0) mission.storage_budget_mib = std::min(mission.storage_budget_mib, own.most_storage_mib);
  // The flight continues with the camera with which it began.
  CameraRecord camera;
  mission.camera_known = own.base.camera_known;
  mission.lens_known = own.base.lens_known;
  mission.readout_sigma_s = own.base.readout_sigma_s;
  if (!get_camera(store, camera_id, camera).ok()) return mission;
  const bool known = get(store, nominal_camera_id, camera).is(StatusCode::not_found);
  if (known) mission.camera_known = mission.lens_known = true;
  if (known) mission.readout_sigma_s = 0;
  if (!known && mission.lens_known && !(mission.readout_sigma_s > 0)) mission.camera_known = false;
  return mission;
}

}  // namespace

std::uint64_t epoch_number() {
  return parameter_info(find_parameter("link", "mission_epoch_s")).number;
}

bool needs_confirmation(std::size_t parameter) {
  const ParameterInfo& info = parameter_info(parameter);
  if (info.acts == Acts::next_start || std::strcmp(info.section, "contact") == 0) return true;
  return std::any_of(std::begin(deciding), std::end(deciding),
                     [&](const char* key) { return std::strcmp(info.key, key) == 0; });
}

void Configuration::keep(const FlightMemoryContent& content) {
  const Status kept = memory_.keep(content);
  if (kept.ok() || own_.reported_not_kept) return;
  own_.reported_not_kept = true;
  report({StatusCode::memory_not_kept, static_cast<std::int64_t>(kept.code), kept.a});
}

Configuration::Use::Use(Configuration& user) : configuration(user) {
  if (configuration.guard_.check(configuration.own_) != GuardFinding::lost) return;
  // Both copies are damaged. The nonvolatile memory has most of the content, and a start restores the rest.
  configuration.own_.restart_wanted = true;
  configuration.report({StatusCode::memory_lost, 0});
}

MissionParameters Configuration::put_above(const KeptSettings& settings, bool report_ignored) {
  MissionParameters mission = own_.base;
  bool reported = !report_ignored;
  for (std::size_t i = 0; i < settings.count; ++i) {
    const KeptSetting& setting = settings.items[i];
    if (set_parameter(mission, find_parameter(setting.number), setting.value).ok() || reported) continue;
    reported = true;
    report({StatusCode::setting_ignored, static_cast<std::int64_t>(setting.number)});
  }
  const Status valid = validate(mission);
  if (!valid.ok()) {
    if (report_ignored) report({StatusCode::setting_ignored, 0, valid.a});
    mission = own_.base;
  }
  if (own_.most_storage_mib > 0)
    mission.storage_budget_mib = std::min(mission.storage_budget_mib, own_.most_storage_mib);
  return mission;
}

void Configuration::enter(ConfigurationStage stage) {
  own_.stage = stage;
  const FlightMemoryContent& content = memory_.content();
  own_.good = put_above(content.good, false);
  own_.wanted = put_above(content.wanted, true);
  if (stage == ConfigurationStage::built_in) {
    own_.wanted = built_in(own_, *store_);
    report({StatusCode::defaults_in_force, own_.unconfirmed + 1});
  }
  mission_ = own_.wanted;
  check_tentative();
}

Status Configuration::step_down(const Status& fault) {
  const Use use(*this);
  const bool of_the_store = fault.is(StatusCode::store_error) || fault.is(StatusCode::io_error) ||
                            fault.is(StatusCode::store_full) || fault.is(StatusCode::store_damaged) ||
                            fault.is(StatusCode::store_locked) || fault.is(StatusCode::record_damaged);
  if (of_the_store || own_.trials == 0 || own_.stage != ConfigurationStage::as_set) return fault;
  revert(RevertReason::start_failed);
  enter(ConfigurationStage::last_good);
  static_cast<void>(write_settings());
  return {};
}

void Configuration::epoch_is(double epoch_s) {
  const Use use(*this);
  FlightMemoryContent after = memory_.content();
  if (after.wanted.find(epoch_number()) == nullptr) {
    own_.base.mission_epoch_s = own_.good.mission_epoch_s = own_.wanted.mission_epoch_s = epoch_s;
    if (after.epoch_known == 0 || after.mission_epoch_s != epoch_s) {
      after.mission_epoch_s = epoch_s;
      after.epoch_known = 1;
      keep(after);
    }
  }
  mission_.mission_epoch_s = epoch_s;
}

void Configuration::check_tentative() {
  own_.trials = 0;
  own_.tentative_applies = false;
  const FlightMemoryContent& content = memory_.content();
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    if (!tentative(content, i, own_.base)) continue;
    ++own_.trials;
    own_.tentative_applies = own_.tentative_applies || acts(content, i, mission_);
  }
}

void Configuration::revert(RevertReason reason) {
  FlightMemoryContent after = memory_.content();
  const auto number = static_cast<std::int64_t>(own_.trials);
  after.wanted = after.good;
  after.tentative_ns = own_.tentative_ns = 0;
  after.configuration = std::max(after.configuration, own_.identity.configuration) + 1;
  keep(after);
  report({StatusCode::configuration_reverted, static_cast<std::int64_t>(reason), number});
  check_tentative();
}

Status Configuration::check(const MissionParameters& wanted, TimeNs now) const {
  const std::int64_t utc_s = MissionTime(mission_.mission_epoch_s).utc(now) / ns_per_s;
  const auto later = [&](double epoch_s) { return epoch_s > static_cast<double>(utc_s); };
  if (wanted.mission_epoch_s != own_.wanted.mission_epoch_s && later(wanted.mission_epoch_s)) {
    return contradiction(Relation::mission_epoch);
  }
  const bool changed = wanted.agency_epoch_s != own_.wanted.agency_epoch_s || wanted.cuc_time != own_.wanted.cuc_time ||
                       wanted.tailoring != own_.wanted.tailoring;
  const TimeFormat format = LinkSettings(wanted).tailoring.time;
  if (changed && format.code == TimeCode::cuc_agency && later(wanted.agency_epoch_s)) {
    return contradiction(Relation::agency_epoch);
  }
  return {};
}

Status Configuration::write(const MissionParameters& wanted, TimeNs now) {
  const Use use(*this);
  bool any = false;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const double value = parameter_value(wanted, i);
    if (value == parameter_value(own_.wanted, i)) continue;
    ILP_TRY(write_setting(*store_, i, value, now));
    any = true;
  }
  if (!any) return {};
  IdentityRecord after = own_.identity;
  after.configuration = std::max(own_.identity.configuration, memory_.content().configuration) + 1;
  return put(*store_, after);
}

void Configuration::accept(const MissionParameters& wanted, Way way) {
  const Use use(*this);
  FlightMemoryContent after = memory_.content();
  bool any = false, new_tentative = false;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const double value = parameter_value(wanted, i);
    if (value == parameter_value(own_.wanted, i)) continue;
    any = true;
    const std::uint64_t number = parameter_info(i).number;
    // There are never more settings than parameters. A setting without room is in the store.
    static_cast<void>(after.wanted.set(number, value));
    const bool trial = way == Way::file || (way == Way::parameters && needs_confirmation(i));
    if (!trial) static_cast<void>(after.good.set(number, value));
    new_tentative = new_tentative || trial;
    if (parameter_info(i).acts == Acts::at_once) static_cast<void>(set_parameter(mission_, i, value));
  }
  if (!any) return;
  own_.identity.configuration = after.configuration = std::max(own_.identity.configuration, after.configuration) + 1;
  if (new_tentative) after.tentative_ns = own_.tentative_ns = 0;
  own_.wanted = wanted;
  keep(after);
  own_.good = put_above(after.good, false);
  check_tentative();
}

void Configuration::confirm() {
  const Use use(*this);
  // A ground that cannot be answered does not know of it: repeated starts go on to count.
  if ((own_.proven && own_.trials == 0) || mission_.link_bytes_per_s <= 0) return;
  FlightMemoryContent after = memory_.content();
  std::int64_t confirmed = 0;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    if (!tentative(after, i, own_.base) || !acts(after, i, mission_)) continue;
    static_cast<void>(after.good.set(parameter_info(i).number, parameter_value(mission_, i)));
    ++confirmed;
  }
  after.tentative_ns = own_.tentative_ns = 0;
  if (own_.proven && confirmed == 0) return;
  after.starts_unconfirmed = 0;
  own_.proven = true;
  keep(after);
  if (confirmed == 0) return;
  own_.good = put_above(after.good, false);
  check_tentative();
  report({StatusCode::configuration_confirmed, confirmed, static_cast<std::int64_t>(own_.trials)});
}

bool Configuration::step(TimeNs now) {
  const Use use(*this);
  if (!own_.running) {
    own_.running = true;
    own_.begin_ns = own_.last_ns = own_.kept_ns = now;
  }
  const TimeNs passed = std::clamp<TimeNs>(now - own_.last_ns, 0, longest_step_ns);
  own_.last_ns = now;
  const TimeNs patience_ns = ns_from_seconds(own_.good.trial_s);
  const bool tried = own_.commanded && own_.tentative_applies && own_.stage != ConfigurationStage::built_in;
  // The tentative parameters may define contact itself, so the contact of the good configuration counts.
  if (tried && contact_at(own_.good, now).open) own_.tentative_ns += passed;
  bool reverted = false;
  if (tried && own_.tentative_ns >= patience_ns) {
    revert(RevertReason::not_confirmed);
    for (std::size_t i = 0; i < parameter_count(); ++i) {
      const double value = parameter_value(own_.good, i);
      if (value == parameter_value(mission_, i)) continue;
      if (parameter_info(i).acts == Acts::next_start) {
        own_.restart_wanted = true;
      } else {
        static_cast<void>(set_parameter(mission_, i, value));
      }
    }
    own_.wanted = own_.good;
    check_tentative();
    static_cast<void>(write_settings());
    reverted = true;
  }
  // A flight that runs this long is not in a loop of restarts.
  const bool proves = own_.commanded && !own_.proven && own_.trials == 0 &&
                      own_.stage != ConfigurationStage::built_in && now - own_.begin_ns >= patience_ns;
  if (!proves && now - own_.kept_ns < between_keeping_ns) return reverted;
  FlightMemoryContent after = memory_.content();
  if (proves) after.starts_unconfirmed = 0;
  own_.proven = own_.proven || proves;
  after.latest_ns = std::max(after.latest_ns, now);
  after.tentative_ns = own_.tentative_ns;
  own_.kept_ns = now;
  keep(after);
  return reverted;
}

void Configuration::end_in_order(TimeNs now) {
  const Use use(*this);
  FlightMemoryContent after = memory_.content();
  after.latest_ns = std::max(after.latest_ns, now);
  after.tentative_ns = own_.tentative_ns;
  // A built-in configuration stays until a telecommand is received.
  if (own_.stage != ConfigurationStage::built_in && !own_.restart_wanted) after.starts_unconfirmed = 0;
  keep(after);
}

Status Configuration::updates() {
  if (updates_.empty()) return {};
  const Status first = updates_[0];
  updates_.erase(0);
  return first;
}

}  // namespace ilp
