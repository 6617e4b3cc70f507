#include "fsw/commanding/configuration.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "fsw/base/text.hpp"
#include "fsw/commanding/settings.hpp"
#include "fsw/packets/link_settings.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/packets/time_code.hpp"
#include "fsw/records/life_numbers.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find_next.hpp"

namespace ilp {
namespace {

/// The third start in a row without a confirmation takes the last good configuration, later ones built-in parameters.
constexpr std::uint32_t start_of_last_good = 3;
/// File names and telecommands have room for the numbers of this many lives.
constexpr std::int64_t most_lives = 50;
/// If the previous life is not known, numbers begin after those of all lives, at an offset from the calendar: it
/// assumes less than one keyframe per second, and less than a thousand other records.
constexpr std::int64_t calendar_base = numbers_of_a_life * most_lives;
constexpr std::int64_t calendar_begin_s = 2'145'916'800;  // 2026-01-01
constexpr std::int64_t records_per_keyframe = 1000;
constexpr std::int64_t transactions_per_s = 1024;
constexpr std::int64_t calendar_transactions = std::int64_t{1} << 32U;
constexpr TimeNs between_keeping_ns = 60 * ns_per_s;
/// A longer gap between two steps is a freeze, in which nothing could be received.
constexpr TimeNs longest_step_ns = ns_per_s;

/// Parameters that affect contact at once, besides those of [contact].
constexpr const char* deciding[] = {"link_bytes_per_s", "pass_period_s",      "pass_length_s", "pass_start_s",
                                    "pass_count",       "telecommands_per_s", "authentication"};

const ParameterInfo& epoch_info() {
  return parameter_info(find_parameter("link", "mission_epoch_s"));
}

std::size_t index_of(std::uint64_t number) {
  return find_parameter(number);
}

}  // namespace

bool needs_trial(std::size_t parameter) {
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

void Configuration::check_own() {
  if (guard_.check(own_) != GuardFinding::lost) return;
  // Both copies are damaged. The small memory has most of the content, and a start restores the rest.
  own_.restart_wanted = true;
  report({StatusCode::memory_lost, 0});
}

Status Configuration::begin(Store& store, const ConfigurationStart& start) {
  const Use use(*this);
  store_ = &store;
  own_ = {};
  own_.base = mission_;
  own_.most_storage_mib = start.most_storage_mib;
  own_.commanded = start.commanded;
  news_.clear();
  if (!start.loaded.ok() && !start.loaded.is(StatusCode::not_found)) {
    report({StatusCode::memory_lost, static_cast<std::int64_t>(start.loaded.code), start.loaded.a});
  }
  ILP_TRY(find_identity(start));
  FlightMemoryContent after = memory_.content();
  ILP_TRY(take_settings(after));
  own_.unconfirmed = after.starts_unconfirmed;
  if (own_.commanded) ++after.starts_unconfirmed;
  own_.trial_ns = after.trial_ns;
  keep(after);
  const std::uint32_t number = own_.commanded ? own_.unconfirmed + 1 : 1;
  look_at_trial();
  if (number == start_of_last_good && own_.trials > 0) revert(RevertReason::many_starts);
  enter(number < start_of_last_good    ? ConfigurationStage::as_set
        : number == start_of_last_good ? ConfigurationStage::last_good
                                       : ConfigurationStage::built_in);
  // The settings come from the small memory. The store's records of them are only for the ground.
  static_cast<void>(write_settings());
  return {};
}

Status Configuration::find_identity(const ConfigurationStart& start) {
  Status found = get(*store_, 1, own_.identity);
  if (!found.ok() && !is_gone(found)) return found;
  FlightMemoryContent after = memory_.content();
  if (found.is(StatusCode::not_found)) {
    ILP_TRY(begin_life(start));
  } else if (found.ok()) {
    if (after.life < own_.identity.life) {
      after.life = own_.identity.life;
      after.keyframe_base = own_.identity.keyframe_base;
      after.record_base = own_.identity.record_base;
      keep(after);
    }
  } else {
    // It is damaged: the small memory knows it, or else the keyframes themselves.
    own_.identity = {};
    own_.identity.life = after.life;
    own_.identity.keyframe_base = after.keyframe_base;
    own_.identity.record_base = after.record_base;
    KeyframeRecord newest;
    if (after.life == 0 && last(*store_, newest).ok()) {
      own_.identity.keyframe_base = own_.identity.record_base = newest.id - newest.id % numbers_of_a_life;
      own_.identity.life = own_.identity.keyframe_base / numbers_of_a_life + 1;
    }
    Transaction transaction(*store_);
    ILP_TRY(transaction.begin());
    ILP_TRY(put(*store_, own_.identity));
    ILP_TRY(transaction.commit());
  }
  store_->number_from(own_.identity.keyframe_base, own_.identity.record_base);
  return {};
}

Status Configuration::begin_life(const ConfigurationStart& start) {
  FlightMemoryContent after = memory_.content();
  const bool known = start.loaded.ok() || (start.loaded.is(StatusCode::not_found) && !start.another_before);
  own_.identity = {};
  own_.identity.life = ++after.life;
  after.keyframe_base = after.record_base = (after.life - 1) * numbers_of_a_life;
  keep(after);
  // A first life needs no memory of it. If the content could not be kept, numbers begin where the next start will not.
  const bool kept = memory_.kept().ok() || (known && after.life == 1 && !start.another_before);
  if ((!known || !kept || after.life > most_lives) && start.utc_s > 0) {
    const std::int64_t since_s = std::max<std::int64_t>(start.utc_s - calendar_begin_s, 0);
    after.keyframe_base = calendar_base + since_s;
    after.record_base = after.keyframe_base * records_per_keyframe;
    memory_.skip_transactions(calendar_transactions + since_s * transactions_per_s);
    keep(after);
  }
  own_.identity.keyframe_base = after.keyframe_base;
  own_.identity.record_base = after.record_base;
  own_.identity.configuration = after.configuration;
  Transaction transaction(*store_);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(*store_, own_.identity));
  ILP_TRY(transaction.commit());
  if (own_.identity.keyframe_base > 0)
    report({StatusCode::life_begun, own_.identity.life, own_.identity.keyframe_base + 1});
  return {};
}

Status Configuration::take_settings(FlightMemoryContent& after) {
  // The store is ahead when a telecommand was interrupted between the two writes, or when the small memory was lost.
  if (own_.identity.configuration <= after.configuration) return {};
  const bool lost = after.configuration == 0;
  after.wanted = {};
  SettingRecord setting;
  // Bounded by the number of settings. A damaged one is left out and lost.
  for (;;) {
    Found found{};
    ILP_TRY(find_next(*store_, setting.id, setting, found));
    if (found == Found::nothing) break;
    if (found == Found::damaged) continue;
    const bool epoch = setting.id == epoch_info().number;
    if (epoch && (lost || after.epoch_known == 0 || setting.value == after.mission_epoch_s)) continue;
    static_cast<void>(after.wanted.set(static_cast<std::uint64_t>(setting.id), setting.value));
  }
  // It is not known what was confirmed. All settings count as good, because the flight has flown with them.
  if (lost) after.good = after.wanted;
  after.configuration = own_.identity.configuration;
  return {};
}

Status Configuration::write_settings() {
  const FlightMemoryContent& content = memory_.content();
  KeptSettings rows = content.wanted;
  const std::uint64_t epoch = epoch_info().number;
  if (rows.find(epoch) == nullptr && content.epoch_known != 0)
    static_cast<void>(rows.set(epoch, content.mission_epoch_s));
  Transaction transaction(*store_);
  bool begun = false;
  const auto open = [&]() -> Status {
    if (begun) return {};
    begun = true;
    return transaction.begin();
  };
  SettingRecord setting;
  for (;;) {
    Found found{};
    ILP_TRY(find_next(*store_, setting.id, setting, found));
    if (found == Found::nothing) break;
    const auto number = static_cast<std::uint64_t>(setting.id);
    const KeptSetting* const row = rows.find(number);
    if (row != nullptr && found == Found::sound && row->value == setting.value) {
      rows.remove(number);
    } else if (row == nullptr && number != epoch) {
      ILP_TRY(open());
      ILP_TRY(store_->erase(record_info<SettingRecord>(), setting.id));
    }
  }
  for (std::size_t i = 0; i < rows.count; ++i) {
    const std::size_t index = index_of(rows.items[i].number);
    if (index == parameter_count()) continue;
    ILP_TRY(open());
    ILP_TRY(write_setting(*store_, index, rows.items[i].value, 0));
  }
  if (!begun && own_.identity.configuration == content.configuration) return {};
  ILP_TRY(open());
  IdentityRecord after = own_.identity;
  after.configuration = content.configuration;
  ILP_TRY(put(*store_, after));
  ILP_TRY(transaction.commit());
  own_.identity = after;
  return {};
}

MissionParameters Configuration::put_above(const KeptSettings& settings, bool report_ignored) {
  MissionParameters mission = own_.base;
  bool told = !report_ignored;
  for (std::size_t i = 0; i < settings.count; ++i) {
    const KeptSetting& setting = settings.items[i];
    if (set_parameter(mission, index_of(setting.number), setting.value).ok() || told) continue;
    told = true;
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

MissionParameters Configuration::built_in() {
  const MissionParameters& good = own_.good;
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
  if (own_.base.link_bytes_per_s > 0) mission.link_bytes_per_s = own_.base.link_bytes_per_s;
  // The stored data stays stored.
  const auto keep = [&](auto MissionParameters::*value) {
    mission.*value = std::max(mission.*value, own_.wanted.*value);
  };
  keep(&MissionParameters::storage_budget_mib);
  keep(&MissionParameters::frame_share);
  keep(&MissionParameters::depth_share);
  keep(&MissionParameters::product_share);
  keep(&MissionParameters::history_frames);
  keep(&MissionParameters::history_keyframes);
  if (own_.most_storage_mib > 0)
    mission.storage_budget_mib = std::min(mission.storage_budget_mib, own_.most_storage_mib);
  // The flight continues with the camera with which it began.
  CameraRecord camera;
  mission.camera_known = own_.base.camera_known;
  if (get_camera(*store_, camera_id, camera).ok()) {
    mission.camera_known = get(*store_, nominal_camera_id, camera).is(StatusCode::not_found);
  }
  return mission;
}

void Configuration::enter(ConfigurationStage stage) {
  own_.stage = stage;
  const FlightMemoryContent& content = memory_.content();
  own_.good = put_above(content.good, false);
  own_.wanted = put_above(content.wanted, true);
  if (stage == ConfigurationStage::built_in) {
    own_.wanted = built_in();
    report({StatusCode::defaults_in_force, own_.unconfirmed + 1});
  }
  mission_ = own_.wanted;
  look_at_trial();
}

Status Configuration::step_down(const Status& fault) {
  const Use use(*this);
  const bool of_the_store = fault.is(StatusCode::store_error) || fault.is(StatusCode::io_error) ||
                            fault.is(StatusCode::store_full) || fault.is(StatusCode::store_damaged) ||
                            fault.is(StatusCode::record_damaged);
  if (of_the_store || own_.trials == 0 || own_.stage != ConfigurationStage::as_set) return fault;
  revert(RevertReason::start_failed);
  enter(ConfigurationStage::last_good);
  static_cast<void>(write_settings());
  return {};
}

void Configuration::epoch_is(double epoch_s) {
  const Use use(*this);
  FlightMemoryContent after = memory_.content();
  if (after.wanted.find(epoch_info().number) == nullptr) {
    own_.base.mission_epoch_s = own_.good.mission_epoch_s = own_.wanted.mission_epoch_s = epoch_s;
    if (after.epoch_known == 0 || after.mission_epoch_s != epoch_s) {
      after.mission_epoch_s = epoch_s;
      after.epoch_known = 1;
      keep(after);
    }
  }
  mission_.mission_epoch_s = epoch_s;
}

bool Configuration::on_trial(const FlightMemoryContent& content, std::size_t index) const {
  const KeptSetting* const wanted = content.wanted.find(parameter_info(index).number);
  if (wanted == nullptr) return false;
  const KeptSetting* const good = content.good.find(parameter_info(index).number);
  return wanted->value != (good != nullptr ? good->value : parameter_value(own_.base, index));
}

bool Configuration::acted(const FlightMemoryContent& content, std::size_t index) const {
  const KeptSetting* const wanted = content.wanted.find(parameter_info(index).number);
  return wanted != nullptr && parameter_value(mission_, index) == wanted->value;
}

void Configuration::look_at_trial() {
  own_.trials = 0;
  own_.trial_acts = false;
  const FlightMemoryContent& content = memory_.content();
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    if (!on_trial(content, i)) continue;
    ++own_.trials;
    own_.trial_acts = own_.trial_acts || acted(content, i);
  }
}

void Configuration::revert(RevertReason reason) {
  FlightMemoryContent after = memory_.content();
  const auto number = static_cast<std::int64_t>(own_.trials);
  after.wanted = after.good;
  after.trial_ns = own_.trial_ns = 0;
  after.configuration = std::max(after.configuration, own_.identity.configuration) + 1;
  keep(after);
  report({StatusCode::configuration_reverted, static_cast<std::int64_t>(reason), number});
  look_at_trial();
}

Status Configuration::check(const MissionParameters& wanted, TimeNs now) const {
  const std::int64_t utc_s = MissionTime(mission_.mission_epoch_s).utc(now) / ns_per_s;
  const auto later = [&](double epoch_s) { return epoch_s > static_cast<double>(utc_s); };
  if (wanted.mission_epoch_s != own_.wanted.mission_epoch_s && later(wanted.mission_epoch_s)) {
    return {StatusCode::parameters_contradict, 14};
  }
  const bool changed = wanted.agency_epoch_s != own_.wanted.agency_epoch_s || wanted.cuc_time != own_.wanted.cuc_time ||
                       wanted.tailoring != own_.wanted.tailoring;
  const TimeFormat format = LinkSettings(wanted).tailoring.time;
  if (changed && format.code == TimeCode::cuc_agency && later(wanted.agency_epoch_s)) {
    return {StatusCode::parameters_contradict, 15};
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

void Configuration::settle(const MissionParameters& wanted, Way way) {
  const Use use(*this);
  FlightMemoryContent after = memory_.content();
  bool any = false, new_trial = false;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const double value = parameter_value(wanted, i);
    if (value == parameter_value(own_.wanted, i)) continue;
    any = true;
    const std::uint64_t number = parameter_info(i).number;
    // There are never more settings than parameters. A setting without room is in the store.
    static_cast<void>(after.wanted.set(number, value));
    const bool trial = way == Way::file || (way == Way::parameters && needs_trial(i));
    if (!trial) static_cast<void>(after.good.set(number, value));
    new_trial = new_trial || trial;
    if (parameter_info(i).acts == Acts::at_once) static_cast<void>(set_parameter(mission_, i, value));
  }
  if (!any) return;
  own_.identity.configuration = after.configuration = std::max(own_.identity.configuration, after.configuration) + 1;
  if (new_trial) after.trial_ns = own_.trial_ns = 0;
  own_.wanted = wanted;
  keep(after);
  own_.good = put_above(after.good, false);
  look_at_trial();
}

void Configuration::confirm() {
  const Use use(*this);
  if (own_.proven && own_.trials == 0) return;
  FlightMemoryContent after = memory_.content();
  std::int64_t confirmed = 0;
  // A ground that cannot be answered does not know of it.
  const bool answered = mission_.link_bytes_per_s > 0;
  for (std::size_t i = 0; answered && i < parameter_count(); ++i) {
    if (!on_trial(after, i) || !acted(after, i)) continue;
    static_cast<void>(after.good.set(parameter_info(i).number, parameter_value(mission_, i)));
    ++confirmed;
  }
  if (answered) after.trial_ns = own_.trial_ns = 0;
  if (own_.proven && confirmed == 0) return;
  after.starts_unconfirmed = 0;
  own_.proven = true;
  keep(after);
  if (confirmed == 0) return;
  own_.good = put_above(after.good, false);
  look_at_trial();
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
  const bool tried = own_.commanded && own_.trial_acts && own_.stage != ConfigurationStage::built_in;
  // The parameters on trial may define contact itself, so the contact of the good configuration counts.
  if (tried && contact_at(own_.good, now).open) own_.trial_ns += passed;
  bool reverted = false;
  if (tried && own_.trial_ns >= patience_ns) {
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
    look_at_trial();
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
  after.trial_ns = own_.trial_ns;
  own_.kept_ns = now;
  keep(after);
  return reverted;
}

void Configuration::end_in_order(TimeNs now) {
  const Use use(*this);
  FlightMemoryContent after = memory_.content();
  after.latest_ns = std::max(after.latest_ns, now);
  after.trial_ns = own_.trial_ns;
  // A built-in configuration stays until a telecommand is received.
  if (own_.stage != ConfigurationStage::built_in && !own_.restart_wanted) after.starts_unconfirmed = 0;
  keep(after);
}

Status Configuration::news() {
  if (news_.empty()) return {};
  const Status first = news_[0];
  for (std::size_t i = 0; i + 1 < news_.size(); ++i) news_[i] = news_[i + 1];
  news_.pop_back();
  return first;
}

}  // namespace ilp
